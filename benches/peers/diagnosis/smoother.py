"""Modal states and tip force from a measured displacement: Kalman filter and Rauch-Tung-Striebel smoother.

State (q_1, q_2, q_1', q_2', F): modal equations (Stelter 1992, eqs. 1-6) with a force that walks at random, F' = white noise, as in
Lourens and others 2012, Mech. Syst. Signal Process. 29:310. A first pass with one walk finds where the tip moves with the belt; a second one
knows that w' = v_belt there, and lets the force jump only at the ends of sticks. The walks and the sensor's noise maximise the likelihood.
Natural frequencies are taken as stated: against a force that walks at random their likeliest values are off by several percent (tried).
"""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from scipy.linalg import expm
from scipy.ndimage import binary_closing, binary_opening
from scipy.optimize import minimize

JUMP = 0.5  # standard deviation of the force's change per sample at the ends of sticks, over the normal force
STICK_SD = 2e-4  # of w' - v_belt in stick, m/s
SHORTEST = 5  # samples of a stick
NEAR = 0.03, 0.004  # |w' - v_belt| in stick: share of the belt's speed, and m/s


@dataclass
class Smoothed:
    """Per sample: q and q' (m, m/s), tip force (N), w' (m/s), contact (0 stick, -1 and 1 slip), belt travel (m)."""

    q: np.ndarray
    v: np.ndarray
    force: np.ndarray
    speed: np.ndarray
    mode: np.ndarray
    travel: np.ndarray
    edge: np.ndarray  # distance to the nearest change of contact, samples


def transition(rig, dt):
    """Matrix exponential of the modal equations with a constant force over one sample."""
    w, phi = 2 * np.pi * np.array(rig.frequencies[:2]), rig.tip_values()[:2]
    a = np.zeros((5, 5))
    a[:2, 2:4] = np.eye(2)
    a[2:4, :2], a[2:4, 2:4] = -np.diag(w**2), -np.diag(2 * np.array(rig.damping[:2]) * w)
    a[2:4, 4] = phi / rig.mass
    return expm(a * dt), phi


@njit(cache=True)
def _filter(y, a, phi, walk, noise, belt, stick, stick_sd, x0, p0):
    """Filtered and predicted means and covariances, and the log likelihood of y. The measurements are taken one by one."""
    n = y.size
    xf, pf = np.empty((n, 5)), np.empty((n, 5, 5))
    xp, pp = np.empty((n, 5)), np.empty((n, 5, 5))
    x, p, likelihood = x0.copy(), p0.copy(), 0.0
    for i in range(n):
        if i > 0:
            x = a @ x
            p = a @ p @ a.T
            p[4, 4] += walk[i] ** 2
        xp[i], pp[i] = x, p
        for k in range(2 if stick[i] else 1):
            h = np.zeros(5)
            h[2 * k], h[2 * k + 1] = phi[0], phi[1]
            variance = noise**2 if k == 0 else stick_sd**2
            gain = p @ h
            s = h @ gain + variance
            e = (y[i] if k == 0 else belt) - h @ x
            gain /= s
            x = x + gain * e
            p = p - np.outer(gain, gain) * s
            likelihood -= 0.5 * (e * e / s + np.log(s))
        p = 0.5 * (p + p.T)
        xf[i], pf[i] = x, p
    return xf, pf, xp, pp, likelihood


def _backward(a, xf, pf, xp, pp):
    x = xf.copy()
    for i in range(len(xf) - 2, -1, -1):
        gain = np.linalg.solve(pp[i + 1], a @ pf[i]).T
        x[i] = xf[i] + gain @ (x[i + 1] - xp[i + 1])
    return x


def _start(rig, run):
    """The tip at its first place under a steady force, loosely believed; the scales are the record's."""
    w, phi = 2 * np.pi * np.array(rig.frequencies[:2]), rig.tip_values()[:2]
    load = 0.6 * run.normal
    x0 = np.array([run.w[0] / phi[0], 0.0, 0.0, 0.0, 0.0])
    bend = load * np.abs(phi) / rig.mass / w**2
    return x0, np.diag(np.array([*bend, *(bend * w), load]) ** 2)


def _pass(rig, run, walk, noise, stick=None):
    a, phi = transition(rig, run.dt)
    stick = np.zeros(run.t.size, bool) if stick is None else stick
    return a, _filter(run.w, a, phi, walk, noise, run.belt, stick, STICK_SD, *_start(rig, run))


@dataclass
class Levels:
    """Random walks (N per sample and newton of normal force) without and with knowledge of the sticks, and the noise (m)."""

    walk: float
    calm: float
    noise: float


def _maximise(cost, begin, steps, evaluations):
    simplex = np.vstack([begin, begin + np.diag(steps)])
    options = {"initial_simplex": simplex, "maxfev": evaluations, "xatol": 0.01, "fatol": 0.3}
    return minimize(cost, begin, method="Nelder-Mead", options=options).x


def calibrate(rig, runs, samples=2000):
    """Levels that maximise the likelihood of the runs' beginnings, pass by pass."""
    short = [replace(run, t=run.t[:samples], w=run.w[:samples]) for run in runs]

    def first(u):
        walk, noise = np.exp(u)
        return -sum(_pass(rig, run, np.full(run.t.size, walk * run.normal), noise)[1][4] for run in short)

    walk, noise = np.exp(_maximise(first, np.log([0.06, 3e-7]), [0.5, 1.0], 60))
    modes = [_segment(rig, run, walk, noise) for run in short]

    def second(u):
        return -sum(_informed(rig, run, np.exp(u[0]), noise, mode)[1][4] for run, mode in zip(short, modes))

    calm = float(np.exp(_maximise(second, np.log([0.3 * walk]), [0.7], 30)[0]))
    return Levels(float(walk), calm, float(noise))


def contacts(speed, belt):
    """Contact per sample: 0 where w' keeps to the belt's velocity for SHORTEST samples at least, else the sign of v_r."""
    close = np.abs(speed - belt) < NEAR[0] * abs(belt) + NEAR[1]
    stick = binary_opening(binary_closing(close, np.ones(3)), np.ones(SHORTEST))
    return np.where(stick, 0, np.where(speed > belt, 1, -1))


def _changes(mode):
    change = np.zeros(mode.size, bool)
    change[1:] = mode[1:] != mode[:-1]
    return change


def _segment(rig, run, walk, noise):
    a, found = _pass(rig, run, np.full(run.t.size, walk * run.normal), noise)
    return contacts(_backward(a, *found[:4])[:, 2:4] @ rig.tip_values()[:2], run.belt)


def _informed(rig, run, calm, noise, mode):
    """The pass that knows the sticks: the force walks calmly within a mode and jumps at its ends."""
    near = np.convolve(_changes(mode), np.ones(4), "same") > 0
    return _pass(rig, run, run.normal * np.where(near, JUMP, calm), noise, (mode == 0) & ~near)


def smooth(rig, run, levels):
    """Both passes over one run; levels as calibrate() gives them."""
    phi = rig.tip_values()[:2]
    mode = _segment(rig, run, levels.walk, levels.noise)
    a, found = _informed(rig, run, levels.calm, levels.noise, mode)
    x = _backward(a, *found[:4])
    speed = x[:, 2:4] @ phi
    where = np.flatnonzero(_changes(mode))
    index = np.arange(mode.size)
    edge = np.min(np.abs(index[:, None] - where[None, :]), axis=1) if where.size else np.full(mode.size, mode.size)
    slip = np.where(mode == 0, 0.0, run.belt - speed)
    return Smoothed(x[:, :2], x[:, 2:4], x[:, 4], speed, mode, np.cumsum(slip) * run.dt, edge)
