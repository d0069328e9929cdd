"""Peer (b): forward search by BIC on free simulations, as PEtab-Select does it (method forward, criterion BIC; Pathirana and others 2025).

The generator's simulate.py is integrated freely over the first 0.06 s of each run; parameters and start states are fitted by scipy's
least_squares. First the reference model, then each effect by itself beside it, from one or two starts each, briefly; the best five are fitted in
full. While the best one lowers the BIC it is kept and each of the others is tried beside it.

    BIC = sum over runs of n_r ln(RSS_r/n_r) + k ln n      n residuals, k parameters; the noise of each run is profiled

The noise is the run's own since a run that is lost would else drown all others. What campaign.toml and the law's nominal constants say of
the parameters enters as Gaussian terms in the fit, not in the BIC. Periodic effects start at the strongest lines of the slip force
(library.py), which a generic tool would not know; others at the middle of what is plausible.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np
from forecast import forecast_error, nudge, scales, state_at, step
from library import base_columns, build, law, rows
from scipy.optimize import least_squares
from simulate import simulate
from sindy import weights
from smoother import smooth

SPAN = 0.06  # s of free simulation per run
LATEST = 0.04  # s; the window starts in slip before it, else at the first sample
GROWING, BRIEF, FULL = (0.1, 0.25, 0.5, 1.0), (0.5,), (1.0, 1.0)  # shares of the span fitted one after the other; the noise anew for each
BOUND = 3.0  # a residual counts at most so many spreads
FLOOR, COMMON_NOISE = 1e-5, 0.01  # least noise, and that of all runs at first, in spreads of a run
EVALUATIONS, SHORT, SETTLING = 6, 3, 10  # of a fit to a share: Jacobians of all knobs, briefly, and of a run's own
FINALISTS = 5
COMMON = (("mu_s", 0.02), ("a1", 0.04), ("v1", 0.1), ("a2", 0.04), ("c2", 0.2), ("mass", 0.01))  # relative standard deviations
FREQUENCY, DAMPING, LEVEL = (0.002, 0.004), 0.3, 0.005
MOST = 2  # effects
PROFILE_NODES = 6  # of a run, spread over what it travels in the window
OWN = 5  # level and start state of each run


@dataclass
class Candidate:
    """An effect's knobs: shared ones by (key, start, scale), multiplicative where scale is 0; own: (key, start, scale) of each run."""

    name: str
    shared: list = field(default_factory=list)
    own: list = field(default_factory=list)
    fixed: dict = field(default_factory=dict)
    starts: dict = field(default_factory=dict)  # {run: {key: value}} of own knobs


def candidates(f1, lines):
    """One entry per start of each effect. lines: values of library.py, learned from the window."""
    out = [
        Candidate("viscous_friction", [("coefficient", 0.02, 0.1)]),
        Candidate("cubic_stiffness", [("coefficient", 1e8, 3e8)]),
        Candidate("quadratic_drag", [("coefficient", 1.0, 4.0)]),
        Candidate("normal_force_coupling", [("coefficient", 10.0, 60.0)]),
        Candidate("axial_load", [("softening", 3e-5, 1e-4)]),
        Candidate("friction_drift", [("change", 0.01, 0.05), ("time_constant", 0.2, 0)]),
        Candidate("frictional_lag", [("time_constant", 2e-4, 0)]),
        Candidate("frictional_lag", [("time_constant", 1.5e-3, 0)]),
        Candidate("sensor_lag", [("time_constant", 3e-5, 0)]),
        Candidate("sensor_lag", [("time_constant", 2e-4, 0)]),
        Candidate("static_friction_aging", [("gain", 0.05, 0.1), ("time_constant", 0.005, 0)], fixed={"form": "exp"}),
        Candidate("static_friction_aging", [("gain", 0.05, 0.1), ("time_constant", 0.01, 0)], fixed={"form": "log"}),
        Candidate("presliding_compliance", [("bristle_stiffness", 1e6, 0), ("bristle_damping", 60.0, 0)]),
        Candidate("third_mode", [("frequency", 17.548 * f1, 0), ("damping_ratio", 0.003, 0)]),
        Candidate("belt_drive_compliance", [("mass", 1.2, 0), ("stiffness", 1.2 * 110.0**2, 0), ("damping", 30.0, 0)]),
        Candidate("belt_drive_compliance", [("mass", 1.2, 0), ("stiffness", 1.2 * 200.0**2, 0), ("damping", 60.0, 0)]),
    ]
    for name, key in (("belt_periodic_friction", "wavelength"), ("normal_force_modulation", "frequency"), ("base_excitation", "frequency")):
        value, phases = lines[name]
        shared = [("amplitude", 0.5 * value["amplitude"], abs(value["amplitude"])), (key, value[key], 0)]
        out.append(Candidate(name, shared, [("phase", 0.0, 1.0)], starts=phases))
    nodes = [(f"node_{k}", 0.0, 0.05) for k in range(PROFILE_NODES)]
    out.append(Candidate("belt_friction_profile", own=nodes))
    return out


class Problem:
    """Free simulations of all runs from one vector of knobs: common ones, then level and start state of each run, then the effects'."""

    def __init__(self, rig, runs, smoothed, effects, deadline):
        self.rig, self.runs, self.effects, self.deadline = rig, runs, effects, deadline
        self.begin = [self._begin(s, run) for s, run in zip(smoothed, runs)]
        self.smoothed = smoothed
        self.share = 1.0
        self.shared_size = len(COMMON) + 4 + sum(len(e.shared) for e in effects)
        self.own_size = OWN + sum(len(e.own) for e in effects)

    @staticmethod
    def _begin(s, run):
        good = np.flatnonzero((s.mode != 0) & (s.edge >= 3) & (run.t - run.t[0] < LATEST))
        return int(good[0]) if good.size else 0

    def size(self):
        return self.shared_size + self.own_size * len(self.runs)

    def rig_of(self, u, i):
        """Rig of run i; u in standard deviations and scales, 0 the nominal model with the effects at their starts."""
        rig = self.rig
        values = {key: getattr(rig, key) * float(np.exp(sd * x)) for (key, sd), x in zip(COMMON, u)}
        k = len(COMMON)
        f = [f * (1 + sd * x) for f, sd, x in zip(rig.frequencies, FREQUENCY, u[k : k + 2])]
        d = [d * float(np.exp(DAMPING * x)) for d, x in zip(rig.damping, u[k + 2 : k + 4])]
        own = self.own(u, i)[OWN:]
        shared, effects = u[k + 4 : self.shared_size], {}
        for e in self.effects:
            found = dict(e.fixed)
            for (key, start, scale), x in zip(e.shared, shared):
                found[key] = float(start * np.exp(0.3 * np.clip(x, -15, 15)) if scale == 0 else start + scale * x)
            for (key, start, scale), x in zip(e.own, own):
                found[key] = float(e.starts.get(i, {}).get(key, start) + scale * x)
            shared, own = shared[len(e.shared) :], own[len(e.own) :]
            effects[e.name] = self._profile(found, i) if e.name == "belt_friction_profile" else found
        return replace(rig, frequencies=f, damping=d, effects=effects, **values)

    def _profile(self, found, i):
        """Nodes over the travel of the window, then back to the first: the spline is periodic."""
        s, n = self.smoothed[i].travel, self.begin[i] + round(SPAN / self.runs[i].dt)
        distance = max(float(s[n] - s[self.begin[i]]), 1e-4) / (PROFILE_NODES - 1)
        nodes = [found[f"node_{k}"] for k in range(PROFILE_NODES)]
        return {"node_distance": distance, "node_values": nodes, "start": -float(s[self.begin[i]])}

    def own(self, u, i):
        at = self.shared_size + i * self.own_size
        return u[at : at + self.own_size]

    def level(self, u, i):
        return 1.0 + LEVEL * float(self.own(u, i)[0])

    def residual(self, u, i):
        """Simulated less measured over the spread of the run."""
        rig, run, a = self.rig_of(u, i), self.runs[i], self.begin[i]
        count = round(self.share * SPAN / run.dt)
        state = nudge(state_at(rig, self.smoothed[i], a, run.belt), self.own(u, i)[1:OWN], rig.modes(), scales(rig, run), run.belt, rig.tip_values())
        record = simulate(rig, run.normal, run.belt, state, t0=run.t[a], duration=count * run.dt, level=self.level(u, i), substep=step(rig))
        out = (record.measured - run.w[a : a + count + 1]) / run.w.std()
        return np.clip(np.nan_to_num(out, nan=BOUND, posinf=BOUND, neginf=-BOUND), -BOUND, BOUND)

    def residuals(self, u):
        if time.process_time() > self.deadline:
            raise TimeoutError
        return np.concatenate([*(self.residual(u, i) / self.noise[i] for i in range(len(self.runs))), u])

    def spreads(self, u):
        """The noise of each run that is likeliest under u."""
        return [max(float(np.sqrt(np.mean(self.residual(u, i) ** 2))), FLOOR) for i in range(len(self.runs))]

    def jacobian(self, u, h=1e-4):
        """Forward differences; what belongs to one run is tried on that run alone."""
        parts = [self.residual(u, i) / self.noise[i] for i in range(len(self.runs))]
        ends = np.cumsum([0] + [p.size for p in parts])
        out = np.zeros((ends[-1] + u.size, u.size))
        out[ends[-1] :] = np.eye(u.size)
        for k in range(u.size):
            if time.process_time() > self.deadline:
                raise TimeoutError
            owner = [(k - self.shared_size) // self.own_size] if k >= self.shared_size else range(len(self.runs))
            moved = u.copy()
            moved[k] += h
            for i in owner:
                out[ends[i] : ends[i + 1], k] = (self.residual(moved, i) / self.noise[i] - parts[i]) / h
        return out

    def settle(self, u, i):
        """Level and start state of run i fitted by themselves, the rest held."""
        at = self.shared_size + i * self.own_size

        def residual(x):
            return np.concatenate([self.residual(np.concatenate([u[:at], x, u[at + x.size :]]), i) / self.noise[i], x])

        return least_squares(residual, u[at : at + self.own_size], method="trf", diff_step=1e-4, x_scale=1.0, max_nfev=SETTLING).x

    def fit(self, u, shares, evaluations, each=True):
        """(knobs, BIC at the last share) after fits to growing shares of the span, the runs' own knobs before all together.

        each: every run has a noise of its own; else one for all, so that none is given up early."""
        for self.share in shares:
            self.noise = self.spreads(u) if each else [COMMON_NOISE] * len(self.runs)
            own = [self.settle(u, i) for i in range(len(self.runs))]
            u = np.concatenate([u[: self.shared_size], *own])
            self.noise = self.spreads(u) if each else self.noise
            u = least_squares(self.residuals, u, jac=self.jacobian, method="trf", max_nfev=evaluations, x_scale=1.0).x
        return u, self.bic(u)

    def bic(self, u):
        n = round(self.share * SPAN / self.runs[0].dt) + 1
        return float(sum(2 * n * np.log(s) for s in self.spreads(u)) + (u.size + len(self.runs)) * np.log(n * len(self.runs)))


def extend(base, u, effects):
    """The knobs of a model in a model with one more effect, which starts at its own start values."""
    runs, more = len(base.runs), effects[-1]
    out = [u[: base.shared_size], np.zeros(len(more.shared))]
    for i in range(runs):
        out += [base.own(u, i), np.zeros(len(more.own))]
    return np.concatenate(out)


def best_extension(base, u, bic, pool):
    """The best of base and its extensions by one effect of the pool: all are fitted briefly, the FINALISTS of these in full."""
    leader, screened = (base, u, bic), []
    try:
        for candidate in pool:
            if candidate.name not in [e.name for e in base.effects]:
                trial = Problem(base.rig, base.runs, base.smoothed, [*base.effects, candidate], base.deadline)
                screened.append((trial, *trial.fit(extend(base, u, trial.effects), BRIEF, SHORT)))
        for trial, v, _ in sorted(screened, key=lambda x: x[2])[:FINALISTS]:
            leader = min(leader, (trial, *trial.fit(v, FULL, EVALUATIONS)), key=lambda x: x[2])
    except TimeoutError:
        return leader, len(screened), False
    return leader, len(screened), True


def search(rig, runs, smoothed, pool, deadline):
    """Forward search: {problem, knobs, bic, fits, ended}; what was best when the time was up counts."""
    best = Problem(rig, runs, smoothed, [], deadline)
    u, bic = best.fit(np.zeros(best.size()), GROWING, EVALUATIONS, each=False)
    u, bic = best.fit(u, FULL, EVALUATIONS)
    fits, ended = 0, True
    while len(best.effects) < MOST and ended:
        leader, tried, ended = best_extension(best, u, bic, pool)
        fits += tried
        if leader[0] is best:
            break
        best, u, bic = leader
    return {"problem": best, "knobs": u, "bic": bic, "fits": fits, "ended": ended}


def diagnose(rig, runs, levels, seconds):
    """The effects named within so many seconds of processor time, and what a forecast needs."""
    deadline = time.process_time() + seconds
    smoothed = [smooth(rig, run, levels) for run in runs]
    r = rows(runs, smoothed, rig.tip_values()[:2])
    train = r.t < LATEST + SPAN
    weight, _ = weights(base_columns(r, rig), r.force + r.sign * law(r.v, rig), r.run, train)
    pool = candidates(rig.frequencies[0], build(r, rig, train, weight).values)
    found = search(rig, runs, smoothed, pool, deadline)
    return {"named": sorted(e.name for e in found["problem"].effects), "bic": found["bic"], "fits": found["fits"], "of_first_round": len(pool),
            "ended": found["ended"], "found": found, "smoothed": smoothed}


def forecast(result, runs):
    problem, u = result["found"]["problem"], result["found"]["knobs"]
    each = range(len(runs))
    return forecast_error([problem.rig_of(u, i) for i in each], runs, result["smoothed"], [problem.level(u, i) for i in each])
