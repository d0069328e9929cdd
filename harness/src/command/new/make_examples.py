"""Writes the example files of the templates, by this project's own FMU.

    python make_examples.py PATH/OF/stickslip

Each is a simulation of the machine in campaign.toml, with white sensor noise; numbers are rounded to
a hundredth of that noise.
"""

import csv
import io
import math
import pathlib
import random
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
PROGRAM = sys.argv[1]


def simulate(settings, belt, load, duration, step, inputs=None, settle=0.0):
    """Rows of time (s) and tip displacement (m)."""
    command = [PROGRAM, "simulate", "--belt-velocity", str(belt), "--normal-force", str(load)]
    for name, value in settings.items():
        command += ["--set", f"{name}={value}"]
    command += ["--duration", str(duration + settle), "--step", str(step)]
    command += ["--variables", "tip_displacement"]
    with tempfile.TemporaryDirectory() as folder:
        if inputs:
            path = pathlib.Path(folder) / "input.csv"
            path.write_text("time,external_force\n" + "".join(f"{t!r},{f!r}\n" for t, f in inputs))
            command += ["--input", str(path)]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = [(float(t), float(w)) for t, w in list(csv.reader(io.StringIO(text)))[1:]]
    first = round(settle / step)
    return [(t - first * step, w) for t, w in rows[first:]]


def write(path, rows, noise, forces=None):
    random.seed(7)
    digits = 2 - math.floor(math.log10(noise))
    header = "time_s,tip_displacement_m" + (",external_force_n" if forces else "")
    lines = [header]
    for i, (t, w) in enumerate(rows):
        line = f"{t:.6f},{w + random.gauss(0.0, noise):.{digits}f}"
        if forces:
            line += f",{forces[i][1]:.4f}"
        lines.append(line)
    (HERE / path).write_text("\n".join(lines) + "\n")


def one_mode(frequency, damping, mass):
    return {
        "mode_count": 1,
        "mode[1].frequency": frequency,
        "mode[1].damping_ratio": damping,
        "mode[1].mass": mass,
        "mode[1].tip_value": 1.0,
    }


def force(duration, step, course):
    count = round(duration / step) + 1
    return [(i * step, round(course(i * step), 4)) for i in range(count)]


def chirp(low, high, duration, size):
    """A sine whose frequency rises from low to high (Hz), swelling at its beginning."""

    def course(t):
        phase = 2 * math.pi * (low * t + (high - low) * t * t / (2 * duration))
        return size * min(1.0, t / (0.1 * duration)) * math.sin(phase)

    return course


for name, belt, load in [("run01", 0.06, 60), ("run02", 0.1, 80)]:
    rows = simulate({}, belt, load, 0.15, 1e-4, settle=1.0)
    write(f"beam-on-belt/{name}.csv", rows, 5e-7)
for name, belt, load in [("run01", 0.05, 10), ("run02", 0.1, 15)]:
    rows = simulate(one_mode(6.0, 0.005, 1.0), belt, load, 2.0, 2e-3, settle=10.0)
    write(f"mass-on-belt/{name}.csv", rows, 1e-5)
for name, belt, load in [("run01", 0.04, 25), ("run02", 0.08, 40)]:
    rows = simulate(one_mode(120.0, 0.004, 0.12), belt, load, 0.1, 1e-4, settle=1.0)
    write(f"pin-on-disc/{name}.csv", rows, 5e-7)
drive = force(2.0, 2e-3, chirp(1.0, 4.0, 2.0, 40.0))
rows = simulate(one_mode(0.0, 0.0, 3.0), 0.0, 25, 2.0, 2e-3, drive)
write("sliding-drive/run01.csv", rows, 1e-5, drive)
shaker = force(2.0, 2e-3, chirp(4.0, 20.0, 2.0, 5.0))
rows = simulate(one_mode(12.0, 0.02, 1.5), 0.0, 0.0, 2.0, 2e-3, shaker)
write("oscillator/run01.csv", rows, 2e-6, shaker)
