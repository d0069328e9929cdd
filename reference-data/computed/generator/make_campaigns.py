"""Measurement campaigns from the simulated rig, with a hidden effect and their answers in truth.json.

Every campaign is drawn anew: the true beam and friction data lie around the nominal ones that campaign.toml states (nuisance errors),
every run starts anywhere on the belt, in stick at a random deflection or after a transient from there, its friction level scatters, and
the display adds white noise. A strength of the hidden effect is kept only if switching it off changes the motion plainly within 40 ms.

    python make_campaigns.py --out DIR --count N --seed S --kind KIND [--effect ID] [--new-physics] [--channel CHANNEL]
                             [--strength FACTOR]

KIND is one of
    single, pair, none   one, two or no effects of the catalogue
    outside              one that the catalogue does not have; with --new-physics one of simulate.NEW_PHYSICS, with
                         --further-physics one of simulate.FURTHER_PHYSICS, with --fresh-physics one of simulate.FRESH_PHYSICS,
                         with --blind-physics one of simulate.BLIND_PHYSICS
    mixed                single, pair, none and outside at random
    one-load             as single, or none in one of five campaigns; all runs at one operating point
    misstated            as single, or none in one of five campaigns; the rig is known only roughly, see draw_misstated()
    weak                 as single, of a third of the strength, under noise of 2 micrometres; not necessarily visible

With --strength FACTOR the strength of every hidden effect is multiplied by FACTOR after it was drawn: its parameter in STRENGTH or
OUTSIDE_STRENGTH, the one that the kind weak divides by 3. Effects without such a parameter are not hidden then. As ever, draws are repeated
until the effect is visible under some noise, so a small FACTOR also means less noise; only the kind weak hides what is not visible.

With --channel velocity a vibrometer measures the tip's velocity, with --channel acceleration an accelerometer its acceleration: no effect
of the sensor of displacements is hidden, "noise_m" and "offset_m" are "noise_m_per_s" and "offset_m_per_s", or "noise_m_per_s2" and
"offset_m_per_s2", and "channel" says so. The acceleration is the second time derivative of the displacement that a sensor without lag,
curve and drift shows, hence relative to the same: with base_excitation to the clamp that shakes. It is that of the equations of motion
at the instant of the sample, with the friction force there: in stick that of the belt's contact point. It jumps where the friction force
does (a sample just there has the value after it), and no filter of the sensor rounds the jump.

With --place X the sensor looks at the share X of the length and not at the tip, "place_stated" in truth.json; "place" is where it truly looks,
a few thousandths beside. No effect of the sensor is hidden then either.

With --further QUANTITY or QUANTITY@X a further sensor reads displacement, velocity, acceleration or friction_force in the same samples,
at the tip or at the share X of the length; the option may be repeated. "further" in truth.json: quantity, place stated and true, gain (true
factor over stated one, 1), noise and, for each run, offset (SI).

Conventions of truth.json: normal_force_n and belt_velocity_m_per_s of a run, and points, are as campaign.toml states them. The true ones
are weight and drive times those (true over stated, 1; left out where they are 1). tip: true phi_j(1) (1), left out where nominal.
kind: what sort of campaign it is: KIND, but for mixed, and outside-new-physics where the effect is one of simulate.NEW_PHYSICS;
likewise outside-further-physics, outside-fresh-physics and outside-blind-physics.
Times and phases count from the first sample of a run (t = 0), belt travel s = 0 there; units SI; the names under "parameters" are those of
simulate.PLACES. runs[i].start is the full state at the first sample, so a run can be replayed exactly: see replay().
visibility: root-mean-square difference over 40 ms with and without the effect, from the same state, over the noise; median over windows.
"""

import argparse
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from simulate import (
    BLIND_PHYSICS, EFFECTS, EXTRA, FRESH_PHYSICS, FURTHER_PHYSICS, LATER_PHYSICS, NEW_PHYSICS, OUTSIDE, PLACES, S, V0, WAVE_NUMBERS, X, XD,
    Y, Z, Rig, State, eigenfunction, simulate, start)

POINTS = [(36, 0.04), (41, 0.02), (60, 0.04), (60, 0.06), (80, 0.05), (80, 0.1), (100, 0.1), (100, 0.14), (120, 0.08), (120, 0.12)]
NOMINAL = {"natural_frequencies_hz": [80.0, 510.0], "damping_ratios": [0.00015, 0.00085], "mass_kg": 0.427}
TIP_STIFFNESS = 26.3e3  # N/m, 3EI/l^3 of the nominal beam
VISIBLE = (20.0, 4000.0)  # bounds on visibility
UNIT = {"displacement": "m", "velocity": "m_per_s", "acceleration": "m_per_s2"}  # of what is measured, as keys and columns have it
# Standard deviation of the display's noise, m, m/s, m/s^2; drawn log-uniform where the effect is visible. --kind weak has the upper end.
# That of a vibrometer is broad-band: 0.7 to 7 (um/s)/sqrt(Hz) up to the 5 kHz of the record, the lower end that of
# a prepared surface, the upper one that of speckle on a moving one; at a tip velocity of some 0.1 m/s that is 66 to 46 dB.
# So is that of an accelerometer: 0.3 to 7 (mm/s^2)/sqrt(Hz). Accelerometers with built-in electronics (IEPE) have some 0.01 to 0.3 m/s^2
# rms over 5 kHz, the more the smaller they are and the larger their range, and a light one of some 2000 m/s^2 is needed here; the noise
# of cable and input adds to it. At an rms tip acceleration of some 150 m/s^2 that is 78 to 50 dB.
NOISE = {"displacement": (5e-8, 2e-6), "velocity": (5e-5, 5e-4), "acceleration": (0.02, 0.5)}
# Of further sensors, and besides that of a friction force: a load cell of 500 N has some 0.01 to 0.1 % of its range over 5 kHz.
FURTHER_NOISE = NOISE | {"friction_force": (0.05, 0.5)}
# Of the zero of a further sensor from run to run: half a micrometre, of a vibrometer, of an accelerometer as below, of a load cell.
FURTHER_OFFSET = {"displacement": 5e-7, "velocity": 1e-4, "acceleration": 0.02, "friction_force": 0.2}
FURTHER_UNIT = UNIT | {"friction_force": "n"}
RESOLUTION = {"displacement": 2.5e-9, "velocity": 1e-6, "acceleration": 1e-3}  # steps of the display, m, m/s, m/s^2
# Standard deviation of the offset from run to run, m, m/s, m/s^2. An accelerometer's is what is left of the bias of its electronics
# behind the coupling capacitor and the input's own: up to some 0.05 m/s^2, 0.05 mV at 1 mV/(m/s^2).
OFFSET = {"displacement": 0.0, "velocity": 0.0, "acceleration": 0.02}
OF_SENSOR = ("sensor_lag", "outside:quadratic_sensor", "outside:cubic_sensor", "outside:sensor_saturation", "outside:sensor_drift",
             "outside:mains_hum", "outside:ac_coupling", "outside:frame_compliance")
COARSE = {False: 5e-6, True: 2e-6}  # integration step where the motion itself is not kept, s; True: with bristles
WEAKER = 3.0  # --kind weak: draw_effect's strength over this
STRENGTH = {  # effects with an amplitude, and its name
    "belt_periodic_friction": "amplitude",
    "belt_friction_profile": "rms",
    "static_friction_aging": "gain",
    "axial_load": "softening",
    "cubic_stiffness": "coefficient",
    "quadratic_drag": "coefficient",
    "normal_force_coupling": "coefficient",
    "normal_force_modulation": "amplitude",
    "friction_drift": "change",
    "viscous_friction": "coefficient",
    "base_excitation": "amplitude",
}
# The same of the others: the parameters in which the effect is linear, at least while it is small. Scales, time constants and levels
# are none, so an effect that has nothing else is left out.
OUTSIDE_STRENGTH = {
    "outside:quadratic_stiffness": ("coefficient",),
    "outside:impact_stop": ("stiffness",),
    "outside:direction_dependent_friction": ("asymmetry",),
    "outside:cubic_damping": ("coefficient",),
    "outside:belt_speed_ripple": ("amplitude",),
    "outside:random_friction": ("scatter",),
    "outside:asymmetric_damping": ("coefficient",),
    "outside:parametric_stiffness": ("stiffness",),
    "outside:normal_force_speed_coupling": ("coefficient",),
    "outside:frequency_drift": ("change",),
    "outside:ageing_law": ("gain",),
    "outside:frictional_heating": ("coefficient",),
    "outside:hysteresis": ("stiffness", "slip_force"),  # both, so that it slips from the same deflection on
    "outside:quadratic_sensor": ("curvature",),
    "outside:cubic_sensor": ("curvature",),
    "outside:sensor_drift": ("change",),
    "outside:magnet": ("strength",),
    "outside:belt_slowing": ("change",),
    "outside:friction_by_deflection": ("change",),
    "outside:speed_memory": ("gain",),
    "outside:frequency_by_amplitude": ("change",),
    "outside:absorber": ("mass",),
    "outside:friction_by_load": ("exponent",),
    "outside:mains_hum": ("amplitude",),
    "outside:lagging_load": ("coefficient",),
    "outside:eccentric_pulley": ("amplitude",),
    "outside:frequency_step": ("change",),
    "outside:run_in": ("change",),
    "outside:resonant_load": ("coefficient",),
    "outside:motor_slip": ("slip",),
    "outside:damping_by_amplitude": ("increase",),
    "outside:frequency_by_heat": ("coefficient",),
    "outside:clamp_play": ("share",),
    "outside:friction_by_vibration": ("gain",),
    "outside:hersey_number": ("exponent",),
    "outside:frame_compliance": ("compliance",),
}
PER_RUN = ("phase", "start")  # parameters with a value of their own in each run
EXCLUDED_PAIRS = [  # pairs without a common meaning: a bristle has neither a dwell time nor a break-away
    {"presliding_compliance", "static_friction_aging"},
    {"presliding_compliance", "frictional_lag"},
]


def log_uniform(rng, low, high):
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def sign(rng):
    return 1.0 if rng.random() < 0.5 else -1.0


def smooth_profile(rng):
    """Belt friction g(s) (1): Gaussian process on a periodic belt of about 1.5 m, four nodes per length.

    Correlation exp(-(distance / correlation_length)^2)."""
    length, rms = log_uniform(rng, 0.005, 0.03), log_uniform(rng, 0.02, 0.1)
    dx = length / 4
    n = math.ceil(1.5 / dx)
    k = np.fft.rfftfreq(n, dx) * 2 * np.pi
    g = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) * np.exp(-((k * length) ** 2) / 8), n)
    g -= g.mean()
    g *= rms / g.std()
    return {"rms": rms, "correlation_length": length, "node_distance": dx, "node_values": np.round(g, 9).tolist()}


def draw_effect(rng, name, f1):
    """Random strength of one effect; units as in simulate.py."""
    lu = lambda a, b: log_uniform(rng, a, b)
    if name == "belt_drive_compliance":
        mass, omega, zeta = lu(0.5, 3.0), 2 * math.pi * lu(8, 40), lu(0.05, 0.3)
        return {"mass": mass, "stiffness": mass * omega**2, "damping": 2 * zeta * mass * omega}
    if name == "belt_friction_profile":
        return smooth_profile(rng)
    if name == "third_mode":
        f3 = f1 * (WAVE_NUMBERS[2] / WAVE_NUMBERS[0]) ** 2 * (1 + 0.03 * float(np.clip(rng.standard_normal(), -2.5, 2.5)))
        return {"frequency": f3, "damping_ratio": 0.003 * lu(0.6, 1.6)}
    if name == "outside:random_friction":
        return {"scatter": lu(0.01, 0.05), "draws": np.round(rng.standard_normal(1024), 6).tolist()}
    return {
        "belt_periodic_friction": lambda: {"amplitude": lu(0.03, 0.15), "wavelength": lu(0.005, 0.06)},
        "static_friction_aging": lambda: {"gain": lu(0.05, 0.3), "time_constant": lu(0.001, 0.05),
                                          "form": "exp" if rng.random() < 0.5 else "log"},
        "frictional_lag": lambda: {"time_constant": lu(2e-4, 3e-3)},
        "presliding_compliance": lambda: {"bristle_stiffness": lu(2e5, 3e6), "bristle_damping": lu(20, 200)},
        "axial_load": lambda: {"softening": 1.4e-4 * lu(0.5, 2.0)},
        "cubic_stiffness": lambda: {"coefficient": TIP_STIFFNESS * lu(0.01, 0.1) / lu(1e-3, 2e-3) ** 2},
        "quadratic_drag": lambda: {"coefficient": lu(1.0, 20.0)},
        "normal_force_coupling": lambda: {"coefficient": sign(rng) * lu(30, 200)},
        "normal_force_modulation": lambda: {"amplitude": lu(0.02, 0.12), "frequency": lu(15, 150)},
        "friction_drift": lambda: {"change": sign(rng) * lu(0.03, 0.15), "time_constant": lu(0.1, 0.6)},
        "viscous_friction": lambda: {"coefficient": lu(0.05, 0.5)},
        "base_excitation": lambda: {"amplitude": lu(0.2, 5.0), "frequency": lu(10, 200)},
        "sensor_lag": lambda: {"time_constant": lu(2e-5, 5e-4)},
        "outside:quadratic_stiffness": lambda: {"coefficient": sign(rng) * lu(0.5e6, 3e6)},
        "outside:impact_stop": lambda: {"stiffness": lu(1e3, 2e4), "gap": lu(0.3e-3, 1.2e-3)},
        "outside:rate_and_state": lambda: {"slip_distance": lu(3e-5, 6e-4)},
        "outside:direction_dependent_friction": lambda: {"asymmetry": sign(rng) * lu(0.05, 0.2), "velocity_scale": lu(0.01, 0.1)},
        "outside:cubic_damping": lambda: {"coefficient": lu(10, 150)},
        "outside:belt_speed_ripple": lambda: {"amplitude": lu(0.03, 0.2), "frequency": lu(10, 100)},
        "outside:asymmetric_damping": lambda: {"coefficient": lu(0.5, 8.0), "deflection_scale": 1e-4},
        "outside:parametric_stiffness": lambda: {"stiffness": TIP_STIFFNESS * lu(0.01, 0.08), "frequency": lu(10, 200)},
        "outside:normal_force_speed_coupling": lambda: {"coefficient": sign(rng) * lu(0.1, 0.6)},
        "outside:frequency_drift": lambda: {"change": sign(rng) * lu(0.005, 0.04), "time_constant": lu(0.1, 0.6)},
        "outside:ageing_law": lambda: {"gain": lu(0.01, 0.06), "slip_distance": lu(3e-5, 3e-4)},
        "outside:frictional_heating": lambda: heating(share=lu(0.02, 0.2), tau=lu(0.02, 0.3)),
        "outside:hysteresis": lambda: jenkins(TIP_STIFFNESS * lu(0.01, 0.1), lu(1e-4, 6e-4)),
        "outside:quadratic_sensor": lambda: {"curvature": sign(rng) * lu(3.0, 30.0)},
        "outside:cubic_sensor": lambda: {"curvature": sign(rng) * lu(3e3, 3e4)},
        "outside:sensor_saturation": lambda: {"level": lu(4e-3, 3e-2)},
        "outside:sensor_drift": lambda: {"change": sign(rng) * lu(3e-6, 1e-4), "time_constant": lu(0.1, 0.6)},
        "outside:magnet": lambda: magnet(TIP_STIFFNESS * lu(0.003, 0.05), lu(6e-3, 1.2e-2)),
        "outside:belt_slowing": lambda: {"change": sign(rng) * lu(0.01, 0.1), "time_constant": lu(0.1, 0.6)},
        "outside:friction_by_deflection": lambda: {"change": sign(rng) * lu(0.02, 0.15), "deflection_scale": lu(3e-4, 1.5e-3)},
        "outside:speed_memory": lambda: {"gain": sign(rng) * lu(0.1, 1.0), "time_constant": lu(0.005, 0.1)},
        "outside:frequency_by_amplitude": lambda: {"change": sign(rng) * lu(0.003, 0.03), "time_constant": lu(0.01, 0.2)},
        "outside:absorber": lambda: {"mass": lu(5e-4, 5e-3), "frequency": lu(100, 400), "damping_ratio": lu(0.01, 0.1)},
        "outside:mains_hum": lambda: {"amplitude": lu(1e-6, 1e-5), "frequency": 50.0 if rng.random() < 0.5 else 100.0},
        "outside:ac_coupling": lambda: {"time_constant": lu(0.05, 1.0)},
        "outside:lagging_load": lambda: {"coefficient": sign(rng) * lu(30, 200), "time_constant": lu(0.005, 0.1)},
        "outside:eccentric_pulley": lambda: {"amplitude": lu(0.005, 0.05), "circumference": lu(0.01, 0.15)},
        "outside:frequency_step": lambda: {"change": sign(rng) * lu(0.003, 0.03), "instant": lu(0.1, 0.4)},
        "outside:run_in": lambda: {"change": lu(0.03, 0.2), "distance": lu(0.01, 0.06)},
        "outside:resonant_load": lambda: {"coefficient": sign(rng) * lu(0.03, 0.3), "frequency": lu(120, 600), "damping_ratio": lu(0.03, 0.2)},
        "outside:motor_slip": lambda: {"slip": lu(0.005, 0.05)},
        "outside:damping_by_amplitude": lambda: {"increase": lu(3e-4, 6e-3), "time_constant": lu(0.01, 0.2)},
        "outside:frequency_by_heat": lambda: heating(share=lu(0.003, 0.03), tau=lu(0.02, 0.3), coefficient=3e-4),
        "outside:clamp_play": lambda: {"share": lu(0.01, 0.1), "play": lu(5e-5, 5e-4)},
        "outside:friction_by_vibration": lambda: {"gain": lu(0.02, 0.2) / 150.0**2, "time_constant": lu(0.005, 0.1)},
        "outside:hersey_number": lambda: {"exponent": lu(0.3, 1.0), "force": 80.0},
        "outside:frame_compliance": lambda: {"compliance": lu(2e-8, 5e-7)},
        "outside:friction_by_load": lambda: {"exponent": lu(0.15, 0.4), "force": 80.0},
    }[name]()


def magnet(stiffness, distance):
    """A magnet at a distance (m) that takes so much (N/m) of the tip's stiffness at w = 0."""
    return {"strength": 0.5 * stiffness * distance**3, "distance": distance}


def draw_weak_effect(rng, name, f1):
    """draw_effect() with a third of the strength."""
    return strengthened(name, draw_effect(rng, name, f1), over=WEAKER)


def strength_of(name):
    """Names of the parameters that are an effect's strength; none of one that has no amplitude."""
    return (STRENGTH[name],) if name in STRENGTH else OUTSIDE_STRENGTH.get(name, ())


def strengthened(name, values, factor=1.0, over=1.0):
    """The effect with factor/over times the strength."""
    values = values | {key: values[key] * factor / over for key in strength_of(name)}
    if name == "belt_friction_profile":
        values["node_values"] = np.round(np.array(values["node_values"]) * factor / over, 9).tolist()
    return values


def heating(share, tau, power=4.0, coefficient=0.003):
    """Friction, or a frequency, falls by about `share` (1) where a power (W) is dissipated for much longer than tau (s).

    k = 0.003 1/K as of the friction of polymers; a modulus that falls by some 0.05 % per kelvin lowers a frequency by half of that."""
    return {"coefficient": coefficient, "heat_capacity": coefficient * power * tau / share, "time_constant": tau}


def jenkins(stiffness, slip_deflection):
    """A Jenkins element of a stiffness (N/m) that slips from a deflection (m) on."""
    return {"stiffness": stiffness, "slip_force": stiffness * slip_deflection}


def draw_beam(rng):
    """True beam and friction data around the nominal ones (nuisance errors)."""
    normal = lambda s: float(np.clip(rng.standard_normal(), -2.5, 2.5)) * s
    return Rig(
        frequencies=[80.0 * (1 + normal(0.002)), 510.0 * (1 + normal(0.004))],
        damping=[0.00015 * rng.uniform(0.6, 1.4), 0.00085 * rng.uniform(0.6, 1.4)],
        mass=0.427 * (1 + rng.uniform(-0.01, 0.01)),
        mu_s=0.66 * (1 + rng.uniform(-0.02, 0.02)),
        v1=0.02 * (1 + rng.uniform(-0.1, 0.1)),
        a1=0.5 * (1 + rng.uniform(-0.04, 0.04)),
        c2=0.25 * (1 + rng.uniform(-0.2, 0.2)),
    )


def draw_misstated(rng):
    """A rig known only roughly: everything off by a share uniform within the bounds below, independently; damping as in draw_beam().

    Natural frequencies 0.5 %, modal mass 3 %, tip values 5 %, mu_s, a1, v1, a2, c2 10 %, belt speed 2 %, normal force 5 %."""
    off = lambda bound: 1 + rng.uniform(-bound, bound)
    return Rig(
        frequencies=[80.0 * off(0.005), 510.0 * off(0.005)],
        damping=[0.00015 * rng.uniform(0.6, 1.4), 0.00085 * rng.uniform(0.6, 1.4)],
        mass=0.427 * off(0.03),
        mu_s=0.66 * off(0.1), a1=0.5 * off(0.1), v1=0.02 * off(0.1), a2=0.5 * off(0.1), c2=0.25 * off(0.1),
        tip=[2.0 * off(0.05), -2.0 * off(0.05)],
        drive=off(0.02),
        weight=off(0.05),
    )


def shown(record, channel, place=None):
    """What a perfect sensor of the channel shows, m, m/s or m/s^2; at a share `place` of the length (1) if not at the tip."""
    if place is not None:
        n = record.n
        there = record.phi * np.array([eigenfunction(j, place) / eigenfunction(j, 1.0) for j in range(n)])
        return record.y[:, :n] @ there if channel == "displacement" else record.y[:, n : 2 * n] @ there
    return getattr(record, {"displacement": "measured", "velocity": "wd", "acceleration": "acceleration"}[channel])


def draw_further(rng, wanted, runs):
    """A further sensor, QUANTITY or QUANTITY@X: its calibration is off by about 1 %, its place by a few thousandths of the length."""
    quantity, _, place = wanted.partition("@")
    sensor = {"quantity": quantity, "gain": 1 + 0.01 * float(np.clip(rng.standard_normal(), -2.5, 2.5)),
              "noise": log_uniform(rng, *FURTHER_NOISE[quantity]),
              "offsets": [FURTHER_OFFSET[quantity] * float(rng.standard_normal()) for _ in range(runs)]}
    if place:
        sensor |= {"place_stated": float(place), "place": float(place) + 0.003 * float(rng.standard_normal())}
    return sensor


def further_column(sensor, record, i, rng):
    """Header and values (SI) of a further sensor in run i (from 0)."""
    quantity = sensor["quantity"]
    tip = {"displacement": "w", "velocity": "wd", "acceleration": "acceleration", "friction_force": "force"}
    place = sensor.get("place")
    x = getattr(record, tip[quantity]) if place is None else shown(record, quantity, place)
    x = x[:-1] * sensor["gain"] + sensor["offsets"][i]
    x = x + sensor["noise"] * rng.standard_normal(x.size)
    at = "" if place is None else f"_at_{sensor['place_stated']:g}"
    return f"{quantity}{at}_{FURTHER_UNIT[quantity]}", x


def run_effects(effects, run):
    """The effects with the values of their own that a run has (phases, place on the belt)."""
    return {name: {**values, **run["own"].get(name, {})} for name, values in effects.items()}


def with_effects(rig, effects):
    return replace(rig, effects=effects)


def draw_run(rng, rig, effects, point, args):
    """A run's own values, its state after a random transient, and its record. None if the motion leaves the model's range."""
    normal_force, belt_velocity = point
    offset = OFFSET[args.channel] if args.offset is None else args.offset
    run = {
        "normal_force_n": normal_force, "belt_velocity_m_per_s": belt_velocity,
        "friction_level": 1 + args.level_scatter * float(rng.standard_normal()),
        f"offset_{UNIT[args.channel]}": offset * float(rng.standard_normal()),
        "own": {name: {key: float(rng.uniform(0, 2 * np.pi) if key == "phase" else rng.uniform(0, 1.5))
                       for key in PLACES[name] if key in PER_RUN} for name in effects},
    }
    truth_rig = with_effects(rig, run_effects(effects, run))
    # in stick below break-away, the beam bent by a constant force: from there the large stick-slip cycle builds up, and may later give
    # way to the small one near the second natural frequency that coexists with it
    transient = round(float(rng.uniform(0.01, 0.3)), 4) if rng.random() < args.transients else 0.0
    force = rig.mu_s * rig.weight * normal_force * rng.uniform(0.3, 0.95)
    q = [p * force / rig.mass / (2 * np.pi * f) ** 2 for p, f in zip(rig.tip, rig.frequencies)]
    belt = float(truth_rig.build(normal_force, belt_velocity)["p"][V0])  # with what a loaded motor falls behind
    state = start(truth_rig, q, [belt / rig.tip[0], 0.0], mode=0)
    if "presliding_compliance" in effects:
        state.y[2 * truth_rig.modes() + Z] = -force / effects["presliding_compliance"]["bristle_stiffness"]
    state.stick_since = -transient
    state.event_number = int(rng.integers(1024))
    before = simulate(truth_rig, normal_force, belt_velocity, state, t0=-transient, duration=transient, level=run["friction_level"],
                      substep=COARSE["presliding_compliance" in effects])
    state = before.state(-1)
    place = 2 * before.n + S
    if not np.all(np.isfinite(state.y)):
        return None
    travel, state.y[place] = float(state.y[place]), 0.0
    if "belt_periodic_friction" in effects:
        own = run["own"]["belt_periodic_friction"]
        own["phase"] = (own["phase"] + 2 * np.pi * travel / effects["belt_periodic_friction"]["wavelength"]) % (2 * np.pi)
    if "belt_friction_profile" in effects:
        run["own"]["belt_friction_profile"]["start"] += travel
    run["start"] = state.named(before.n)
    record = simulate(with_effects(rig, run_effects(effects, run)), normal_force, belt_velocity, state, duration=args.duration,
                      level=run["friction_level"])
    if not np.all(np.isfinite(record.y)) or np.abs(record.w).max() > 8e-3:
        return None
    return run, record


def convert(state, n, other, belt_velocity):
    """The state of one model as a start for the same rig with fewer effects: what only the dropped effect carries is left out.

    belt_velocity: the true one, m/s."""
    m = other.modes()
    y = np.zeros(2 * m + EXTRA)
    keep = min(n, m)
    y[:keep], y[m : m + keep], y[2 * m :] = state.y[:keep], state.y[n : n + keep], state.y[2 * n :]
    phi = other.tip_values()
    if "belt_drive_compliance" not in other.effects:
        y[2 * m + X] = y[2 * m + XD] = 0.0
    if "sensor_lag" not in other.effects:
        y[2 * m + Y] = phi @ y[:m]
    mode = state.mode
    slip = phi @ y[m : 2 * m] - belt_velocity - y[2 * m + XD]
    if mode == 0 and "presliding_compliance" not in other.effects:
        y[m : 2 * m] -= phi / (phi @ phi) * slip
    elif mode != 0:
        mode = 1 if slip > 0 else -1
    return State(y, mode, state.stick_since, state.event_number)


def visibility(rig, effects, runs, records, dropped, windows=4, window=0.04, channel="displacement", place=None):
    """Median over windows of the rms difference (m, m/s or m/s^2) over 40 ms of what is measured with and without one effect."""
    found = []
    for run, record in zip(runs, records):
        others = {k: v for k, v in run_effects(effects, run).items() if k != dropped}
        reduced = with_effects(rig, others)
        samples = round(window / 1e-4)
        for i in np.linspace(0, len(record.t) - 1 - samples, windows).astype(int):
            state = convert(record.state(i), record.n, reduced, rig.drive * run["belt_velocity_m_per_s"])
            without = simulate(reduced, run["normal_force_n"], run["belt_velocity_m_per_s"], state, t0=record.t[i], duration=window,
                               level=run["friction_level"], substep=COARSE["presliding_compliance" in others])
            difference = shown(record, channel, place)[i : i + samples + 1] - shown(without, channel, place)
            found.append(float(np.sqrt(np.mean(difference**2))))
    return float(np.median(found))


def draw_points(rng, args):
    """Operating points (N, m/s) of a campaign's runs."""
    if args.kind == "one-load":
        return [POINTS[int(rng.integers(len(POINTS)))]] * (args.runs or 4)
    return [POINTS[i] for i in rng.permutation(len(POINTS))[: args.runs or 6]]


def noise_bounds(size, args):
    """Least and largest noise under which the effects are plainly visible; size: {effect: visible difference}. m, m/s or m/s^2."""
    bounds = NOISE[args.channel]
    if args.kind == "weak":
        return [args.noise or bounds[1]] * 2
    low = max([bounds[0]] + [value / VISIBLE[1] for value in size.values()])
    high = min([bounds[1]] + [value / VISIBLE[0] for value in size.values()])
    return (max(low, args.noise), min(high, args.noise)) if args.noise else (low, high)


def draw_campaign(rng, names, args, points=None, effects=None):
    """One campaign: (truth without its name, records). Redraws until every hidden effect is plainly visible.

    points: operating points (N, m/s) instead of random ones; effects: {id: parameters} instead of random strengths."""
    fixed = points, effects
    for _ in range(60):
        rig = draw_misstated(rng) if args.kind == "misstated" else draw_beam(rng)
        draw = draw_weak_effect if args.kind == "weak" else draw_effect
        effects = fixed[1] or {name: draw(rng, name, rig.frequencies[0]) for name in names}
        if args.strength != 1.0 and not fixed[1]:
            effects = {name: strengthened(name, values, args.strength) for name, values in effects.items()}
        points = fixed[0] or draw_points(rng, args)
        drawn = [draw_run(rng, rig, effects, point, args) for point in points]
        if any(d is None for d in drawn):
            continue
        runs, records = [d[0] for d in drawn], [d[1] for d in drawn]
        # The laser's spot is a few millimetres on a metre beside where it was measured to be.
        place = None if args.place is None else float(args.place + 0.003 * rng.standard_normal())
        size = {name: visibility(rig, effects, runs, records, name, channel=args.channel, place=place) for name in names}
        low, high = noise_bounds(size, args)
        if low <= high:
            noise = log_uniform(rng, low, high)
            seen = {name: value / noise for name, value in size.items()}
            break
    else:
        raise RuntimeError(f"no visible strength found for {names}")
    frequencies, damping = list(rig.frequencies), list(rig.damping)
    if "third_mode" in effects:
        frequencies.append(effects["third_mode"]["frequency"])
        damping.append(effects["third_mode"]["damping_ratio"])
    truth = {
        "effects": list(names), "parameters": effects, f"noise_{UNIT[args.channel]}": noise, "true_f_hz": frequencies, "true_D": damping,
        "true_mass": rig.mass, "true_law": {"mus": rig.mu_s, "v1": rig.v1, "a1": rig.a1, "a2": rig.a2, "c2": rig.c2},
        "points": [list(p) for p in points], "visibility": seen, "runs": runs,
    }
    if args.channel != "displacement":
        truth["channel"] = args.channel
    if place is not None:
        truth |= {"place": place, "place_stated": args.place}
    if args.further:
        truth["further"] = [draw_further(rng, wanted, len(runs)) for wanted in args.further]
    if args.kind == "misstated":
        truth |= {"drive": rig.drive, "weight": rig.weight, "tip": with_effects(rig, effects).tip_values().tolist()}
    return truth, records


def true_rig(truth):
    """Beam, friction law, tip values, drive and weight as truth.json describes them, without effects."""
    law = truth["true_law"]
    return Rig(truth["true_f_hz"][:2], truth["true_D"][:2], truth["true_mass"], law["mus"], law["a1"], law["v1"], law["a2"], law["c2"],
               tip=truth.get("tip", [2.0, -2.0])[:2], drive=truth.get("drive", 1.0), weight=truth.get("weight", 1.0))


def replay(truth, i, duration=0.6, dt=1e-4):
    """The record of run i (from 0) of a campaign as truth.json describes it: noise-free, bit for bit the one it was made from."""
    run = truth["runs"][i]
    rig = with_effects(true_rig(truth), run_effects(truth["parameters"], run))
    return simulate(rig, run["normal_force_n"], run["belt_velocity_m_per_s"], State.from_named(run["start"]), duration=duration, dt=dt,
                    level=run["friction_level"])


def write_run(folder, file, run, record, noise, rng, channel="displacement", place=None, further=()):
    """One CSV: the measured channel, offset, white noise, display steps (m, m/s, m/s^2), and further columns (header, values).

    Returns its lines of campaign.toml."""
    t, x = record.t[:-1], shown(record, channel, place)[:-1]
    x = x + run[f"offset_{UNIT[channel]}"] + noise * rng.standard_normal(x.size)
    x = np.round(x / RESOLUTION[channel]) * RESOLUTION[channel]
    heads = "".join(f",{head}" for head, _ in further)
    text = [f"time_s,tip_{channel}_{UNIT[channel]}{heads}"]
    text += [f"{a:.4f},{b:.10f}" + "".join(f",{values[k]:.10f}" for _, values in further) for k, (a, b) in enumerate(zip(t, x))]
    (folder / file).write_text("\n".join(text) + "\n")
    return ["", "[[run]]", f'file = "{file}"', f"belt_velocity_m_per_s = {run['belt_velocity_m_per_s']:g}",
            f"normal_force_n = {run['normal_force_n']:g}"]


def write_campaign(folder, name, truth, records, rng):
    """campaign.toml with the nominal beam, and one CSV per run."""
    folder.mkdir(parents=True, exist_ok=True)
    known = "nominal, a few percent uncertain; so are the belt speeds, all by one factor, and the normal forces" if "drive" in truth else (
        "as identified by modal analysis before the tests; a few tenths of a percent uncertain")
    channel = truth.get("channel", "displacement")
    sensor = "accelerometer" if channel == "acceleration" else "laser vibrometer"
    in_words = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}[channel]
    lines = [f'name = "{name}"', f"# tip {channel} by {sensor}; time in s, {channel} in {in_words}", "", f"[beam]  # {known}"]
    lines += [f"{key} = {value}" for key, value in NOMINAL.items()]
    if "place" in truth:
        lines += ["", "[sensor]", f"position = {truth['place_stated']:g}"]
    sensors = truth.get("further", [])
    for sensor in sensors:
        head, _ = further_column(sensor, records[0], 0, np.random.default_rng(0))
        lines += ["", "[[further_sensor]]", f'quantity = "{sensor["quantity"]}"', f'column = "{head}"']
        if "place_stated" in sensor:
            lines += [f"position = {sensor['place_stated']:g}"]
    if channel != "displacement" or sensors:
        lines += ["", "[channels]", f'{channel}_column = "tip_{channel}_{UNIT[channel]}"']
    noise = truth[f"noise_{UNIT[channel]}"]
    for i, (run, record) in enumerate(zip(truth["runs"], records)):
        further = [further_column(sensor, record, i, rng) for sensor in sensors]
        lines += write_run(folder, f"run{i + 1:02d}.csv", run, record, noise, rng, channel, truth.get("place"), further)
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")


def choose(rng, kind, count, effect=None, outside=tuple(OUTSIDE), channel="displacement", place=None, strength=1.0):
    """Which effects each campaign hides. Cycles through the catalogue in a random order, so that all turn up."""
    catalogue = list(STRENGTH if kind == "weak" else EFFECTS)
    if strength != 1.0:
        catalogue, outside = ([name for name in ids if strength_of(name)] for ids in (catalogue, outside))
    if channel != "displacement" or place is not None:
        catalogue, outside = ([name for name in ids if name not in OF_SENSOR] for ids in (catalogue, outside))
    cycle = lambda ids: [list(ids)[j] for _ in range(count // len(ids) + 1) for j in rng.permutation(len(ids))]
    singles, outsides = cycle(catalogue), cycle(outside)

    def one(kind, i):
        if kind == "none":
            return []
        if kind in ("single", "weak"):
            return [effect or singles[i]]
        if kind == "outside":
            return [effect or outsides[i]]
        while True:
            pair = [effect or singles[i], str(rng.choice(catalogue))]
            if pair[0] != pair[1] and set(pair) not in EXCLUDED_PAIRS:
                return pair

    if kind in ("misstated", "one-load"):
        empty, rest = rng.permutation(count)[: count // 5], iter(singles)
        return [[] if i in empty else [effect or next(rest)] for i in range(count)]
    if kind == "mixed":
        kinds = rng.choice(["single", "none", "outside", "pair"], size=count, p=[0.6, 0.1, 0.15, 0.15])
        return [one(str(k), i) for i, k in enumerate(kinds)]
    return [one(kind, i) for i in range(count)]


def kind_of(kind, names):
    """The kind of a campaign that hides these effects, as truth.json has it."""
    if kind not in ("mixed", "outside"):
        return kind
    if any(name in NEW_PHYSICS for name in names):
        return "outside-new-physics"
    if any(name in FURTHER_PHYSICS for name in names):
        return "outside-further-physics"
    if any(name in FRESH_PHYSICS for name in names):
        return "outside-fresh-physics"
    if any(name in BLIND_PHYSICS for name in names):
        return "outside-blind-physics"
    if any(name in OUTSIDE or name in LATER_PHYSICS for name in names):
        return "outside"
    return ["none", "single", "pair"][len(names)]


def parser():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("--count", type=int, default=1)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--kind", choices=["single", "none", "pair", "outside", "mixed", "misstated", "one-load", "weak"], default="mixed")
    p.add_argument("--effect", choices=list(PLACES), help="hide this effect (with a kind that hides any)")
    p.add_argument("--new-physics", action="store_true", help="effects outside the catalogue are those that nothing in the project mirrors")
    p.add_argument("--further-physics", action="store_true", help="the same, of the kinds that were written when the diagnosis was finished")
    p.add_argument("--fresh-physics", action="store_true", help="the same, of the kinds that were written last, after it was frozen")
    p.add_argument("--blind-physics", action="store_true", help="the same, of the kinds that were written without a look at it")
    p.add_argument("--strength", type=float, default=1.0, help="factor on the strength of the hidden effects, 1")
    p.add_argument("--runs", type=int, help="runs of a campaign; without it 6, with --kind one-load 4")
    p.add_argument("--duration", type=float, default=0.6, help="of a run, s")
    p.add_argument("--transients", type=float, default=0.25, help="share of runs that start after a transient of 10 to 300 ms")
    p.add_argument("--channel", choices=list(UNIT), default="displacement", help="what the sensor measures")
    p.add_argument("--place", type=float, help="the sensor looks at this share of the beam's length from the clamp, 1; without it at the tip")
    p.add_argument("--further", action="append", default=[], metavar="QUANTITY[@X]", help="a further sensor; may be repeated")
    p.add_argument("--noise", type=float, default=0.0,
                   help="standard deviation, m (m/s, m/s^2); 0 draws it from 0.05 to 2 micrometres, and is 2 micrometres with --kind weak; "
                        "of a velocity from 0.05 to 0.5 mm/s, and 0.5 mm/s; of an acceleration from 0.02 to 0.5 m/s^2, and 0.5 m/s^2")
    p.add_argument("--offset", type=float,
                   help="standard deviation of the sensor's offset, m (m/s, m/s^2); without it 0, of an acceleration 0.02 m/s^2")
    p.add_argument("--level-scatter", type=float, default=0.005, help="standard deviation of the friction level from run to run, 1")
    return p


def parse(argv=None):
    p = parser()
    args = p.parse_args(argv)
    chosen = [args.new_physics, args.further_physics, args.fresh_physics, args.blind_physics]
    if any(chosen) and args.kind not in ("outside", "mixed"):
        p.error("--new-physics, --further-physics, --fresh-physics and --blind-physics go with --kind outside or mixed")
    if sum(chosen) > 1:
        p.error("--new-physics, --further-physics, --fresh-physics and --blind-physics exclude each other")
    if not 0.0 < args.strength < math.inf:
        p.error("--strength is a positive number")
    if args.strength != 1.0 and args.effect and not strength_of(args.effect):
        p.error(f"{args.effect} has no amplitude for --strength")
    if args.kind == "weak" and args.effect and args.effect not in STRENGTH:
        p.error(f"{args.effect} has no amplitude for --kind weak")
    if args.channel != "displacement" and args.effect in OF_SENSOR:
        p.error(f"{args.effect} acts on a sensor of displacements, which --channel {args.channel} does not have")
    if args.place is not None and args.effect in OF_SENSOR:
        p.error(f"{args.effect} acts on a sensor at the tip, which --place does not have")
    if args.place is not None and (args.channel == "acceleration" or not 0.1 <= args.place <= 1.0):
        p.error("--place is from 0.1 to 1, of a displacement or a velocity")
    for wanted in args.further:
        quantity, at, place = wanted.partition("@")
        is_place = re.fullmatch(r"0?\.[1-9]\d*|1(\.0*)?", place) and quantity in ("displacement", "velocity")
        if quantity not in FURTHER_UNIT or (at and not is_place) or args.further.count(wanted) > 1:
            p.error(f"--further {wanted}: once each of {', '.join(FURTHER_UNIT)}, with @X from 0.1 to 1 for displacement or velocity")
    return args


def main(argv=None):
    args = parse(argv)
    rng = np.random.default_rng(args.seed)
    answers = []
    outside = (NEW_PHYSICS if args.new_physics else FURTHER_PHYSICS if args.further_physics
               else FRESH_PHYSICS if args.fresh_physics else BLIND_PHYSICS if args.blind_physics else OUTSIDE)
    chosen = choose(rng, args.kind, args.count, args.effect, list(outside), args.channel, args.place, args.strength)
    for i, names in enumerate(chosen, 1):
        own = np.random.default_rng([args.seed, i])
        truth, records = draw_campaign(own, names, args)
        name = f"{i:03d}"
        write_campaign(args.out / name, f"campaign {name}", truth, records, own)
        answers.append({"campaign": name, "kind": kind_of(args.kind, names), **truth})
        (args.out / "truth.json").write_text(json.dumps(answers, indent=1) + "\n")
        noise = truth[f"noise_{UNIT[args.channel]}"]
        print(name, names, {k: round(v) for k, v in truth["visibility"].items()}, f"noise {noise:.2e}", flush=True)


if __name__ == "__main__":
    main()
