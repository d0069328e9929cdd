"""Peer (c): the slip force without a law, as a ceiling; it names nothing.

    F = -sgn(v_r) F_N f(x) [1 + g(s) + h(t)],   x = (ln(1 + |v_r|/0.02 m/s), w, w', F_N)

f is a Gaussian process (Rasmussen, Williams 2006): length scales and noise by maximum likelihood on some rows, then all rows through inducing
points (subset of regressors, ibid. 8.3.1). g and h are splines over the place on the belt and over time, of each run by itself, by ridge
regression; how stiff they are, or that there are none, is decided on learned blocks that their fit leaves out. In stick the force is the
constraint force, up to f at v_r = 0, where the ends of sticks are learned too.
"""

import math
from dataclasses import dataclass

import numpy as np
from forecast import fitted_error, scales, windows
from library import rows
from numba import njit
from scipy.interpolate import CubicSpline
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sindy import tune
from smoother import smooth

SPEED = 0.02  # m/s
SEEN, INDUCING = 300, 150  # rows for the maximum likelihood, and inducing points
PLACE, TIME = 0.004, 0.03  # node distances of the splines, m and s
RIDGES = 0.02, 0.3, None  # None: no spline
BEFORE, LONG = 2, 10  # samples from the end of a stick, where the smoothed force is not yet bent, and its least length
FAR = 4.0  # spreads of what is left
LEFT_OUT = 2  # runs, for the error on runs never seen
SUBSTEPS = 5  # of integration per sample


@dataclass
class Process:
    """f(x) = mean + sum of k(x, points) alpha; points over the length scales."""

    scale: np.ndarray
    points: np.ndarray
    alpha: np.ndarray
    mean: float

    def at(self, x):
        d = ((x / self.scale)[:, None, :] - self.points[None]) ** 2
        return self.mean + np.exp(-0.5 * d.sum(axis=2)) @ self.alpha


def inputs(r):
    return np.column_stack([np.log1p(r.v / SPEED), 1e3 * r.w, r.wd, 1e-2 * r.normal])


def break_aways(runs, smoothed, phi):
    """Rows like inputs() with v_r = 0 and the force over F_N where learned sticks end, and the runs they are of."""
    x, y, of = [], [], []
    for i, (run, s) in enumerate(zip(runs, smoothed)):
        ends = np.flatnonzero((s.mode[:-1] == 0) & (s.mode[1:] != 0) & ~run.kept_out()[:-1]) - BEFORE
        ends = np.array([k for k in ends if k >= LONG and not s.mode[k - LONG : k].any()], int)
        x += [[0.0, 1e3 * (s.q[k] @ phi), run.belt, 1e-2 * run.normal] for k in ends]
        y += [abs(s.force[k]) / run.normal for k in ends]
        of += [i] * ends.size
    return np.array(x).reshape(-1, 4), np.array(y), np.array(of, int)


def learn(x, y, seed=0):
    """A Process on rows x with forces y over F_N; rows far from it are dropped and it is learned once more."""
    process = _learn(x, y, seed)
    left = np.abs(y - process.at(x))
    near = left < FAR * 1.4826 * np.median(left)
    return _learn(x[near], y[near], seed)


def _learn(x, y, seed):
    some = np.random.default_rng(seed).permutation(len(x))
    spread = x.std(axis=0) + 1e-9
    kernel = ConstantKernel(0.05) * RBF(spread, (1e-2, 1e3)) + WhiteKernel(1e-3, (1e-7, 1.0))
    few = some[:SEEN]
    found = GaussianProcessRegressor(kernel, normalize_y=False).fit(x[few], y[few] - y.mean()).kernel_
    variance, scale, noise = found.k1.k1.constant_value, found.k1.k2.length_scale, found.k2.noise_level
    points = x[some[:INDUCING]] / scale

    def k(a):
        return variance * np.exp(-0.5 * np.sum((a[:, None, :] - points[None]) ** 2, axis=2))

    cross, inner = k(x / scale), k(points)
    a = cross.T @ cross + noise * (inner + 1e-8 * variance * np.eye(len(points)))
    alpha = np.linalg.lstsq(a, cross.T @ (y - y.mean()), rcond=None)[0]
    return Process(scale, points, variance * alpha, float(y.mean()))


def _basis(x, distance, size):
    """Cardinal cubic splines, periodic beyond the range."""
    grid = np.vstack([np.eye(size), np.eye(size)[:1]])
    return CubicSpline(np.arange(size + 1) * distance, grid, bc_type="periodic")(x)


def own_splines(s, t, ratio, blocks):
    """(nodes of g, nodes of h) of a run from its learned rows; ratio: force over f, less 1."""
    sizes = int(np.ceil(s.max() / PLACE)) + 3, int(np.ceil(t.max() / TIME)) + 3
    x = np.column_stack([_basis(s, PLACE, sizes[0]), _basis(t, TIME, sizes[1])])

    def fit(use, ridge):
        a = x[use].T @ x[use]
        return np.linalg.solve(a + ridge * np.trace(a) / len(a) * np.eye(len(a)), x[use].T @ ratio[use])

    half = blocks // 2 % 2 == 0
    best, least = None, np.median(np.abs(ratio[~half])) if (~half).any() else 0.0
    for ridge in RIDGES[:-1]:
        error = np.median(np.abs(ratio - x @ fit(half, ridge))[~half]) if half.any() and (~half).any() else np.inf
        if error < least:
            best, least = ridge, error
    nodes = np.zeros(sum(sizes)) if best is None else fit(np.ones(s.size, bool), best)
    return nodes[: sizes[0]], nodes[sizes[0] :]


def spline(nodes, distance):
    """Coefficients (4, n) of the periodic cubic through the nodes."""
    return np.ascontiguousarray(CubicSpline(np.arange(nodes.size + 1) * distance, np.append(nodes, nodes[0]), bc_type="periodic").c)


@njit(cache=True)
def _spline(c, x, distance):
    k = math.floor(x / distance)
    d = x - k * distance
    k = int(k) % c.shape[1]
    return ((c[0, k] * d + c[1, k]) * d + c[2, k]) * d + c[3, k]


@njit(cache=True)
def _mu(v, w, wd, normal, s, t, scale, points, alpha, mean, g, h):
    x = (math.log1p(max(v, 0.0) / SPEED) / scale[0], 1e3 * w / scale[1], wd / scale[2], 1e-2 * normal / scale[3])
    total = mean
    for i in range(alpha.size):
        d = 0.0
        for j in range(4):
            d += (x[j] - points[i, j]) ** 2
        if d < 60.0:
            total += alpha[i] * math.exp(-0.5 * d)
    return total * (1.0 + _spline(g, s, PLACE) + _spline(h, t, TIME))


@njit(cache=True)
def _rates(t, y, mode, w2, dmp, phi, mass, belt, normal, scale, points, alpha, mean, g, h, out):
    """State (q_1, q_2, q_1', q_2', s); returns the constraint force in stick, N."""
    w, wd = phi[0] * y[0] + phi[1] * y[1], phi[0] * y[2] + phi[1] * y[3]
    free0, free1 = -dmp[0] * y[2] - w2[0] * y[0], -dmp[1] * y[3] - w2[1] * y[1]
    hold = -(phi[0] * free0 + phi[1] * free1) * mass / (phi[0] ** 2 + phi[1] ** 2)
    force = hold
    if mode != 0:
        force = -mode * normal * _mu(mode * (wd - belt), w, wd, normal, y[4], t, scale, points, alpha, mean, g, h)
    out[0], out[1] = y[2], y[3]
    out[2], out[3] = free0 + phi[0] * force / mass, free1 + phi[1] * force / mass
    out[4] = 0.0 if mode == 0 else belt - wd
    return hold


@njit(cache=True)
def _run(t, y, mode, count, dt, w2, dmp, phi, mass, belt, normal, scale, points, alpha, mean, g, h):
    """Classical Runge-Kutta steps; a change of contact counts from the end of its step, with v_r taken out."""
    out = np.empty(count + 1)
    k1, k2, k3, k4 = np.empty(5), np.empty(5), np.empty(5), np.empty(5)
    step = dt / SUBSTEPS
    pin = phi / (phi[0] ** 2 + phi[1] ** 2)
    for n in range(count + 1):
        out[n] = phi[0] * y[0] + phi[1] * y[1]
        for _ in range(SUBSTEPS):
            a = (w2, dmp, phi, mass, belt, normal, scale, points, alpha, mean, g, h)
            hold = _rates(t, y, mode, *a, k1)
            _rates(t + step / 2, y + step / 2 * k1, mode, *a, k2)
            _rates(t + step / 2, y + step / 2 * k2, mode, *a, k3)
            _rates(t + step, y + step * k3, mode, *a, k4)
            y = y + step / 6 * (k1 + 2 * (k2 + k3) + k4)
            t += step
            slip = phi[0] * y[2] + phi[1] * y[3] - belt
            if mode * slip > 0.0:
                continue
            y[2:4] -= pin * slip
            side = 1 if hold < 0.0 else -1
            w = phi[0] * y[0] + phi[1] * y[1]
            limit = normal * _mu(0.0, w, belt, normal, y[4], t, scale, points, alpha, mean, g, h)
            mode = 0 if abs(hold) <= limit else side
    return out


def _error(found, force):
    return float(np.sqrt(np.mean((found - force) ** 2)) / force.std())


def diagnose(rig, runs, levels):
    """Force errors on what was kept out (over the spread of the force as smoothed), and what a forecast needs."""
    tuned = tune(rig, runs, levels)
    smoothed = [smooth(tuned, run, levels) for run in runs]
    r = rows(runs, smoothed, tuned.tip_values()[:2])
    x, y, train = inputs(r), -r.sign * r.force, ~r.kept_out
    strange = r.run >= len(runs) - LEFT_OUT
    x0, y0, of = break_aways(runs, smoothed, tuned.tip_values()[:2])
    known = of < len(runs) - LEFT_OUT
    others = learn(np.vstack([x[train & ~strange], x0[known]]), np.concatenate([y[train & ~strange], y0[known]]))
    process = learn(np.vstack([x[train], x0]), np.concatenate([y[train], y0]))
    base, splines, predicted = process.at(x), [], np.zeros(y.size)
    for i in range(len(runs)):
        here, seen = r.run == i, (r.run == i) & train
        g, h = own_splines(r.s[seen], r.t[seen], y[seen] / base[seen] - 1, r.block[seen])
        predicted[here] = base[here] * (1 + _basis(r.s[here], PLACE, g.size) @ g + _basis(r.t[here], TIME, h.size) @ h)
        splines.append((spline(g, PLACE), spline(h, TIME)))
    out = ~train
    signed = r.sign * r.normal
    return {
        "named": None,
        "force_error_kept_out_blocks": _error((signed * predicted)[out], (signed * y)[out]),
        "force_error_without_place_and_time": _error((signed * base)[out], (signed * y)[out]),
        "force_error_runs_never_seen": _error((signed * others.at(x))[strange], (signed * y)[strange]),
        "model": (tuned, process, splines), "smoothed": smoothed,
    }


def forecast(found, runs):
    """Median one-cycle error over the windows of forecast.py."""
    rig, p, splines = found["model"]
    w2, phi = (2 * np.pi * np.array(rig.frequencies[:2])) ** 2, rig.tip_values()[:2]
    dmp = 2 * np.array(rig.damping[:2]) * np.sqrt(w2)
    errors = []
    for run, s, (g, h) in zip(runs, found["smoothed"], splines):
        for start, stop in windows(run, s):
            first = np.concatenate([s.q[start], s.v[start]])

            def predict(u, count):
                y = np.append(first + scales(rig, run) * u, s.travel[start])
                mode = 1 if phi @ y[2:4] > run.belt else -1
                return _run(run.t[start] - run.t[0], y, mode, count, run.dt, w2, dmp, phi, rig.mass, run.belt, run.normal, p.scale, p.points,
                            p.alpha, p.mean, g, h)

            errors.append(fitted_error(predict, run, start, stop))
    return float(np.median(errors)) if errors else None
