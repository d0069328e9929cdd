"""Checks of the generator against other integrators, exact cases, balances and limits.

    python -m pytest test_generator.py
"""

import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from make_campaigns import draw_beam, draw_campaign, draw_effect, parser, replay, smooth_profile
from make_limit_cycles import CASES, FOLDER, name, rows, stick_start
from meta import digest
from simulate import EFFECTS, OUTSIDE, PLACES, S, U, X, XD, Y, Z, Rig, _profile, beam_integrals, simulate, start

DEMO = FOLDER.parents[1] / "demo"


# ------------------------------------------------------------------------------------------- other integrators
@pytest.mark.parametrize("case", json.loads(Path(__file__).with_name("golden_events.json").read_text()),
                         ids=lambda c: f"{c['normal_force_n']:g}N-{c['belt_velocity_m_per_s']:g}m/s")
def test_transitions_agree_with_three_other_integrators(case):
    x = case["initial_state"]
    rig = Rig()
    record = simulate(rig, case["normal_force_n"], case["belt_velocity_m_per_s"], start(rig, x[0::2], x[1::2], mode=0),
                      duration=case["stop_time_s"])
    expected = np.array(case["events"])
    found = record.events[: len(expected)]
    assert len(found) == len(expected)
    assert (found[:, 1] == expected[:, 1]).all()
    assert np.abs(found[:60, 0] - expected[:60, 0]).max() < 1e-8
    if case["final_state"]:
        assert len(record.events) == len(expected)
        difference = np.abs(record.y[-1, [0, 2, 1, 3]] - case["final_state"])
        assert difference[[0, 2]].max() < 1e-9 and difference[[1, 3]].max() < 2e-6  # m, m/s


def every_slip_effect():
    """All effects with a meaning in steady slip, switched on together."""
    rng = np.random.default_rng(7)
    rig = draw_beam(rng)
    rig.effects = {k: draw_effect(rng, k, rig.frequencies[0]) for k in PLACES
                   if k not in ("presliding_compliance", "static_friction_aging", "outside:rate_and_state")}
    for k in rig.effects:
        if "phase" in PLACES[k]:
            rig.effects[k]["phase"] = float(rng.uniform(0, 2 * np.pi))
    rig.effects["belt_friction_profile"]["start"] = 0.3
    rig.effects["outside:random_friction"]["draws"] = [0.7]
    return rig


def test_all_effects_together_agree_with_a_plain_twin_in_slip():
    """The equations once more in plain Python and an adaptive eighth-order method; belt at 2 m/s, so the tip never sticks."""
    rig, force_n, v0, level = every_slip_effect(), 60.0, 2.0, 1.01
    e = rig.effects
    n, mass = 3, rig.mass
    f = np.array(rig.frequencies + [e["third_mode"]["frequency"]])
    d = np.array(rig.damping + [e["third_mode"]["damping_ratio"]])
    phi, om = np.array([2.0, -2.0, 2.0]), 2 * np.pi * f
    g, inertia = beam_integrals(3)
    soft = e["axial_load"]["softening"] * force_n * om[0] ** 2 * g / g[0, 0]
    built = rig.build(force_n, v0)

    def wave(x, t):
        return x.get("amplitude", 1.0) * math.cos(2 * math.pi * x["frequency"] * t + x["phase"])

    def rhs(t, y):
        q, qd, (s, u, x, xd, sensor) = y[:3], y[3:6], y[6:]
        w, wd = phi @ q, phi @ qd
        belt = v0 * (1 + wave(e["outside:belt_speed_ripple"], t)) + xd
        normal = force_n * (1 + e["normal_force_coupling"]["coefficient"] * w)
        normal *= 1 + e["outside:normal_force_speed_coupling"]["coefficient"] * wd
        normal *= 1 + wave(e["normal_force_modulation"], t)
        bp, dr, dd = e["belt_periodic_friction"], e["friction_drift"], e["outside:direction_dependent_friction"]
        factor = level * (1 + bp["amplitude"] * math.cos(2 * math.pi * s / bp["wavelength"] + bp["phase"]))
        factor *= 1 + _profile(s, built["p"], built["nodes"])
        factor *= 1 + dr["change"] * (1 - math.exp(-t / dr["time_constant"]))
        factor *= 1 + dd["asymmetry"] * math.tanh(wd / dd["velocity_scale"])
        factor *= 1 + e["outside:random_friction"]["scatter"] * 0.7
        mu = rig.mu_s * (1 - rig.a1 + rig.a1 * math.exp(-u / rig.v1)) * (1 - rig.a2 + rig.a2 * math.exp(-rig.c2 * u))
        mu = (mu + e["viscous_friction"]["coefficient"] * u) * factor
        vr = wd - belt
        friction = -mu * normal * np.sign(vr)
        tip = friction - e["cubic_stiffness"]["coefficient"] * w**3 - e["quadratic_drag"]["coefficient"] * wd * abs(wd)
        tip -= e["outside:quadratic_stiffness"]["coefficient"] * w**2 + e["outside:cubic_damping"]["coefficient"] * wd**3
        stop, par, asym = e["outside:impact_stop"], e["outside:parametric_stiffness"], e["outside:asymmetric_damping"]
        tip -= stop["stiffness"] * max(0.0, w - stop["gap"])
        tip -= par["stiffness"] * math.cos(2 * math.pi * par["frequency"] * t + par["phase"]) * w
        tip -= asym["coefficient"] * wd * 0.5 * (1 + math.tanh(w / asym["deflection_scale"]))
        qdd = -2 * d * om * qd - om**2 * q + soft @ q + phi * tip / mass - wave(e["base_excitation"], t) * inertia
        drive = e["belt_drive_compliance"]
        xdd = (-friction - drive["damping"] * xd - drive["stiffness"] * x) / drive["mass"]
        return [*qd, *qdd, belt - wd, (abs(vr) - u) / e["frictional_lag"]["time_constant"], xd, xdd,
                (w - sensor) / e["sensor_lag"]["time_constant"]]

    state = start(rig, [2e-4, 1e-5, 0.0], [0.01, 0.0, 0.0], belt_velocity=v0)
    state.y[6 + U] = v0
    record = simulate(rig, force_n, v0, state, duration=0.03, dt=1e-3, level=level)
    y0 = np.concatenate([state.y[:6], state.y[[6 + S, 6 + U, 6 + X, 6 + XD, 6 + Y]]])
    twin = solve_ivp(rhs, (0, 0.03), y0, method="DOP853", rtol=1e-11, atol=1e-14, t_eval=record.t[:-1], max_step=2e-5)
    mine = record.y[:-1][:, [0, 1, 2, 3, 4, 5, 6 + S, 6 + U, 6 + X, 6 + XD, 6 + Y]].T
    scale = np.abs(twin.y).max(axis=1, keepdims=True)
    assert len(record.events) == 0
    assert (np.abs(mine - twin.y) / scale).max() < 1e-6


# ------------------------------------------------------------------------------------------------- exact cases
def test_undamped_free_vibration_is_a_cosine_and_keeps_its_energy():
    rig = Rig(damping=[0.0, 0.0])
    record = simulate(rig, 0.0, 1000.0, start(rig, [1e-3, 1e-5], [0.0, 0.0], belt_velocity=1000.0), duration=0.2)
    om = 2 * np.pi * np.array(rig.frequencies)
    exact = np.array([1e-3, 1e-5]) * np.cos(np.outer(record.t, om))
    assert np.abs(record.y[:, :2] - exact).max() < 1e-12
    energy = 0.5 * rig.mass * ((record.y[:, :2] * om) ** 2 + record.y[:, 2:4] ** 2).sum(axis=1)
    assert np.ptp(energy) / energy[0] < 1e-9


def test_axial_load_without_friction_is_the_linear_system_with_the_softened_matrix():
    rig = Rig(effects={"axial_load": {"softening": 1.4e-4}})
    record = simulate(rig, 100.0, 1000.0, start(rig, [1e-3, 2e-5], [0.0, 0.0], belt_velocity=1000.0), duration=0.1, level=0.0)
    om = 2 * np.pi * np.array(rig.frequencies)
    g, _ = beam_integrals(2)
    k = np.diag(om**2) - 1.4e-4 * 100.0 * om[0] ** 2 * g / g[0, 0]
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-k, -np.diag(2 * np.array(rig.damping) * om)]])
    assert np.abs(record.y[-1, :4] - expm(a * 0.1) @ record.y[0, :4]).max() < 1e-9
    assert k[0, 0] == pytest.approx(om[0] ** 2 * (1 - 0.014))


def test_beam_integrals_are_the_known_ones():
    g, inertia = beam_integrals(3)
    assert np.allclose(inertia, [0.783, 0.434, 0.254], atol=5e-4)
    assert np.allclose(np.diag(g), [4.648, 32.417, 77.30], rtol=1e-3)


def test_sensor_lag_shows_a_ramp_late_by_its_time_constant():
    tau = 3e-4
    rig = Rig(effects={"sensor_lag": {"time_constant": tau}})
    record = simulate(rig, 100.0, 0.02, start(rig, [0.0, 0.0], [0.01, 0.0], mode=0), duration=0.01)
    assert len(record.events) == 0
    lateness = record.w - record.measured
    assert np.allclose(lateness, 0.02 * tau * (1 - np.exp(-record.t / tau)), atol=1e-14)


@pytest.mark.parametrize("form", ["exp", "log"])
def test_aged_contact_breaks_away_at_the_aged_limit(form):
    b, tau = 0.2, 0.004
    rig = Rig(effects={"static_friction_aging": {"gain": b, "time_constant": tau, "form": form}})
    record = simulate(rig, 60.0, 0.06, start(rig, [0.0, 0.0], [0.03, 0.0], mode=0), duration=0.1, dt=1e-6)
    t = record.events[0, 0]
    grown = 1 - math.exp(-t / tau) if form == "exp" else math.log(1 + t / tau)
    held = record.force[int(t / 1e-6)]
    assert t > 0.005 and record.events[0, 1] == 0
    assert held == pytest.approx(0.66 * 60 * (1 + b * grown), rel=2e-4)


def test_belt_travel_stands_still_in_stick_and_is_belt_minus_tip_otherwise():
    rig = Rig()
    record = simulate(rig, 60.0, 0.06, stick_start(rig, 60.0, 0.06), duration=0.3)
    travel = record.y[:, 2 * record.n + S]
    assert np.allclose(travel, 0.06 * record.t - (record.w - record.w[0]), atol=1e-12)
    stick = (record.mode[:-1] == 0) & (record.mode[1:] == 0) & (record.stick_since[:-1] == record.stick_since[1:])
    assert (np.diff(travel)[stick] == 0).all()


# ---------------------------------------------------------------------------------------------- limits and balances
OFF = {  # parameters that switch an effect off while it is present
    "belt_periodic_friction": {"amplitude": 0.0, "wavelength": 0.02, "phase": 1.0},
    "belt_friction_profile": {"node_distance": 0.01, "node_values": [0.0] * 20, "start": 0.1},
    "static_friction_aging": {"gain": 0.0, "time_constant": 0.01},
    "frictional_lag": {"time_constant": 0.0},
    "presliding_compliance": {"bristle_stiffness": 0.0, "bristle_damping": 50.0},
    "axial_load": {"softening": 0.0},
    "normal_force_modulation": {"amplitude": 0.0, "frequency": 40.0, "phase": 1.0},
    "belt_drive_compliance": {"mass": 0.0, "stiffness": 1e4, "damping": 10.0},
    "friction_drift": {"change": 0.0, "time_constant": 0.3},
    "base_excitation": {"amplitude": 0.0, "frequency": 40.0, "phase": 1.0},
    "outside:impact_stop": {"stiffness": 0.0, "gap": 1e-4},
    "outside:random_friction": {"scatter": 0.0, "draws": [1.0, -1.0]},
    "outside:belt_speed_ripple": {"amplitude": 0.0, "frequency": 40.0, "phase": 1.0},
}


@pytest.mark.parametrize("effect", [k for k in PLACES if k != "third_mode"])
def test_switched_off_is_bit_identical_to_absent(effect):
    base, rig = Rig(), Rig(effects={effect: OFF.get(effect, {k: 0.0 for k in PLACES[effect]})})
    a = simulate(base, 60.0, 0.06, stick_start(base, 60.0, 0.06), duration=0.15, substep=5e-6)
    b = simulate(rig, 60.0, 0.06, stick_start(base, 60.0, 0.06), duration=0.15, substep=5e-6)
    assert np.array_equal(a.w, b.w) and np.array_equal(a.events, b.events) and np.array_equal(a.force, b.force)


def test_stiff_bristles_tend_to_the_rigid_contact():
    """Well below break-away the tip lags the belt by the bristle deflection, which falls like 1/sigma0; break-away itself, where
    bristles creep ahead of it, approaches the rigid one more slowly."""
    force_n, v0 = 60.0, 0.06
    base = Rig()
    om = 2 * np.pi * np.array(base.frequencies)
    held = 0.3 * base.mu_s * force_n
    q = np.array([2.0, -2.0]) * held / (base.mass * om**2)
    rigid = simulate(base, force_n, v0, start(base, q, [v0 / 2, 0.0], mode=0), duration=0.03)
    early, peak = [], []
    for stiffness in (2e6, 8e6, 3.2e7, 1.28e8):
        rig = Rig(effects={"presliding_compliance": {"bristle_stiffness": stiffness, "bristle_damping": 1.4 * math.sqrt(stiffness * 0.053)}})
        state = start(rig, q, [v0 / 2, 0.0], mode=0)
        state.y[2 * 2 + Z] = -held / stiffness
        soft = simulate(rig, force_n, v0, state, duration=0.03, substep=2e-7)
        early.append(np.abs(soft.w - rigid.w)[:80].max())
        peak.append(abs(soft.w.max() - rigid.w.max()) / rigid.w.max())
    assert rigid.events[0, 0] > 0.012
    assert np.allclose(np.array(early[:-1]) / early[1:], 4.0, rtol=0.1)
    assert all(a > b for a, b in zip(peak, peak[1:])) and peak[-1] < 0.02


def test_work_of_friction_is_energy_gained_plus_damping_losses():
    """d/dt (kinetic + elastic energy of beam and belt drive) = F v_0 - losses in the contact, the beam and the drive."""
    drive = {"mass": 1.5, "stiffness": 1.8e4, "damping": 50.0}
    rig, v0 = Rig(effects={"belt_drive_compliance": drive}), 0.1
    record = simulate(rig, 100.0, v0, stick_start(rig, 100.0, v0), duration=0.1, dt=1e-6, substep=1e-6)
    om, d = 2 * np.pi * np.array(rig.frequencies), np.array(rig.damping)
    q, qd = record.y[:, :2], record.y[:, 2:4]
    x, xd = record.y[:, 4 + X], record.y[:, 4 + XD]
    energy = 0.5 * rig.mass * ((q * om) ** 2 + qd**2).sum(axis=1) + 0.5 * drive["mass"] * xd**2 + 0.5 * drive["stiffness"] * x**2
    slip = record.wd - v0 - xd
    power = record.force * (v0 + slip) - drive["damping"] * xd**2 - rig.mass * (2 * d * om * qd**2).sum(axis=1)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(record.t))])
    assert len(record.events) > 4
    assert np.abs(energy - energy[0] - work).max() < 1e-4 * np.abs(work).max()


def test_friction_opposes_slip_and_stays_below_its_limit():
    rig = Rig()
    record = simulate(rig, 41.0, 0.21, stick_start(rig, 41.0, 0.21), duration=0.2)
    assert (np.abs(record.force) <= 0.66 * 41 * (1 + 1e-9)).all()
    assert (record.force[record.mode == -1] > 0).all() and (record.force[record.mode == 1] < 0).all()
    assert np.abs((record.wd - 0.21)[record.mode == 0]).max() < 1e-11


def test_halving_the_step_changes_little():
    rig = every_slip_effect()
    rig.effects = {k: v for k, v in rig.effects.items() if k in EFFECTS}
    state = start(rig, [6e-4, -1e-5], [0.03, 0.0], mode=0)
    a = simulate(rig, 60.0, 0.06, state, duration=0.05)
    b = simulate(rig, 60.0, 0.06, state, duration=0.05, substep=1.25e-6)
    assert np.abs(a.w - b.w).max() < 1e-8


def test_belt_profile_has_the_rms_and_the_correlation_length_asked_for():
    ratios = []
    for seed in range(20):
        g = smooth_profile(np.random.default_rng(seed))
        y, dx, length = np.array(g["node_values"]), g["node_distance"], g["correlation_length"]
        assert y.std() == pytest.approx(g["rms"], rel=1e-6)
        correlation = np.mean(y * np.roll(y, round(length / dx))) / np.mean(y**2)
        ratios.append(correlation)
    assert np.mean(ratios) == pytest.approx(math.exp(-1), abs=0.05)


# ------------------------------------------------------------------------------------------------ campaigns and data
@pytest.mark.parametrize("effect", list(EFFECTS) + list(OUTSIDE))
def test_a_run_is_replayed_bit_for_bit_from_its_truth(effect):
    args = parser().parse_args(["--out", "unused", "--runs", "1", "--duration", "0.2", "--transients", "1"])
    truth, records = draw_campaign(np.random.default_rng(5), [effect], args)
    again = replay(json.loads(json.dumps(truth)), 0, duration=0.2)
    assert np.array_equal(again.measured, records[0].measured)
    assert 20 <= truth["visibility"][effect] <= 4000


def test_demo_runs_are_their_truth_and_white_noise():
    truth = json.loads((DEMO / "truth.json").read_text())[0]
    for i in range(4):
        data = np.loadtxt(DEMO / f"run{i + 1:02d}.csv", delimiter=",", skiprows=1)
        residual = data[:, 1] - replay(truth, i, duration=0.48).measured[:-1]
        assert residual.std() == pytest.approx(truth["noise_m"], rel=0.05)
        assert abs(residual.mean()) < 5 * truth["noise_m"] / math.sqrt(len(residual))


@pytest.mark.parametrize("case", CASES, ids=lambda c: name(*c[:2]))
def test_limit_cycle_files_are_reproduced(case):
    data = np.loadtxt(FOLDER / name(*case[:2]), delimiter=",", skiprows=1)
    again = rows(*case, substep=2.5e-6)
    assert np.abs(data[:, 1] - again[:, 1]).max() < 1e-8
    assert (data[:, 4] == again[:, 4]).mean() > 0.99


@pytest.mark.parametrize("folder", [DEMO, FOLDER], ids=["demo", "limit_cycles"])
def test_meta_digests_match_the_files(folder):
    meta = tomllib.loads((folder / "meta.toml").read_text())
    assert {k: digest(folder / k) for k in meta["sha256"]} == meta["sha256"]
    assert set(meta["sha256"]) == {p.name for p in folder.iterdir()} - {"meta.toml"}
