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

from make_campaigns import (NOMINAL, OUTSIDE_STRENGTH, STRENGTH, choose, draw_beam, draw_campaign, draw_effect, draw_misstated,
                            draw_weak_effect, kind_of, main, parse, parser, replay, smooth_profile, strength_of, strengthened)
from make_limit_cycles import CASES, FOLDER, name, rows, stick_start
from meta import digest
from simulate import (BLIND_PHYSICS, EFFECTS, FRESH_PHYSICS, FURTHER_PHYSICS, LATER_PHYSICS, NEW_PHYSICS, OUTSIDE, PLACES, A, B, H, M, S,
                      T, U, X, XD, Y, Z, Rig, _profile, beam_integrals, eigenfunction, simulate, start)

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
    """All effects with a meaning in steady slip, switched on together; later ones have closed forms of their own."""
    rng = np.random.default_rng(7)
    rig = draw_beam(rng)
    later = {**FURTHER_PHYSICS, **LATER_PHYSICS, **FRESH_PHYSICS, **BLIND_PHYSICS}
    rig.effects = {k: draw_effect(rng, k, rig.frequencies[0]) for k in PLACES if k not in later
                   and k not in ("presliding_compliance", "static_friction_aging", "outside:rate_and_state")}
    for k in rig.effects:
        if "phase" in PLACES[k]:
            rig.effects[k]["phase"] = float(rng.uniform(0, 2 * np.pi))
    rig.effects["belt_friction_profile"]["start"] = 0.3
    rig.effects["outside:random_friction"]["draws"] = [0.7]
    rig.tip, rig.drive, rig.weight = [1.95, -2.07], 1.015, 0.97
    return rig


def test_all_effects_together_agree_with_a_plain_twin_in_slip():
    """The equations once more in plain Python and an adaptive eighth-order method; belt at 2 m/s, so the tip never sticks."""
    rig, force_n, v0, level = every_slip_effect(), 60.0, 2.0, 1.01
    e = rig.effects
    n, mass = 3, rig.mass
    f = np.array(rig.frequencies + [e["third_mode"]["frequency"]])
    d = np.array(rig.damping + [e["third_mode"]["damping_ratio"]])
    phi, om = np.array([1.95, -2.07, 2.0]), 2 * np.pi * f
    g, inertia = beam_integrals(3)
    built = rig.build(force_n, v0)
    stated, (force_n, v0) = (force_n, v0), (0.97 * force_n, 1.015 * v0)
    soft = e["axial_load"]["softening"] * force_n * om[0] ** 2 * g / g[0, 0]

    def wave(x, t):
        return x.get("amplitude", 1.0) * math.cos(2 * math.pi * x["frequency"] * t + x["phase"])

    def rhs(t, y):
        q, qd, (s, u, x, xd, sensor, age, warmth, held) = y[:3], y[3:6], y[6:]
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
        factor *= 1 + e["outside:ageing_law"]["gain"] * math.log(1 + age)
        heat, hysteresis = e["outside:frictional_heating"], e["outside:hysteresis"]
        factor /= 1 + heat["coefficient"] * warmth
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
        tip -= held
        drift = e["outside:frequency_drift"]
        drifted = om * [1 + drift["change"] * (1 - math.exp(-t / drift["time_constant"])), 1, 1]
        qdd = -2 * d * om * qd - drifted**2 * q + soft @ q + phi * tip / mass - wave(e["base_excitation"], t) * inertia
        drive = e["belt_drive_compliance"]
        xdd = (-friction - drive["damping"] * xd - drive["stiffness"] * x) / drive["mass"]
        return [*qd, *qdd, belt - wd, (abs(vr) - u) / e["frictional_lag"]["time_constant"], xd, xdd,
                (w - sensor) / e["sensor_lag"]["time_constant"], (v0 - abs(vr) * (1 + age)) / e["outside:ageing_law"]["slip_distance"],
                abs(friction * vr) / heat["heat_capacity"] - warmth / heat["time_constant"],
                hysteresis["stiffness"] * wd if abs(held) < hysteresis["slip_force"] or held * wd < 0 else 0.0]

    state = start(rig, [2e-4, 1e-5, 0.0], [0.01, 0.0, 0.0], belt_velocity=v0)
    state.y[6 + U] = v0
    record = simulate(rig, *stated, state, duration=0.03, dt=1e-3, level=level)
    carried = [6 + place for place in (S, U, X, XD, Y, A, T, H)]
    y0 = np.concatenate([state.y[:6], state.y[carried]])
    twin = solve_ivp(rhs, (0, 0.03), y0, method="DOP853", rtol=1e-11, atol=1e-14, t_eval=record.t[:-1], max_step=2e-5)
    mine = record.y[:-1][:, [0, 1, 2, 3, 4, 5, *carried]].T
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


# ------------------------------------------------------------------------------------------------- acceleration
def still(record, effect):
    return np.zeros(record.t.size)


def driven(record, effect):
    """M x'' = -F - c x' - k x"""
    x, xd = record.y[:, 2 * record.n + X], record.y[:, 2 * record.n + XD]
    return -(record.force + effect["damping"] * xd + effect["stiffness"] * x) / effect["mass"]


def rippling(record, effect):
    omega = 2 * np.pi * effect["frequency"]
    return -0.06 * effect["amplitude"] * omega * np.sin(omega * record.t + effect["phase"])


@pytest.mark.parametrize("name, effect, belt", [
    ("", {}, still),
    ("belt_drive_compliance", {"mass": 1.5, "stiffness": 1.8e4, "damping": 50.0}, driven),
    ("outside:belt_speed_ripple", {"amplitude": 0.1, "frequency": 40.0, "phase": 0.7}, rippling),
    ("base_excitation", {"amplitude": 4.0, "frequency": 120.0, "phase": 0.7}, still),
    ("static_friction_aging", {"gain": 0.2, "time_constant": 0.004, "form": "exp"}, still),
    ("presliding_compliance", {"bristle_stiffness": 1e6, "bristle_damping": 100.0}, None),
    ("third_mode", {"frequency": 1430.0, "damping_ratio": 0.003}, still),
])
def test_acceleration_is_the_second_derivative_of_the_displacement_and_in_stick_the_belts(name, effect, belt):
    """Between transitions (w(t-h) - 2 w(t) + w(t+h))/h^2 = (w''(t-h) + 10 w''(t) + w''(t+h))/12 + O(h^4), h = 1 us.

    Tolerances: that remainder, h^4/240 times the sixth derivative, is below 2e-6 of the largest acceleration in slip, where friction
    changes within some 10 us of a reversal. In stick rounding is left: 1e-16 of a deflection of some mm over h^2 is some 1e-6 m/s^2."""
    h = 1e-6
    rig = Rig(damping=[0.002, 0.003], effects={name: effect} if name else {})
    record = simulate(rig, 60.0, 0.06, stick_start(rig, 60.0, 0.06), duration=0.1, dt=h)
    w, a = record.w, record.acceleration
    passed = np.searchsorted(record.events[:, 0], record.t)
    stick, apart = record.mode[1:-1] == 0, passed[2:] == passed[:-2]
    off = np.abs((w[2:] - 2 * w[1:-1] + w[:-2]) / h**2 - (a[2:] + 10 * a[1:-1] + a[:-2]) / 12)
    assert len(record.events) > 4 and np.abs(a).max() > 100 and (~stick).mean() > 0.1
    assert off[apart & ~stick].max() < 2e-6 * np.abs(a).max()
    if belt is not None:
        assert stick.mean() > 0.1 and off[apart & stick].max() < 1e-5
        assert np.abs(a - belt(record, effect))[record.mode == 0].max() < 1e-11  # rounding of terms of some 100 m/s^2


def test_a_sample_at_a_transition_has_the_acceleration_after_it():
    """Where stick begins, friction and with it the acceleration jump: samples 2e-13 s before and after (it is located to 1e-13 s)."""
    rig, n = Rig(), 200
    run = lambda dt: simulate(rig, 60.0, 0.06, stick_start(rig, 60.0, 0.06), duration=1.2 * n * dt, dt=dt)
    begins = lambda record: record.stick_since[(record.mode == 0) & (record.stick_since > 0)][0]
    at = begins(run(begins(run(1e-4)) / n))  # once more with nearly the steps of the runs below, for they move it by their error
    before, after = run((at - 2e-13) / n), run((at + 2e-13) / n)
    assert before.mode[n] != 0 and abs(before.acceleration[n]) > 10
    assert after.mode[n] == 0 and abs(after.acceleration[n]) < 1e-11


# ------------------------------------------------------------------------------------------------ misstated inputs
def test_constant_friction_bends_the_beam_by_the_squares_of_the_true_tip_values():
    """Undamped, from rest: q_j = phi_j(1) mu_0 F_N/(m w_j^2) (1 - cos w_j t), w = sum phi_j(1) q_j, with the true F_N."""
    rig = Rig(damping=[0.0, 0.0], a1=0.0, a2=0.0, tip=[2.08, -1.91], weight=1.04)
    record = simulate(rig, 60.0, 1000.0, start(rig, [0.0, 0.0], [0.0, 0.0], belt_velocity=1000.0), duration=0.05)
    om = 2 * np.pi * np.array(rig.frequencies)
    exact = (1 - np.cos(np.outer(record.t, om))) @ (np.array([2.08, 1.91]) ** 2 * 0.66 * 1.04 * 60.0 / (rig.mass * om**2))
    assert np.abs(record.w - exact).max() < 1e-10


def test_stick_ends_at_the_true_normal_force_and_goes_with_the_true_belt():
    rig = Rig(drive=1.02, weight=0.95)
    record = simulate(rig, 60.0, 0.05, start(rig, [0.0, 0.0], [0.051 / 2, 0.0], mode=0), duration=0.1, dt=1e-6)
    end = int(record.events[0, 0] / 1e-6)
    assert record.w[end] / record.t[end] == pytest.approx(0.05 * 1.02, rel=1e-9)
    assert record.force[end] == pytest.approx(0.66 * 60 * 0.95, rel=2e-4)


# ----------------------------------------------------------------------------------------------------- new physics
def test_drifting_frequency_turns_the_phase_by_its_integral_and_keeps_the_action():
    """Slow drift, undamped: q_1 = A (f_0/f)^(1/2) cos(2 pi int f dt) (WKB), and energy over frequency stays."""
    a, tau, f0 = 0.03, 0.2, 80.0
    rig = Rig(damping=[0.0, 0.0], effects={"outside:frequency_drift": {"change": a, "time_constant": tau}})
    record = simulate(rig, 0.0, 1000.0, start(rig, [1e-3, 0.0], [0.0, 0.0], belt_velocity=1000.0), duration=0.6)
    t = record.t
    f = f0 * (1 + a * (1 - np.exp(-t / tau)))
    cycles = f0 * (t + a * (t - tau * (1 - np.exp(-t / tau))))
    assert cycles[-1] - f0 * t[-1] > 0.9
    assert np.abs(record.y[:, 0] - 1e-3 * np.sqrt(f0 / f) * np.cos(2 * np.pi * cycles)).max() < 1e-6
    action = (record.y[:, 2] ** 2 + (2 * np.pi * f * record.y[:, 0]) ** 2) / f
    assert np.ptp(action) / action[0] < 1e-3


def test_frequency_drifts_from_the_first_sample_on():
    rig = Rig(effects={"outside:frequency_drift": {"change": 0.04, "time_constant": 0.1}})
    state = start(Rig(), [1e-3, 0.0], [0.0, 0.0], belt_velocity=1000.0)
    before, plain = (simulate(r, 0.0, 1000.0, state, t0=-0.02, duration=0.02) for r in (rig, Rig()))
    assert np.array_equal(before.y, plain.y)


def test_ageing_contact_breaks_away_at_the_logarithm_of_its_age():
    """From theta = L/v_0 in stick theta grows by the time; the limit is mu_0 F_N [1 + b ln(1 + v_0 t/L)]."""
    b, length, v0 = 0.05, 2e-4, 0.06
    rig = Rig(effects={"outside:ageing_law": {"gain": b, "slip_distance": length}})
    record = simulate(rig, 60.0, v0, start(rig, [0.0, 0.0], [v0 / 2, 0.0], mode=0), duration=0.1, dt=1e-6)
    t = record.events[0, 0]
    assert t > 0.005 and record.events[0, 1] == 0
    assert record.force[int(t / 1e-6)] == pytest.approx(0.66 * 60 * (1 + b * math.log(1 + v0 * t / length)), rel=2e-4)


def test_age_relaxes_over_the_slip_distance_to_that_of_the_sliding_speed():
    """Tip at rest without friction: theta = L/v_0 + (theta_0 - L/v_0) exp(-v_0 t/L)."""
    length, v0 = 1e-4, 0.05
    rig = Rig(effects={"outside:ageing_law": {"gain": 0.05, "slip_distance": length}})
    state = start(rig, [0.0, 0.0], [0.0, 0.0], belt_velocity=v0)
    state.y[4 + A] = 6.0
    record = simulate(rig, 60.0, v0, state, duration=0.02, level=0.0)
    assert np.allclose(record.y[:, 4 + A], 6.0 * np.exp(-v0 * record.t / length), rtol=1e-6)


def test_age_changes_friction_within_bounds():
    rig = Rig(a1=0.0, a2=0.0, effects={"outside:ageing_law": {"gain": 0.05, "slip_distance": 1e-4}})
    state = start(rig, [0.0, 0.0], [0.0, 0.0], belt_velocity=0.05)
    factors = []
    for age in (math.exp(-100) - 1, math.exp(-2) - 1, math.exp(2) - 1, math.exp(100)):
        state.y[4 + A] = age
        factors.append(simulate(rig, 60.0, 0.05, state, duration=1e-4).force[0] / (0.66 * 60))
    assert factors == pytest.approx([0.5, 0.9, 1.1, 1.5])


def heated(**values):
    """A heavily damped beam under friction that depends on the temperature only, and its record on a belt at 0.5 m/s."""
    rig = Rig(damping=[0.7, 0.7], a1=0.0, a2=0.0, effects={"outside:frictional_heating": values})
    return simulate(rig, 60.0, 0.5, start(rig, [0.0, 0.0], [0.0, 0.0], belt_velocity=0.5), duration=0.4, dt=1e-5)


def test_hot_contact_settles_where_friction_power_is_carried_off():
    """C T/tau = mu_0 F_N v_0/(1 + k T), a quadratic equation in T."""
    k, capacity, tau = 0.003, 0.02, 0.02
    record = heated(coefficient=k, heat_capacity=capacity, time_constant=tau)
    power = 0.66 * 60 * 0.5
    t = (math.sqrt(1 + 4 * k * power * tau / capacity) - 1) / (2 * k)
    assert t > 10
    assert record.y[-1, 4 + T] == pytest.approx(t, rel=1e-6)
    assert record.force[-1] == pytest.approx(0.66 * 60 / (1 + k * t), rel=1e-6)


def test_heat_in_the_contact_is_friction_work_less_what_is_carried_off():
    capacity, tau, v0 = 0.02, 0.1, 0.06
    rig = Rig(effects={"outside:frictional_heating": {"coefficient": 0.003, "heat_capacity": capacity, "time_constant": tau}})
    record = simulate(rig, 60.0, v0, stick_start(rig, 60.0, v0), duration=0.1, dt=1e-6)
    t = record.y[:, 4 + T]
    power = record.force * (v0 - record.wd) - capacity * t / tau
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * 1e-6)])
    assert (record.mode == 0).any() and len(record.events) > 4
    assert np.abs(capacity * t - work).max() < 1e-4 * capacity * t.max()


def test_hysteresis_takes_the_slip_force_times_the_slip_out_of_each_swing():
    """Energy of beam and spring from turn to turn: - h_0 (|w_2 - w_1| - 2 h_0/k); no loss where a swing is shorter than 2 h_0/k."""
    k, h0 = 1500.0, 0.3
    rig = Rig(frequencies=[80.0], damping=[0.0], tip=[2.0], effects={"outside:hysteresis": {"stiffness": k, "slip_force": h0}})
    record = simulate(rig, 0.0, 1000.0, start(rig, [1e-3], [0.0], belt_velocity=1000.0), duration=1.5, dt=1e-5)
    held = record.y[:, 2 + H]
    om = 2 * np.pi * 80
    energy = 0.5 * rig.mass * ((om * record.y[:, 0]) ** 2 + record.y[:, 1] ** 2) + held**2 / (2 * k)
    turns = np.flatnonzero(np.diff(np.sign(record.wd)) != 0)[1:]
    swings = np.abs(np.diff(record.w[turns]))
    lost = -np.diff(energy[turns])
    assert np.abs(held).max() == h0 and len(turns) > 20
    assert swings[0] > 4 * h0 / k and swings[-1] < 2.1 * h0 / k
    assert np.abs(lost - h0 * np.maximum(0.0, swings - 2 * h0 / k)).max() < 1e-3 * lost[0]


def test_halving_the_step_changes_hysteresis_little():
    rig = Rig(effects={"outside:hysteresis": {"stiffness": 1500.0, "slip_force": 0.3}})
    state = start(rig, [6e-4, -1e-5], [0.03, 0.0], mode=0)
    a = simulate(rig, 60.0, 0.06, state, duration=0.05)
    b = simulate(rig, 60.0, 0.06, state, duration=0.05, substep=1.25e-6)
    assert len(a.events) > 2 and np.abs(a.w - b.w).max() < 1e-8


@pytest.mark.parametrize("effect, harmonics", [
    ("outside:quadratic_sensor", lambda c, x: [c * x**2 / 2, x, c * x**2 / 2, 0.0]),
    ("outside:cubic_sensor", lambda c, x: [0.0, x + 3 * c * x**3 / 4, 0.0, c * x**3 / 4]),
])
def test_curved_sensor_shows_the_harmonics_of_a_cosine(effect, harmonics):
    c, x = {"outside:quadratic_sensor": 20.0, "outside:cubic_sensor": 2e4}[effect], 1e-3
    rig = Rig(damping=[0.0, 0.0], effects={effect: {"curvature": c}})
    record = simulate(rig, 0.0, 1000.0, start(rig, [x / 2, 0.0], [0.0, 0.0], belt_velocity=1000.0), duration=0.1)
    spectrum = np.fft.rfft(record.measured[:-1]).real / 500
    assert np.allclose([spectrum[0] / 2, *spectrum[[8, 16, 24]]], harmonics(c, x), atol=1e-10)


# ------------------------------------------------------------------------------------------------- further physics
def free(rig, q, duration=0.1):
    """Slip at a belt so fast that nothing depends on the tip's velocity."""
    n = rig.modes()
    return simulate(rig, 0.0, 1000.0, start(rig, [q] + [0.0] * (n - 1), [0.0] * n, belt_velocity=1000.0), duration=duration)


def test_a_sensor_saturates_and_drifts():
    saturated = free(Rig(effects={"outside:sensor_saturation": {"level": 2e-3}}), 1e-3)
    assert np.allclose(saturated.measured, 2e-3 * np.tanh(saturated.w / 2e-3), atol=1e-15)
    drifting = free(Rig(effects={"outside:sensor_drift": {"change": 3e-5, "time_constant": 0.2}}), 1e-3)
    assert np.allclose(drifting.measured - drifting.w, 3e-5 * (1 - np.exp(-drifting.t / 0.2)), atol=1e-15)


def test_in_stick_the_tip_goes_with_the_slowing_belt():
    rig = Rig(effects={"outside:belt_slowing": {"change": -0.3, "time_constant": 0.01}})
    record = simulate(rig, 100.0, 0.02, start(rig, [0.0, 0.0], [0.01, 0.0], mode=0), duration=0.02)
    assert len(record.events) == 0
    assert np.abs(record.wd - 0.02 * (1 - 0.3 * (1 - np.exp(-record.t / 0.01)))).max() < 1e-10


def test_a_magnet_softens_small_vibrations():
    """w_1'^2 = w_1^2 - phi_1^2/m 2 C/d^3."""
    c, d = 2e-4, 8e-3
    rig = Rig(frequencies=[80.0], damping=[0.0], tip=[2.0], effects={"outside:magnet": {"strength": c, "distance": d}})
    record = free(rig, 1e-7)
    omega = math.sqrt((160 * math.pi) ** 2 - 4 / rig.mass * 2 * c / d**3)
    assert np.allclose(record.w, 2e-7 * np.cos(omega * record.t), atol=1e-11)


def test_friction_follows_deflection_and_the_speed_of_earlier_times():
    constant = {"a1": 0.0, "a2": 0.0}
    state = start(Rig(), [0.0, 0.0], [0.0, 0.0], belt_velocity=1000.0)
    rig = Rig(**constant, effects={"outside:friction_by_deflection": {"change": 0.1, "deflection_scale": 5e-4}})
    record = simulate(rig, 60.0, 1000.0, state, duration=0.05)
    assert np.allclose(record.force, 0.66 * 60 * (1 + 0.1 * np.tanh(record.w / 5e-4)), rtol=1e-12)
    rig = Rig(**constant, effects={"outside:speed_memory": {"gain": 1e-4, "time_constant": 0.02}})
    record = simulate(rig, 60.0, 1000.0, state, duration=0.05)
    assert np.allclose(record.force, 0.66 * 60 * (1 + 0.1 * (1 - np.exp(-record.t / 0.02))), rtol=1e-4)


def test_friction_grows_less_than_the_load():
    """mu F_N with mu ~ F_N^(-1/3) is a force ~ F_N^(2/3)."""
    constant = {"a1": 0.0, "a2": 0.0}
    state = start(Rig(), [0.0, 0.0], [0.0, 0.0], belt_velocity=1000.0)
    rig = Rig(**constant, effects={"outside:friction_by_load": {"exponent": 1 / 3, "force": 80.0}})
    for load in (10.0, 80.0, 270.0):
        record = simulate(rig, load, 1000.0, state, duration=0.01)
        assert np.allclose(record.force, 0.66 * 80 * (load / 80) ** (2 / 3), rtol=1e-12)


def test_a_frequency_follows_the_low_passed_deflection():
    """q'' = -[w_1 (1 + a x/mm)]^2 q, tau x' = |2 q| - x, by an adaptive method of order eight."""
    a, tau = 0.03, 0.02
    rig = Rig(frequencies=[80.0], damping=[0.0], tip=[2.0],
              effects={"outside:frequency_by_amplitude": {"change": a, "time_constant": tau}})
    record = free(rig, 1e-3)
    rhs = lambda t, y: [y[1], -((160 * math.pi * (1 + a * y[2] / 1e-3)) ** 2) * y[0], (abs(2 * y[0]) - y[2]) / tau]
    exact = solve_ivp(rhs, (0, 0.1), [1e-3, 0, 0], method="DOP853", rtol=1e-10, atol=1e-13, t_eval=record.t[:-1], max_step=1e-4)
    assert np.abs(record.y[:-1, 0] - exact.y[0]).max() < 1e-9


def test_an_absorber_is_one_more_mass_on_a_spring():
    """Linear: y' = A y for (q, P, q', P'), by the matrix exponential."""
    m, f, zeta = 3e-3, 150.0, 0.05
    rig = Rig(frequencies=[80.0], damping=[0.0], tip=[2.0],
              effects={"outside:absorber": {"mass": m, "frequency": f, "damping_ratio": zeta}})
    record = free(rig, 1e-3)
    om, oa = 160 * math.pi, 2 * math.pi * f
    k, c = m * oa**2 * 2 / rig.mass, 2 * zeta * m * oa * 2 / rig.mass
    # P is the absorber's place over the tip, PV its own velocity.
    a = np.array([[0, 0, 1, 0], [0, 0, -2, 1], [-om**2, k, -2 * c, c], [0, -oa**2, 4 * zeta * oa, -2 * zeta * oa]])
    y, step, exact = np.array([1e-3, 0, 0, 0]), expm(a * 1e-4), []
    for _ in record.t:
        exact.append(2 * y[0])
        y = step @ y
    assert np.abs(record.w - exact).max() < 1e-9


# --------------------------------------------------------------------------------------------------- fresh physics
def test_a_sensor_hums_and_lets_no_constant_through():
    hum = {"amplitude": 3e-6, "frequency": 50.0, "phase": 0.7}
    record = free(Rig(effects={"outside:mains_hum": hum}), 1e-3)
    assert np.allclose(record.measured - record.w, 3e-6 * np.cos(100 * math.pi * record.t + 0.7), atol=1e-15)
    tau = 0.03
    record = free(Rig(frequencies=[80.0], damping=[0.0], tip=[2.0], effects={"outside:ac_coupling": {"time_constant": tau}}), 1e-3)
    # tau x' = W cos(om t) - x, x(0) = W
    om, size = 160 * math.pi, 2e-3
    part = size / (1 + (om * tau) ** 2)
    x = part * (np.cos(om * record.t) + om * tau * np.sin(om * record.t)) + (size - part) * np.exp(-record.t / tau)
    assert np.abs(record.measured - (record.w - x)).max() < 1e-9


def test_a_load_follows_late_and_a_contact_runs_in():
    constant = {"a1": 0.0, "a2": 0.0}
    state = start(Rig(), [0.0, 0.0], [0.0, 0.0], belt_velocity=1000.0)
    k, tau = 100.0, 0.02
    rig = Rig(**constant, effects={"outside:lagging_load": {"coefficient": k, "time_constant": tau}})
    record = simulate(rig, 60.0, 1000.0, state, duration=0.05)
    dt = record.t[1] - record.t[0]
    x = np.zeros(record.t.size)
    for i in range(1, x.size):  # the trapezoidal rule
        x[i] = ((1 - dt / 2 / tau) * x[i - 1] + dt / 2 / tau * (record.w[i - 1] + record.w[i])) / (1 + dt / 2 / tau)
    assert np.allclose(record.force, 0.66 * 60 * (1 + k * x), rtol=1e-5)
    rig = Rig(**constant, effects={"outside:run_in": {"change": 0.1, "distance": 20.0}})
    record = simulate(rig, 60.0, 1000.0, state, duration=0.05)
    slid = 1000 * record.t - (record.w - record.w[0])
    assert np.allclose(record.force, 0.66 * 60 * (1 + 0.1 * np.exp(-slid / 20.0)), rtol=1e-9)


def test_in_stick_the_tip_goes_with_the_eccentric_pulley():
    rig = Rig(effects={"outside:eccentric_pulley": {"amplitude": 0.2, "circumference": 1e-3, "phase": 0.5}})
    own = 0.02 * (1 + 0.2 * math.cos(0.5))
    record = simulate(rig, 100.0, 0.02, start(rig, [0.0, 0.0], [own / 2, 0.0], mode=0), duration=0.02)
    assert len(record.events) == 0
    assert np.abs(record.wd - 0.02 * (1 + 0.2 * np.cos(2 * math.pi * 20 * record.t + 0.5))).max() < 1e-9


def test_a_bolt_that_comes_loose_steps_the_frequency():
    """q'' = -[w_1 (1 + a (1 + tanh((t - t_0)/5 ms))/2)]^2 q, by an adaptive method of order eight."""
    a, instant = 0.03, 0.04
    rig = Rig(frequencies=[80.0], damping=[0.0], tip=[2.0], effects={"outside:frequency_step": {"change": a, "instant": instant}})
    record = free(rig, 1e-3)
    rhs = lambda t, y: [y[1], -((160 * math.pi * (1 + a * (1 + math.tanh((t - instant) / 5e-3)) / 2)) ** 2) * y[0]]
    exact = solve_ivp(rhs, (0, 0.1), [1e-3, 0], method="DOP853", rtol=1e-11, atol=1e-14, t_eval=record.t[:-1], max_step=1e-4)
    assert np.abs(record.y[:-1, 0] - exact.y[0]).max() < 1e-9


# --------------------------------------------------------------------------------------------------- blind physics
CONSTANT = {"a1": 0.0, "a2": 0.0}  # friction 0.66 F_N at all speeds
ONE_MODE = {"frequencies": [80.0], "damping": [0.0], "tip": [2.0]}


def sliding(rig, normal_force=60.0, duration=0.05):
    """From rest on a belt at 1000 m/s."""
    n = rig.modes()
    return simulate(rig, normal_force, 1000.0, start(rig, [0.0] * n, [0.0] * n, belt_velocity=1000.0), duration=duration)


def by_another_method(rhs, y0, record):
    exact = solve_ivp(rhs, (0, record.t[-1]), y0, method="DOP853", rtol=1e-11, atol=1e-14, t_eval=record.t[:-1], max_step=1e-4)
    return exact.y


@pytest.mark.parametrize("effect", list(BLIND_PHYSICS))
def test_blind_physics_of_strength_zero_is_absent(effect):
    values = draw_effect(np.random.default_rng(2), effect, 80.0)
    base, rig = Rig(), Rig(effects={effect: strengthened(effect, values, 0.0)})
    a, b = (simulate(r, 60.0, 0.06, stick_start(base, 60.0, 0.06), duration=0.15, substep=5e-6) for r in (base, rig))
    assert len(a.events) > 4
    for of in ("w", "wd", "measured", "force", "acceleration", "events"):
        assert np.array_equal(getattr(a, of), getattr(b, of))


@pytest.mark.parametrize("effect", list(BLIND_PHYSICS))
def test_halving_the_step_changes_blind_physics_little(effect):
    rig = Rig(effects={effect: draw_effect(np.random.default_rng(2), effect, 80.0)})
    state = start(rig, [6e-4, -1e-5], [0.03, 0.0], mode=0)
    a, b = (simulate(rig, 60.0, 0.06, state, duration=0.05, **options) for options in ({}, {"substep": 1.25e-6}))
    assert len(a.events) > 2 and np.abs(a.measured - b.measured).max() < 1e-8


def test_blind_load_swings_about_what_constant_friction_bends_it_to():
    """x'' + 2 D w x' + w^2 x = w^2 mu_0 (1 + k x): a damped oscillator of w^2 (1 - k mu_0) about mu_0/(1 - k mu_0)."""
    k, f, zeta = 0.2, 300.0, 0.05
    rig = Rig(**CONSTANT, effects={"outside:resonant_load": {"coefficient": k, "frequency": f, "damping_ratio": zeta}})
    record, om, t = sliding(rig), 2 * math.pi * f, np.linspace(0, 0.05, 501)
    rest, own, decay = 0.66 / (1 - k * 0.66), om * math.sqrt(1 - k * 0.66 - zeta**2), zeta * om
    x = rest * (1 - np.exp(-decay * t) * (np.cos(own * t) + decay / own * np.sin(own * t)))
    assert np.allclose(record.y[:, 4 + B], x, atol=1e-9)
    assert np.allclose(record.force, 0.66 * 60 * (1 + k * x), rtol=1e-9)


def test_blind_belt_falls_behind_by_the_true_load():
    rig = Rig(drive=1.02, weight=0.95, effects={"outside:motor_slip": {"slip": 0.03}})
    for load in (60.0, 120.0):
        belt = 1.02 * 0.02 * (1 - 0.03 * 0.95 * load / 100)
        stuck = simulate(rig, load, 0.02, start(rig, [0.0, 0.0], [belt / 2, 0.0], mode=0), duration=0.01)
        assert len(stuck.events) == 0 and np.abs(stuck.wd - belt).max() < 1e-12
        slipping = simulate(rig, load, 0.02, start(rig, [0.0, 0.0], [0.0, 0.0], belt_velocity=0.02), duration=1e-4)
        mu = 0.66 * (0.5 + 0.5 * math.exp(-belt / 0.02)) * (0.5 + 0.5 * math.exp(-0.25 * belt))
        assert slipping.force[0] == pytest.approx(mu * 0.95 * load, rel=1e-12)


def test_blind_campaign_starts_in_stick_with_the_slower_belt():
    args = parser().parse_args(["--out", "unused", "--runs", "2", "--duration", "0.05", "--transients", "0"])
    truth, records = draw_campaign(np.random.default_rng(5), ["outside:motor_slip"], args)
    slip = truth["parameters"]["outside:motor_slip"]["slip"]
    for run, record in zip(truth["runs"], records):
        belt = run["belt_velocity_m_per_s"] * (1 - slip * run["normal_force_n"] / 100)
        assert record.mode[0] == 0 and np.abs(record.wd[record.mode == 0] - belt).max() < 1e-11


def test_blind_damping_follows_the_low_passed_deflection():
    a, tau, om = 5e-3, 0.03, 160 * math.pi
    rig = Rig(**ONE_MODE | {"damping": [0.001]}, effects={"outside:damping_by_amplitude": {"increase": a, "time_constant": tau}})
    record = free(rig, 1e-3)
    rhs = lambda t, y: [y[1], -2 * (0.001 + a * y[2] / 1e-3) * om * y[1] - om**2 * y[0], (abs(2 * y[0]) - y[2]) / tau]
    exact = by_another_method(rhs, [1e-3, 0, 0], record)
    assert np.abs(record.y[:-1, 0] - exact[0]).max() < 1e-9
    assert np.abs(record.w[-130:]).max() < 0.9 * 2e-3 * math.exp(-0.001 * om * 0.087)  # it is more than the constant damping does


def test_blind_frequency_falls_as_friction_warms_the_beam():
    k, tau, om, force = 3e-4, 0.02, 160 * math.pi, 0.66 * 60
    capacity = k * force * 1000 * tau / 0.05
    rig = Rig(**ONE_MODE, **CONSTANT,
              effects={"outside:frequency_by_heat": {"coefficient": k, "heat_capacity": capacity, "time_constant": tau}})
    record = sliding(rig)
    rhs = lambda t, y: [y[1], 2 * force / rig.mass - (om / (1 + k * y[2])) ** 2 * y[0],
                        force * (1000 - 2 * y[1]) / capacity - y[2] / tau]
    exact = by_another_method(rhs, [0, 0, 0], record)
    assert np.abs(record.y[:-1, 0] - exact[0]).max() < 1e-9
    assert record.y[-1, 2 + T] * k > 0.04


def test_blind_clamp_gives_way_to_the_moment_of_both_modes():
    """The moment goes with the curvature phi_j''(0) there, here by differences of the eigenfunctions."""
    a, play, h = 0.08, 2e-4, 1e-3
    moment = np.array([(eigenfunction(j, h) - 2 * eigenfunction(j, 0.0) + eigenfunction(j, -h)) / h**2 for j in range(2)])
    moment /= moment[0]
    om = 2 * np.pi * np.array([80.0, 510.0])
    rig = Rig(damping=[0.0, 0.0], effects={"outside:clamp_play": {"share": a, "play": play}})
    run = lambda q: simulate(rig, 0.0, 1000.0, start(rig, q, [0.0, 0.0], belt_velocity=1000.0), duration=0.05)
    record = run([5e-4, 2e-5])

    def rhs(t, y):
        given = a * om[0] ** 2 * play * math.tanh(moment @ y[:2] / play)
        return [*y[2:], *(given * moment - om**2 * y[:2])]

    exact = by_another_method(rhs, [5e-4, 2e-5, 0, 0], record)
    assert np.abs(record.w[:-1] - [2, -2] @ exact[:2]).max() < 2e-9  # that of the differences is 1e-6 of the moment
    small = run([1e-7, 0.0])
    k = np.diag(om**2) - a * om[0] ** 2 * np.outer(moment, moment)
    step = expm(np.block([[np.zeros((2, 2)), np.eye(2)], [-k, np.zeros((2, 2))]]) * 0.05)
    assert np.abs(small.y[-1, :2] - (step @ [1e-7, 0, 0, 0])[:2]).max() < 1e-12


def test_blind_friction_falls_with_the_vibration_of_earlier_times():
    gain, tau, om = 5e-6, 0.02, 160 * math.pi
    rig = Rig(**ONE_MODE, **CONSTANT, effects={"outside:friction_by_vibration": {"gain": gain, "time_constant": tau}})
    record = sliding(rig)

    def rhs(t, y):
        acceleration = 2 * 0.66 * 60 / (1 + gain * y[2]) / rig.mass - om**2 * y[0]
        return [y[1], acceleration, ((2 * acceleration) ** 2 - y[2]) / tau]

    exact = by_another_method(rhs, [0, 0, 0], record)
    assert np.abs(record.y[:-1, 0] - exact[0]).max() < 1e-9
    assert np.allclose(record.force[:-1], 0.66 * 60 / (1 + gain * exact[2]), rtol=1e-7)
    assert record.force.min() < 0.95 * 0.66 * 60


def test_blind_friction_law_is_read_at_speed_over_load():
    rig = Rig(effects={"outside:hersey_number": {"exponent": 0.7, "force": 80.0}})
    for load in (36.0, 80.0, 120.0):
        for speed in (0.01, 0.1):
            at = speed * (80 / load) ** 0.7
            mu = 0.66 * (0.5 + 0.5 * math.exp(-at / 0.02)) * (0.5 + 0.5 * math.exp(-0.25 * at))
            record = simulate(rig, load, speed, start(rig, [0.0, 0.0], [0.0, 0.0], belt_velocity=speed), duration=1e-4)
            assert record.force[0] == pytest.approx(mu * load, rel=1e-12)


def test_blind_frame_moves_the_sensor_against_friction():
    c = 3e-7
    record = sliding(Rig(**CONSTANT, effects={"outside:frame_compliance": {"compliance": c}}))
    assert np.allclose(record.measured, record.w - c * 0.66 * 60, atol=1e-15)
    # In stick friction holds the beam where the belt takes it, here so slowly that the beam is a spring.
    rig = Rig(effects={"outside:frame_compliance": {"compliance": c}})
    om = 2 * np.pi * np.array(rig.frequencies)
    record = simulate(rig, 100.0, 1e-3, start(rig, [0.0, 0.0], [5e-4, 0.0], mode=0), duration=0.1)
    stiffness = rig.mass / (4 / om**2).sum()
    assert len(record.events) == 0
    assert np.median(np.abs(record.measured[500:] / record.w[500:] - (1 - c * stiffness))) < 0.1 * c * stiffness


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
@pytest.mark.parametrize("effect", list(PLACES))
def test_a_run_is_replayed_bit_for_bit_from_its_truth(effect):
    args = parser().parse_args(["--out", "unused", "--runs", "1", "--duration", "0.2", "--transients", "1"])
    truth, records = draw_campaign(np.random.default_rng(5), [effect], args)
    again = replay(json.loads(json.dumps(truth)), 0, duration=0.2)
    assert np.array_equal(again.measured, records[0].measured)
    assert 20 <= truth["visibility"][effect] <= 4000


def campaigns(folder, *options):
    """What make_campaigns.py writes: the answers of truth.json, and campaign.toml of each."""
    main(["--out", str(folder), "--seed", "3", "--duration", "0.2", *options])
    truth = json.loads((folder / "truth.json").read_text())
    return truth, [tomllib.loads((folder / t["campaign"] / "campaign.toml").read_text()) for t in truth]


@pytest.mark.parametrize("channel, unit, motion, low, high", [
    ("velocity", "m_per_s", "wd", 5e-5, 5e-4),
    ("acceleration", "m_per_s2", "acceleration", 0.02, 0.5),
])
def test_a_campaign_of_another_channel_moves_as_that_of_displacements_and_has_its_noise(tmp_path, channel, unit, motion, low, high):
    options = ("--kind", "single", "--effect", "friction_drift", "--runs", "2")
    (of_w,), _ = campaigns(tmp_path / "w", *options)
    (of_v,), (stated,) = campaigns(tmp_path / "v", *options, "--channel", channel)
    assert of_v["channel"] == channel and "channel" not in of_w
    assert of_v["parameters"] == of_w["parameters"] and of_v["points"] == of_w["points"]
    assert stated["channels"] == {f"{channel}_column": f"tip_{channel}_{unit}"}
    noise = of_v[f"noise_{unit}"]
    assert low <= noise <= high
    for i in range(2):
        text = (tmp_path / "v/001" / f"run{i + 1:02d}.csv").read_text().split()
        assert text[0] == f"time_s,tip_{channel}_{unit}"
        v = np.array([float(line.split(",")[1]) for line in text[1:]])
        left = v - getattr(replay(of_v, i, duration=0.2), motion)[:-1]
        offset = of_v["runs"][i][f"offset_{unit}"]
        assert (offset != 0) == (channel == "acceleration") and abs(offset) < 0.1
        assert left.std() == pytest.approx(noise, rel=0.1)
        assert abs(left.mean() - offset) < 5 * noise / math.sqrt(len(left))


def test_a_sensor_elsewhere_reads_the_modes_by_their_shapes_there(tmp_path):
    """Campaign with the sensor stated at 0.7 of the length: what it shows is sum phi_j(s) q_j at the true place, which is near it."""
    options = ["--kind", "none", "--count", "1", "--seed", "5", "--runs", "3", "--place", "0.7"]
    (truth,), (stated,) = campaigns(tmp_path, *options)
    assert stated["sensor"] == {"position": 0.7} and truth["place_stated"] == 0.7
    assert 0 < abs(truth["place"] - 0.7) < 0.015
    shown = np.loadtxt(tmp_path / "001" / "run01.csv", delimiter=",", skiprows=1)[:, 1]
    record = replay(truth, 0, duration=1e-4 * shown.size)
    there = 0.0
    # The shapes by the beam's own equation, the fourth derivative of phi is k^4 phi; k of Blevins 1979, table 8-1.
    for j, k in enumerate([1.87510407, 4.69409113]):
        s = (math.cosh(k) + math.cos(k)) / (math.sinh(k) + math.sin(k))
        bent = solve_ivp(lambda x, y: [k * y[1], k * y[2], k * y[3], k * y[0]], (0, 1), [0, 0, 1, -s],
                         dense_output=True, rtol=1e-10, atol=1e-12)
        ratio = bent.sol(truth["place"])[0] / bent.sol(1.0)[0]
        there = there + ratio * record.phi[j] * record.y[: shown.size, j]
    noise = shown - there
    assert abs(noise.mean()) < 5 * truth["noise_m"] / math.sqrt(noise.size)
    assert abs(noise.std() / truth["noise_m"] - 1) < 0.1


def test_misstated_campaign_states_nominal_values_and_moves_by_the_true_ones(tmp_path):
    (truth,), (stated,) = campaigns(tmp_path, "--kind", "misstated", "--effect", "friction_drift", "--runs", "3", "--noise", "1e-7")
    assert stated["beam"] == NOMINAL
    bounds = {"drive": (1, 0.02), "weight": (1, 0.05), "true_mass": (0.427, 0.03)}
    pairs = [(truth[key], *bound) for key, bound in bounds.items()]
    pairs += [(f, nominal, 0.005) for f, nominal in zip(truth["true_f_hz"], [80.0, 510.0])]
    pairs += [(tip, nominal, 0.05) for tip, nominal in zip(truth["tip"], [2.0, -2.0])]
    law = {"mus": 0.66, "a1": 0.5, "v1": 0.02, "a2": 0.5, "c2": 0.25}
    pairs += [(truth["true_law"][key], nominal, 0.1) for key, nominal in law.items()]
    off = [abs(value / nominal - 1) / bound for value, nominal, bound in pairs]
    assert max(off) <= 1 and min(off) > 0
    for i, (entry, run) in enumerate(zip(stated["run"], truth["runs"])):
        assert entry["belt_velocity_m_per_s"] == run["belt_velocity_m_per_s"] and entry["normal_force_n"] == run["normal_force_n"]
        x = np.loadtxt(tmp_path / "001" / entry["file"], delimiter=",", skiprows=1)[:, 1]
        again = replay(truth, i, duration=0.2)
        assert (x - again.measured[:-1]).std() == pytest.approx(truth["noise_m"], rel=0.1)
        stuck = np.flatnonzero((again.mode[:-2] == 0) & (again.mode[1:-1] == 0) & (again.stick_since[:-2] == again.stick_since[1:-1]))
        speed = np.mean((x[stuck + 1] - x[stuck]) / 1e-4)
        assert len(stuck) > 100
        assert np.abs((again.wd - truth["drive"] * entry["belt_velocity_m_per_s"])[again.mode == 0]).max() < 1e-11
        assert speed == pytest.approx(truth["drive"] * entry["belt_velocity_m_per_s"], rel=3e-3)


def test_draws_of_misstated_rigs_fill_their_bounds():
    rigs = [draw_misstated(np.random.default_rng(seed)) for seed in range(300)]
    off = {
        0.005: [f / nominal - 1 for r in rigs for f, nominal in zip(r.frequencies, [80, 510])],
        0.02: [r.drive - 1 for r in rigs],
        0.03: [r.mass / 0.427 - 1 for r in rigs],
        0.05: [x for r in rigs for x in (r.weight - 1, r.tip[0] / 2 - 1, r.tip[1] / -2 - 1)],
        0.1: [x for r in rigs for x in (r.mu_s / 0.66 - 1, r.a1 / 0.5 - 1, r.v1 / 0.02 - 1, r.a2 / 0.5 - 1, r.c2 / 0.25 - 1)],
    }
    for bound, x in off.items():
        assert max(map(abs, x)) <= bound
        assert np.std(x) == pytest.approx(bound / math.sqrt(3), rel=0.1)  # uniform


def test_one_load_campaign_has_four_starts_at_one_point(tmp_path):
    (truth,), (stated,) = campaigns(tmp_path, "--kind", "one-load", "--effect", "friction_drift")
    assert len(stated["run"]) == 4
    assert len({(r["belt_velocity_m_per_s"], r["normal_force_n"]) for r in stated["run"]}) == 1
    assert len({tuple(r["start"]["q"]) for r in truth["runs"]}) == 4
    assert "drive" not in truth


@pytest.mark.parametrize("effect", list(STRENGTH))
def test_weak_effect_changes_the_equations_by_a_third(effect):
    strong, weak = (draw(np.random.default_rng(5), effect, 80.0) for draw in (draw_effect, draw_weak_effect))
    key = STRENGTH[effect]
    assert 3 * weak.pop(key) == pytest.approx(strong.pop(key))
    if effect == "belt_friction_profile":
        assert 3 * np.array(weak.pop("node_values")) == pytest.approx(np.array(strong.pop("node_values")), abs=1e-8)
    assert weak == strong


@pytest.mark.parametrize("effect", [name for name in PLACES if strength_of(name)])
def test_a_factor_on_the_strength_changes_nothing_else(effect):
    values = draw_effect(np.random.default_rng(5), effect, 80.0)
    half = strengthened(effect, values, 0.5)
    assert strengthened(effect, values) == values
    for key in values:
        share = 0.5 if key in (*strength_of(effect), "node_values") else 1.0
        if key == "form":
            assert half[key] == values[key]
        else:
            assert np.array(half[key]) == pytest.approx(share * np.array(values[key]), abs=1e-8 if key == "node_values" else 0.0)


def test_a_campaign_of_half_the_strength_hides_half_of_what_is_drawn(tmp_path):
    options = ("--kind", "outside", "--effect", "outside:clamp_play", "--runs", "2")
    (full,), _ = campaigns(tmp_path / "full", *options)
    (half,), _ = campaigns(tmp_path / "half", *options, "--strength", "0.5")
    (whole, part) = (truth["parameters"]["outside:clamp_play"] for truth in (full, half))
    assert part == {"share": whole["share"] * 0.5, "play": whole["play"]}
    chosen = choose(np.random.default_rng(1), "outside", 60, strength=0.5)
    assert {name for (name,) in chosen} == set(OUTSIDE) & set(OUTSIDE_STRENGTH)


def test_weak_campaign_has_two_micrometres_of_noise_and_may_be_invisible(tmp_path):
    truth, _ = campaigns(tmp_path, "--kind", "weak", "--count", "3", "--runs", "2")
    assert [t["noise_m"] for t in truth] == pytest.approx([2e-6] * 3)
    assert all(len(t["effects"]) == 1 and t["effects"][0] in STRENGTH for t in truth)
    assert min(next(iter(t["visibility"].values())) for t in truth) < 20


def test_the_kind_of_each_campaign_is_told():
    rng = np.random.default_rng(3)
    for kind in ("single", "none", "pair", "outside", "misstated", "one-load", "weak"):
        assert {kind_of(kind, names) for names in choose(rng, kind, 30)} == {kind}
    assert {kind_of("outside", names) for names in choose(rng, "outside", 30, outside=list(NEW_PHYSICS))} == {"outside-new-physics"}
    hidden = {"none": [], "single": ["sensor_lag"], "pair": ["sensor_lag", "axial_load"], "outside": [next(iter(OUTSIDE))]}
    assert {kind_of("outside", [name]) for name in LATER_PHYSICS} == {"outside"}
    assert {kind_of("outside", [name]) for name in FRESH_PHYSICS} == {"outside-fresh-physics"}
    assert {kind_of("outside", [name]) for name in BLIND_PHYSICS} == {"outside-blind-physics"}
    assert {kind: kind_of("mixed", names) for kind, names in hidden.items()} == {kind: kind for kind in hidden}


def test_kinds_choose_from_their_lists():
    some = lambda kind, **options: choose(np.random.default_rng(1), kind, 30, **options)
    assert {name for (name,) in some("outside")} == set(OUTSIDE)
    assert {name for (name,) in some("outside", outside=list(NEW_PHYSICS))} == set(NEW_PHYSICS)
    assert {name for (name,) in some("outside", outside=list(FURTHER_PHYSICS))} == set(FURTHER_PHYSICS)
    assert {name for (name,) in some("outside", outside=list(FRESH_PHYSICS))} == set(FRESH_PHYSICS)
    assert {name for (name,) in some("outside", outside=list(BLIND_PHYSICS))} == set(BLIND_PHYSICS)
    assert {name for (name,) in some("weak")} == set(STRENGTH)
    for kind in ("misstated", "one-load"):
        chosen = some(kind)
        assert chosen.count([]) == 6
        assert {name for names in chosen for name in names} == set(EFFECTS)
    assert not {name for kind in ("single", "pair", "mixed") for names in some(kind) for name in names} & set(NEW_PHYSICS)


@pytest.mark.parametrize("options", [
    ["--kind", "single", "--new-physics"],
    ["--kind", "outside", "--further-physics", "--fresh-physics"],
    ["--kind", "outside", "--fresh-physics", "--blind-physics"],
    ["--kind", "single", "--blind-physics"],
    ["--strength", "0"],
    ["--strength", "0.5", "--effect", "outside:ac_coupling"],
    ["--channel", "velocity", "--effect", "outside:frame_compliance"],
    ["--channel", "acceleration", "--effect", "outside:mains_hum"],
    ["--kind", "weak", "--effect", "third_mode"],
    ["--channel", "velocity", "--effect", "sensor_lag"],
    ["--channel", "acceleration", "--effect", "outside:sensor_drift"],
    ["--place", "0.7", "--effect", "sensor_lag"],
    ["--place", "0.7", "--channel", "acceleration"],
    ["--place", "70"],
])
def test_options_without_a_meaning_are_refused(options):
    with pytest.raises(SystemExit):
        parse(["--out", "unused", *options])


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
