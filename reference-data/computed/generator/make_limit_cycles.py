"""Reference limit cycles of the default model (two modes, nominal beam, eq. 7 with the exponent read as |v_r|/c1).

Start: in stick at t = 0, the beam bent by 0.95 mu_0 F_N, first mode moving with the belt:
    q_j = phi_j(1) 0.95 mu_0 F_N / (m w_j^2),   q_1' = v_0 / 2,   q_2' = 0
and the last cycles of a run of one second are kept, with time counted from that start.

    python make_limit_cycles.py        writes the CSV files and meta.toml of reference-data/computed/limit_cycles
"""

from pathlib import Path

import numpy as np

from meta import write_meta
from simulate import Rig, simulate, start

FOLDER = Path(__file__).resolve().parents[1] / "limit_cycles"
HEADER = "time_s,tip_displacement_m,tip_velocity_m_per_s,friction_force_n,contact_mode"
CASES = [  # N, m/s, window (s), sampling step (s)
    (36, 0.04, 0.1, 2.5e-4),
    (60, 0.06, 0.1, 2.5e-4),
    (100, 0.1, 0.1, 2.5e-4),
    (41, 0.21, 0.01, 2.5e-5),
]
END = 1.0  # s


def stick_start(rig, normal_force, belt_velocity):
    """The start above; N, m/s."""
    force = 0.95 * rig.mu_s * normal_force
    omega = 2 * np.pi * np.array(rig.frequencies)
    return start(rig, np.array([2.0, -2.0]) * force / (rig.mass * omega**2), [belt_velocity / 2, 0.0], mode=0)


def rows(normal_force, belt_velocity, window, dt, substep=1.25e-6):
    """The rows of one file as an array: time, tip displacement, tip velocity, friction force, contact mode."""
    rig = Rig()
    record = simulate(rig, normal_force, belt_velocity, stick_start(rig, normal_force, belt_velocity), duration=END, dt=dt, substep=substep)
    keep = record.t > END - window - dt / 2
    return np.column_stack([record.t, record.w, record.wd, record.force, record.mode])[keep]


def name(normal_force, belt_velocity):
    return f"{normal_force:g}N_{1000 * belt_velocity:g}mm_per_s.csv"


def main(folder=FOLDER):
    folder.mkdir(parents=True, exist_ok=True)
    for case in CASES:
        text = [HEADER] + [f"{r[0]:.6f},{r[1]:.12e},{r[2]:.12e},{r[3]:.10e},{int(r[4])}" for r in rows(*case)]
        (folder / name(*case[:2])).write_text("\n".join(text) + "\n")
    write_meta(
        folder,
        title="Limit cycles of the default model at four operating points",
        source="computed: generator/make_limit_cycles.py; model of Stelter 1992, eqs. 1-7; start and window as stated there",
        role="validation: motion after the transient, from an integration that shares no code with the project",
        consumers=["reference-data/computed/generator/test_generator.py", "harness/tests/observer_figures.rs", "tests/val_limit_cycles.rs"],
        channels=[
            ("time_s", "s", "from the stick start"),
            ("tip_displacement_m", "m", "positive along the belt's motion"),
            ("tip_velocity_m_per_s", "m/s", "positive along the belt's motion"),
            ("friction_force_n", "N", "on the tip, positive along the belt's motion; the constraint force in stick"),
            ("contact_mode", "1", "0 stick, -1 slip with the tip slower than the belt, +1 slip with the tip faster"),
        ],
        note="times of transition agree with other integrators to 1e-8 s; displacement to 1e-8 m, velocity to 1e-6 m/s, away from transitions",
    )


if __name__ == "__main__":
    main()
