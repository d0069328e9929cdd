"""Terms of the slip force, one for each catalogue effect that has a regression form, and the nuisances beside them.

All are forces over F_N (1) on slip samples, F = -sgn(v_r) mu(|v_r|) F_N + terms (docs/conventions.md; fmu-src/physics/src/effects for the
equations). No regression form on slip: static_friction_aging (acts at break-away alone), presliding_compliance, third_mode,
belt_drive_compliance (each moves by a state that is not measured), sensor_lag (to first order the same term as frictional_lag).
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

LAW = "mu_s", "a1", "v1", "a2", "c2"
FREQUENCIES = np.arange(5.0, 250.0, 0.4)  # Hz, of lines over time
WAVE_NUMBERS = np.arange(10.0, 350.0, 1.0)  # 1/m, of lines over the belt's travel
DRIFT_TAU = 0.3  # s, the middle of what is plausible; the shape hardly depends on it within 0.6 s
NODE_DISTANCE, RIDGE = 0.004, 0.02  # m; of a profile along the belt
ONE_SIGN = "viscous_friction", "cubic_stiffness", "quadratic_drag", "frictional_lag", "axial_load"  # with coefficients that can't be negative
BASE_SHARE = 0.7829917687  # int phi_1 dxi of the clamped-free beam (Stelter 1992, eq. 6)
EDGE = 3  # distance of a sample from changes of contact


def law(v, rig):
    """mu(v), v >= 0 (Stelter 1992, eq. 7)."""
    return rig.mu_s * (1 - rig.a1 + rig.a1 * np.exp(-v / rig.v1)) * (1 - rig.a2 + rig.a2 * np.exp(-rig.c2 * v))


def law_slopes(v, rig):
    """d mu / d (each constant of LAW), and d mu / dv."""
    e, g = np.exp(-v / rig.v1), np.exp(-rig.c2 * v)
    one, two = 1 - rig.a1 + rig.a1 * e, 1 - rig.a2 + rig.a2 * g
    mu = rig.mu_s * one * two
    by = [mu / rig.mu_s, rig.mu_s * (e - 1) * two, rig.mu_s * rig.a1 * e * v / rig.v1**2 * two, rig.mu_s * one * (g - 1),
          -rig.mu_s * one * rig.a2 * v * g]
    return np.array(by).T, rig.mu_s * (-rig.a1 / rig.v1 * e * two - one * rig.a2 * rig.c2 * g)


@dataclass
class Rows:
    """Slip samples of all runs, one after the other."""

    run: np.ndarray
    t: np.ndarray
    s: np.ndarray
    w: np.ndarray
    wd: np.ndarray
    q: np.ndarray
    v: np.ndarray  # |v_r|
    sign: np.ndarray
    rate: np.ndarray  # d|v_r|/dt
    normal: np.ndarray
    force: np.ndarray  # over F_N
    kept_out: np.ndarray
    block: np.ndarray


def rows(runs, smoothed, phi):
    parts = []
    for i, (run, x) in enumerate(zip(runs, smoothed)):
        use = (x.mode != 0) & (x.edge >= EDGE)
        slip = x.speed - run.belt
        rate = np.gradient(x.speed, run.dt) * x.mode
        t = run.t - run.t[0]
        columns = [np.full(t.size, i), t, x.travel, x.q @ phi, x.speed, x.q, np.abs(slip), x.mode, rate, np.full(t.size, run.normal),
                   x.force / run.normal, run.kept_out(), 1000 * i + (t / 0.05).astype(int)]
        parts.append([c[use] for c in columns])
    return Rows(*[np.concatenate(c) for c in zip(*parts)])


@dataclass
class Library:
    """base: nuisance columns; columns: {effect: column}; values: {effect: (parameters at coefficient 1, own values of each run)}."""

    base: np.ndarray
    believed: np.ndarray
    columns: dict = field(default_factory=dict)
    values: dict = field(default_factory=dict)

    def strength(self, name):
        """The parameter that is proportional to the coefficient."""
        return "node_values" if name == "belt_friction_profile" else next(iter(self.values[name][0]))


def base_columns(r, rig, stiffness=True):
    """The law's constants (linearised), stiffness errors of the two modes, the friction level of each run; each per standard deviation."""
    slopes, _ = law_slopes(r.v, rig)
    mu = law(r.v, rig)
    levels = [-r.sign * mu * (r.run == i) for i in np.unique(r.run)]
    w2 = (2 * np.pi * np.array(rig.frequencies[:2])) ** 2
    bend = -2 * w2 * rig.mass / rig.tip_values()[:2] * r.q / r.normal[:, None]
    parts = [-r.sign[:, None] * slopes, bend, *levels] if stiffness else [-r.sign[:, None] * slopes, *levels]
    sd = believed(rig, len(levels))
    return np.column_stack(parts) * (sd if stiffness else np.delete(sd, [5, 6]))


def believed(rig, runs):
    """Standard deviations of the nuisances: law's constants 10 %, natural frequencies 0.2 %, levels 1 %."""
    return np.array([*(0.1 * getattr(rig, key) for key in LAW), 0.002, 0.002, *[0.01] * runs])


def _wave(argument, carrier, r, left, train, weight):
    """Sum over runs of the best a cos + b sin, times carrier: (column, {run: (amplitude, phase)}, what it takes off the weighted sum)."""
    column, own, gain = np.zeros(left.size), {}, 0.0
    for i in np.unique(r.run):
        here = r.run == i
        x = np.column_stack([np.cos(argument[here]), np.sin(argument[here])]) * carrier[here, None]
        seen = train[here]
        scaled, y = x[seen] * weight[here][seen, None], (left * weight)[here][seen]
        ab = np.linalg.lstsq(scaled, y, rcond=None)[0]
        column[here] = x @ ab
        gain += np.sum(y**2) - np.sum((y - scaled @ ab) ** 2)
        own[int(i)] = float(np.hypot(*ab)), float(-np.arctan2(ab[1], ab[0]))
    return column, own, gain


def strongest_line(variable, carrier, rates, r, left, train, weight):
    """The rate (per unit of variable) whose wave takes most off what the nuisances leave: (rate, column, own)."""
    gains = [_wave(2 * np.pi * f * variable, carrier, r, left, train, weight)[2] for f in rates]
    best = float(rates[int(np.argmax(gains))])
    return best, *_wave(2 * np.pi * best * variable, carrier, r, left, train, weight)[:2]


def _periodic(library, name, line, key, value, amplitude):
    """One column for a wave with a phase of its own in each run. value: the shape constant; amplitude: of a coefficient of 1."""
    _, column, own = line
    library.columns[name] = column
    mean = float(np.mean([a for a, _ in own.values()])) * amplitude
    library.values[name] = {"amplitude": mean, key: value}, {i: {"phase": p} for i, (_, p) in own.items()}


def _profile(library, r, carrier, left, train, weight):
    """Friction over the place on the belt: a cubic spline for each run, nodes by ridge regression."""
    column, own = np.zeros(left.size), {}
    for i in np.unique(r.run):
        here = r.run == i
        n = int(np.ceil(np.max(r.s[here]) / NODE_DISTANCE)) + 3
        grid = np.vstack([np.eye(n), np.eye(n)[:1]])
        x = CubicSpline(np.arange(n + 1) * NODE_DISTANCE, grid, bc_type="periodic")(r.s[here]) * carrier[here, None]
        seen = train[here]
        scaled = x[seen] * weight[here][seen, None]
        a = scaled.T @ scaled
        nodes = np.linalg.solve(a + RIDGE * max(np.trace(a) / n, 1e-9) * np.eye(n), scaled.T @ (left * weight)[here][seen])
        column[here] = x @ nodes
        own[int(i)] = {"start": 0.0, "node_values": nodes}
    library.columns["belt_friction_profile"] = column
    library.values["belt_friction_profile"] = {"node_distance": NODE_DISTANCE}, own


def build(r, rig, train, weight):
    """The library on the rows r; lines and profiles are learned from the rows in train, weighted."""
    library = Library(base_columns(r, rig), believed(rig, np.unique(r.run).size))
    _, slope = law_slopes(r.v, rig)
    carrier = -r.sign * law(r.v, rig)
    plain = {
        "viscous_friction": ("coefficient", -r.sign * r.v),
        "cubic_stiffness": ("coefficient", -(r.w**3) / r.normal),
        "quadratic_drag": ("coefficient", -r.wd * np.abs(r.wd) / r.normal),
        "normal_force_coupling": ("coefficient", carrier * r.w),
        "friction_drift": ("change", carrier * (1 - np.exp(-r.t / DRIFT_TAU))),
        "frictional_lag": ("time_constant", r.sign * slope * r.rate),
        "axial_load": ("softening", (2 * np.pi * rig.frequencies[0]) ** 2 * rig.mass / rig.tip_values()[0] * r.q[:, 0]),
    }
    for name, (key, column) in plain.items():
        library.columns[name] = column
        library.values[name] = {key: 1.0}, {}
    library.values["friction_drift"][0]["time_constant"] = DRIFT_TAU
    target = r.force - carrier
    seen = library.base[train] * weight[train, None]
    a = seen.T @ seen + np.eye(seen.shape[1])
    left = target - library.base @ np.linalg.solve(a, seen.T @ (target * weight)[train])
    place = strongest_line(r.s, carrier, WAVE_NUMBERS, r, left, train, weight)
    _periodic(library, "belt_periodic_friction", place, "wavelength", 1 / place[0], 1.0)
    time = strongest_line(r.t, carrier, FREQUENCIES, r, left, train, weight)
    _periodic(library, "normal_force_modulation", time, "frequency", time[0], 1.0)
    # a shaken base acts as -a int phi_1 dxi on mode 1, hence as a force of -m a int phi_1 dxi / phi_1 on the tip
    shake = strongest_line(r.t, -1.0 / r.normal, FREQUENCIES, r, left, train, weight)
    _periodic(library, "base_excitation", shake, "frequency", shake[0], rig.tip_values()[0] / (rig.mass * BASE_SHARE))
    _profile(library, r, carrier, left, train, weight)
    return library
