"""One-cycle forecasts of a model that simulate.py of the generator can integrate, the same windows for every peer.

A window starts in slip in a kept-out block, where the smoothed state is best, and lasts a cycle, 20 ms at least. As in the project's own shots
the modal start state is fitted to the window, so the error is that of the model: NRMSE = rms difference over the standard deviation of
what was measured in the window; the median over the windows counts.
"""

import numpy as np
from campaign import BLOCK, FIRST_FORECAST
from scipy.optimize import least_squares
from simulate import EXTRA, S, U, Y, Z, State, simulate

HORIZON = 0.02  # s, least
STEP = 2e-5  # s, of integration
BRISTLE_STEP = 1e-5  # s, with presliding_compliance
CALM_SAMPLES = 3  # distance of a start from changes of contact
WINDOWS_PER_RUN = 5
GROWING = 0.2, 0.5, 1.0  # shares of a window to which its start state is fitted one after the other
NEWTON = 40  # evaluations of each such fit
WORST = 10.0  # an error counts at most so many spreads


def cycle(run):
    """Mean time between upward passages of the mean displacement, s, with a hysteresis of half a standard deviation."""
    x = (run.w - run.w.mean()) / run.w.std()
    state = np.where(x > 0.5, 1, np.where(x < -0.5, -1, 0))
    state = state[state != 0]
    ups = int(np.sum((state[1:] == 1) & (state[:-1] == -1)))
    return (run.t[-1] - run.t[0]) / max(ups, 1)


def windows(run, smoothed):
    """(start, stop) in samples."""
    length = round(min(max(cycle(run), HORIZON), BLOCK) / run.dt)
    block = round(BLOCK / run.dt)
    good = (smoothed.mode != 0) & (smoothed.edge >= CALM_SAMPLES) & run.kept_out() & (run.t - run.t[0] >= FIRST_FORECAST)
    found = []
    for begin in range(0, run.t.size, block):
        starts = begin + np.flatnonzero(good[begin : begin + block])
        if starts.size and starts[0] + length < run.t.size:
            found.append((int(starts[0]), int(starts[0]) + length))
    return found[:WINDOWS_PER_RUN]


def state_at(rig, smoothed, i, belt):
    """A start of the rig from the smoothed states of the two modes; states that an effect adds as in steady sliding."""
    n = rig.modes()
    y = np.zeros(2 * n + EXTRA)
    y[:2], y[n : n + 2] = smoothed.q[i], smoothed.v[i]
    mode = int(smoothed.mode[i])
    y[2 * n + Y] = rig.tip_values() @ y[:n]
    y[2 * n + U] = abs(smoothed.speed[i] - belt)
    y[2 * n + S] = smoothed.travel[i]
    bristle = rig.effects.get("presliding_compliance")
    if bristle:
        y[2 * n + Z] = -smoothed.force[i] / bristle["bristle_stiffness"]
        mode = mode or -1
    return State(y, mode, stick_since=-1.0)


def step(rig):
    return BRISTLE_STEP if "presliding_compliance" in rig.effects else STEP


def scales(rig, run):
    """Changes of (q, q') that move the tip alike: 0.1 % of the record's spread."""
    size = 1e-3 * run.w.std()
    return np.concatenate([np.full(2, size), size * 2 * np.pi * np.array(rig.frequencies[:2])])


def nudge(state, u, n, scale, belt, phi):
    """The state with its first two modes moved by u; the sign of slip follows."""
    y = state.y.copy()
    y[[0, 1, n, n + 1]] += scale * u
    mode = state.mode
    if mode != 0:
        mode = 1 if phi @ y[n : 2 * n] > belt else -1
    return State(y, mode, state.stick_since, state.event_number)


def fitted_error(predict, run, start, stop):
    """NRMSE of one window after the fit of the start state. predict(u, n): n + 1 displacements (m) from the start moved by u."""
    u, spread = np.zeros(4), run.w[start : stop + 1].std()
    for share in GROWING:
        n = round(share * (stop - start))

        def residual(u):
            out = (predict(u, n) - run.w[start : start + n + 1]) / spread
            return np.clip(np.nan_to_num(out, nan=WORST, posinf=WORST, neginf=-WORST), -WORST, WORST)

        best = least_squares(residual, u, method="lm", diff_step=1e-3, x_scale=np.ones(4), max_nfev=NEWTON)
        u = best.x
    return float(np.sqrt(np.mean(best.fun**2)))


def window_error(rig, run, smoothed, start, stop, level=1.0):
    """NRMSE of a rig that simulate.py integrates."""
    first, scale, n, phi = state_at(rig, smoothed, start, run.belt), scales(rig, run), rig.modes(), rig.tip_values()

    def predict(u, count):
        state = nudge(first, u, n, scale, run.belt, phi)
        return simulate(rig, run.normal, run.belt, state, t0=run.t[start], duration=count * run.dt, level=level, substep=step(rig)).measured

    return fitted_error(predict, run, start, stop)


def forecast_error(rigs, runs, smoothed, levels):
    """Median NRMSE over all windows of all runs; rigs and levels: one of each per run."""
    errors = [window_error(rig, run, s, *window, level) for rig, run, s, level in zip(rigs, runs, smoothed, levels) for window in windows(run, s)]
    return float(np.median(errors)) if errors else None
