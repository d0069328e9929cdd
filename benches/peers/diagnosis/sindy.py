"""Peer (a): sparse regression of the slip force, segmented into stick and slip (Brunton, Proctor, Kutz 2016, PNAS 113:3932; PySINDy).

States and tip force from smoother.py; the natural frequencies are those (near the stated ones) that bring the slip force nearest to one law.
Slip samples alone are regressed: force = law with its constants free + terms of library.py. The nuisances (law, friction levels, stiffness
errors), each with what is believed of it, are always kept: they are projected out of the force and of every term. What remains goes through
PySINDy's STLSQ over a range of thresholds and its FROLS (forward steps: of terms that are nearly alike STLSQ keeps all), all terms scaled to
the same rms. The sparsest model is taken whose error on the kept-out blocks
is within two standard errors of the least one (paired over blocks). Its surviving terms are the effects named; terms whose coefficient
has a sign that no physics gives are left out.
"""

import warnings
from dataclasses import replace

import numpy as np
from forecast import forecast_error
from library import LAW, ONE_SIGN, base_columns, build, law, rows
from pysindy import FROLS, STLSQ
from scipy.optimize import minimize
from smoother import smooth

THRESHOLDS = np.geomspace(0.02, 0.9, 24)  # share of the rms of what the nuisances leave
ERRORS = 2.0  # standard errors within which a sparser model is as good
BOUNDS = {"mu_s": (0.4, 0.9), "a1": (0.2, 0.8), "v1": (0.005, 0.06), "a2": (0.2, 0.8), "c2": (0.05, 0.8)}
DETUNING = 0.01  # most of a natural frequency, 1
BELIEF = 0.004  # standard deviation of a stated natural frequency, 1
MOST = 5  # forward steps
HUBER, ROUNDS = 2.0, 5
ALIKE = 30.0  # samples in a row that err alike, so count as one against what is believed


def solve(base, extra, y):
    """Least squares; the coefficients of base are counted in their standard deviations and believed to be 0 +- 1."""
    scale = np.sqrt(np.mean(extra**2, axis=0)) + 1e-30
    k = base.shape[1]
    x = np.vstack([np.column_stack([base, extra / scale]), np.eye(k, k + extra.shape[1])])
    c = np.linalg.lstsq(x, np.concatenate([y, np.zeros(k)]), rcond=None)[0]
    return np.concatenate([c[:k], c[k:] / scale])


def _project(base, x):
    """What the nuisances leave of the columns x."""
    a = base.T @ base + np.eye(base.shape[1])
    return x - base @ np.linalg.solve(a, base.T @ x)


def weights(base, target, run, train):
    """Weight of each row: over the spread of its run around the nuisances, and down in proportion beyond HUBER spreads."""
    w = np.ones(target.size)
    none = np.empty((int(train.sum()), 0))
    for _ in range(ROUNDS):
        left = target - base @ solve(base[train] * w[train, None], none, target[train] * w[train])
        for i in np.unique(run):
            here = run == i
            spread = 1.4826 * np.median(np.abs(left[here & train])) + 1e-12
            w[here] = np.minimum(1.0, HUBER * spread / np.maximum(np.abs(left[here]), 1e-12)) ** 0.5 / (spread * ALIKE**0.5)
    return w, left


def tune(rig, runs, levels):
    """Natural frequencies (within DETUNING of those stated) under which the slip force of the smoother is nearest to one law."""

    def shifted(u):
        return replace(rig, frequencies=[f * (1 + float(np.clip(x, -DETUNING, DETUNING))) for f, x in zip(rig.frequencies, u)])

    def cost(u):
        trial = shifted(u)
        r = rows(runs, [smooth(trial, run, levels) for run in runs], rig.tip_values()[:2])
        train = ~r.kept_out
        _, left = weights(base_columns(r, rig, stiffness=False), r.force + r.sign * law(r.v, rig), r.run, train)
        spread = [np.log(np.median(np.abs(left[train & (r.run == i)]))) for i in np.unique(r.run)]
        return float(np.mean(spread)) + 0.5 * float(np.sum((np.array(u) / BELIEF) ** 2)) / r.t.size**0.5

    simplex = np.array([[0.0, 0.0], [0.003, 0.0], [0.0, 0.004]])
    options = {"initial_simplex": simplex, "maxfev": 30, "xatol": 2e-4, "fatol": 5e-3}
    return shifted(minimize(cost, [0.0, 0.0], method="Nelder-Mead", options=options).x)


def supports(columns, target):
    """Distinct supports along the thresholds of STLSQ and along the steps of FROLS; the empty one among them."""
    found = {()}
    optimizers = [*(STLSQ(threshold=x, alpha=1e-3) for x in THRESHOLDS), *(FROLS(max_iter=k, kappa=0.0) for k in range(1, MOST + 1))]
    for optimizer in optimizers:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a threshold leaves nothing
            optimizer.fit(columns, target[:, None])
        found.add(tuple(int(k) for k in np.flatnonzero(np.ravel(optimizer.coef_))))
    return found


def select(base, raw, target, train, block, one_sign):
    """(support, coefficients of nuisances and terms, weighted rms error on the kept-out blocks). Rows are weighted already."""
    columns, left = _project(base[train], raw[train]), _project(base[train], target[train])
    columns = columns / (np.sqrt(np.mean(columns**2, axis=0)) + 1e-30)
    judged = []
    for support in sorted(supports(columns, left / left.std())):
        chosen = raw[:, list(support)]
        c = solve(base[train], chosen[train], target[train])
        terms = c[base.shape[1] :]
        if any(one_sign[k] and x < 0 for k, x in zip(support, terms)):
            continue
        error = (target - np.column_stack([base, chosen]) @ c)[~train] ** 2
        judged.append((support, c, np.array([error[block[~train] == b].mean() for b in np.unique(block[~train])])))
    best = min(judged, key=lambda j: j[2].mean())[2]
    good = [j for j in judged if (j[2] - best).mean() <= ERRORS * (j[2] - best).std() / best.size**0.5]
    support, c, error = min(good, key=lambda j: (len(j[0]), j[2].mean()))
    return support, c, float(np.sqrt(error.mean()))


def model(rig, runs, library, names, c):
    """Rigs and friction levels of the runs with the parameters that the coefficients mean."""
    c = np.concatenate([c[: library.believed.size] * library.believed, c[library.believed.size :]])
    constants = {key: float(np.clip(getattr(rig, key) + x, *BOUNDS[key])) for key, x in zip(LAW, c)}
    f = [f * (1 + float(np.clip(x, -DETUNING, DETUNING))) for f, x in zip(rig.frequencies, c[5:7])]
    rigs = []
    for i in range(len(runs)):
        effects = {}
        for name, x in zip(names, c[library.believed.size :]):
            shared, own = library.values[name]
            effects[name] = {**shared, **own.get(i, {})}
            strength = library.strength(name)
            effects[name][strength] = effects[name][strength] * float(x)
        rigs.append(replace(rig, frequencies=f, effects=effects, **constants))
    return rigs, [1.0 + float(x) for x in c[7 : 7 + len(runs)]]


def diagnose(rig, runs, levels):
    """The effects named, and what a forecast needs."""
    tuned = tune(rig, runs, levels)
    smoothed = [smooth(tuned, run, levels) for run in runs]
    r = rows(runs, smoothed, rig.tip_values()[:2])
    train = ~r.kept_out
    target = r.force + r.sign * law(r.v, tuned)
    weight, _ = weights(base_columns(r, tuned), target, r.run, train)
    library = build(r, tuned, train, weight)
    names = list(library.columns)
    raw = np.column_stack([library.columns[n] for n in names]) * weight[:, None]
    support, c, error = select(library.base * weight[:, None], raw, target * weight, train, r.block, [n in ONE_SIGN for n in names])
    named = [names[k] for k in support]
    return {"named": sorted(named), "held_out_over_spread": error, "model": model(tuned, runs, library, named, c), "smoothed": smoothed}


def forecast(found, runs):
    return forecast_error(found["model"][0], runs, found["smoothed"], found["model"][1])
