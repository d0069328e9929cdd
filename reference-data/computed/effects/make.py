"""Motions with each catalogue effect, with pairs of them, and with effects outside the catalogue that a formula can state, from the independent simulation beside this folder.

    python make.py            writes motions.json

Each motion is integrated with two step sizes; it is kept up to the time at which they differ by more than 1e-10 m, or in a transition.
"""

import itertools
import json
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "generator"))
from make_campaigns import EXCLUDED_PAIRS  # noqa: E402
from simulate import EFFECTS, OUTSIDE, Rig, Z, simulate, start  # noqa: E402

STEPS = (1e-6, 5e-7)  # s
SPACING = 1e-3  # s between samples
DURATION = 0.1  # s
AGREE = 1e-10  # m
POINTS = [(100, 0.1), (60, 0.06), (41, 0.03), (120, 0.12)]  # N, m/s


def draw(rng, name):
    u = rng.uniform
    lu = lambda a, b: math.exp(u(math.log(a), math.log(b)))
    return {
        "belt_periodic_friction": lambda: {"amplitude": u(0.03, 0.3), "wavelength": lu(0.002, 0.05), "phase": u(-3, 3)},
        # 32 nodes, passed in their middle, where a periodic and a natural spline agree
        "belt_friction_profile": lambda: {"node_distance": 0.005, "node_values": u(-0.15, 0.15, 32).round(6).tolist(), "start": 0.075},
        "static_friction_aging": lambda: {"gain": u(0.05, 0.4), "time_constant": lu(0.001, 0.1), "form": rng.choice(["exp", "log"]).item()},
        "frictional_lag": lambda: {"time_constant": lu(1e-4, 5e-3)},
        "presliding_compliance": lambda: {"bristle_stiffness": lu(2e5, 3e6), "bristle_damping": lu(10, 200)},
        "third_mode": lambda: {"frequency": u(900, 1500), "damping_ratio": lu(1e-3, 1e-2)},
        "axial_load": lambda: {"softening": u(-4e-4, 4e-4)},
        "cubic_stiffness": lambda: {"coefficient": u(-2e9, 2e9)},
        "quadratic_drag": lambda: {"coefficient": lu(1, 100)},
        "normal_force_coupling": lambda: {"coefficient": u(-250, 250)},
        "normal_force_modulation": lambda: {"amplitude": u(0.02, 0.2), "frequency": lu(10, 300), "phase": u(-3, 3)},
        "belt_drive_compliance": lambda: {"mass": lu(0.3, 8), "stiffness": lu(3e3, 3e5), "damping": lu(3, 300)},
        "friction_drift": lambda: {"change": u(-0.3, 0.3), "time_constant": lu(0.02, 2)},
        "viscous_friction": lambda: {"coefficient": u(-0.2, 1)},
        "base_excitation": lambda: {"amplitude": lu(0.1, 10), "frequency": lu(5, 600), "phase": u(-3, 3)},
        "sensor_lag": lambda: {"time_constant": lu(2e-5, 2e-3)},
        "outside:quadratic_stiffness": lambda: {"coefficient": u(-3e6, 3e6)},
        "outside:impact_stop": lambda: {"stiffness": lu(1e3, 2e4), "gap": lu(3e-4, 1.2e-3)},
        "outside:direction_dependent_friction": lambda: {"asymmetry": u(-0.2, 0.2), "velocity_scale": lu(0.01, 0.1)},
        "outside:cubic_damping": lambda: {"coefficient": lu(10, 150)},
        "outside:belt_speed_ripple": lambda: {"amplitude": u(0.03, 0.3), "frequency": lu(10, 200), "phase": u(-3, 3)},
        "outside:asymmetric_damping": lambda: {"coefficient": lu(0.5, 8.0), "deflection_scale": 1e-4},
        "outside:parametric_stiffness": lambda: {"stiffness": lu(200, 2000), "frequency": lu(10, 200), "phase": u(-3, 3)},
        "outside:normal_force_speed_coupling": lambda: {"coefficient": u(-0.6, 0.6)},
    }[name]()


def motion(rng, names, k):
    effects = {name: draw(rng, name) for name in names}
    normal_force, belt_velocity = POINTS[k % len(POINTS)]
    rig = Rig(effects=effects)
    force = 0.66 * normal_force * rng.uniform(0.5, 0.75)
    q = [p * force / rig.mass / (2 * np.pi * f) ** 2 for p, f in zip((2.0, -2.0), rig.frequencies)]
    ripple = effects.get("outside:belt_speed_ripple", {"amplitude": 0.0, "phase": 0.0})
    belt = belt_velocity * (1 + ripple["amplitude"] * math.cos(ripple["phase"]))
    begin = start(rig, q, [belt / 2, 0.0], mode=0)
    if "presliding_compliance" in effects:
        begin.y[2 * rig.modes() + Z] = -force / effects["presliding_compliance"]["bristle_stiffness"]
    records = [simulate(rig, normal_force, belt_velocity, begin, duration=DURATION, dt=SPACING, level=0.97, substep=s) for s in STEPS]
    a, b = (r.measured for r in records)
    apart = np.flatnonzero(~(np.abs(a - b) <= AGREE))
    n = int(apart[0]) if apart.size else a.size
    until = (n - 1) * SPACING
    events = [r.events[r.events[:, 0] < until] for r in records]
    if np.abs(b[:n]).max(initial=0) > 5e-3:  # beyond what the beam stands
        return None
    if n < 20 or len(events[0]) != len(events[1]) or np.abs(events[0] - events[1]).max(initial=0) > 1e-7:
        return None
    return {"normal_force_n": normal_force, "belt_velocity_m_per_s": belt_velocity, "friction_level": 0.97, "effects": effects,
            "start": begin.named(rig.modes()), "spacing_s": SPACING, "measured_displacement_m": b[:n].tolist(),
            "transitions": [] if "presliding_compliance" in effects else [[float(t), int(m)] for t, m in events[1]]}


def main():
    rng = np.random.default_rng(20)
    wanted = [[name] for name in EFFECTS for _ in range(3)]
    pairs = [list(p) for p in itertools.combinations(EFFECTS, 2) if set(p) not in EXCLUDED_PAIRS]
    outside = [name for name in OUTSIDE if name not in ("outside:random_friction", "outside:rate_and_state")]
    wanted += [[name] for name in outside for _ in range(2)]
    wanted += [pairs[i] for i in rng.permutation(len(pairs))[:30]]
    out = []
    for k, names in enumerate(wanted):
        for _ in range(20):
            found = motion(rng, names, k)
            if found:
                break
        else:
            sys.exit(f"{names}: no motion is good for 20 ms")
        out.append(found)
        print(names, len(found["measured_displacement_m"]), "ms,", len(found["transitions"]), "transitions")
    path = Path(__file__).parent / "motions.json"
    path.write_text("[\n" + ",\n".join(json.dumps(m) for m in out) + "\n]\n")


if __name__ == "__main__":
    main()
