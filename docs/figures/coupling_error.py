"""coupling_error.svg: how the error of the coupled system falls with the communication step, and the table of docs/system.md.

Runs the command, and the masters of tests/val_system.rs in the environment that the test installs:
    python3 docs/figures/coupling_error.py [path of stickslip] [path of the environment's python]
"""

import csv
import io
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
STICKSLIP = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/stickslip")
PYTHON = sys.argv[2] if len(sys.argv) > 2 else str(ROOT / "target/peers-venv/bin/python")
STEPS = [1e-4, 5e-5, 2.5e-5, 1.25e-5, 6.25e-6]
STOP, EVERY = 0.05, 1e-3
BRISTLE = {"presliding_compliance.bristle_stiffness": 5e5, "presliding_compliance.bristle_damping": 60.0}
RIGID = {name: 0.0 for name in BRISTLE}
DRIVE = {"mass": 1.5, "stiffness": 2e4, "damping": 50.0}
INK, GRAY, GRID = "#222222", "#777777", "#dddddd"
# Label, colour, contact, masters whose errors must agree.
LINES = [
    ("rigid contact, inputs held", "#d55e00", RIGID, ["fmpy"]),
    ("inputs held: FMPy, libcosim, ecos (order 1)", "#0072b2", BRISTLE, ["fmpy", "libcosim", "ecos"]),
    ("with input derivatives: FMPy (order 2)", "#009e73", BRISTLE, ["fmpy, input derivatives"]),
]


def monolithic(contact):
    settings = {**contact, **{f"belt_drive_compliance.{name}": value for name, value in DRIVE.items()}}
    command = [STICKSLIP, "simulate", "--belt-velocity", "0.1", "--normal-force", "60", "--duration", str(STOP), "--step",
               str(EVERY), "--variables", "tip_displacement"]
    for name, value in settings.items():
        command += ["--set", f"{name}={value}"]
    rows = list(csv.DictReader(io.StringIO(subprocess.run(command, check=True, capture_output=True, text=True).stdout)))
    return [float(row["tip_displacement"]) for row in rows[1:]]


def coupled():
    jobs = [{"master": master, "step": step, "stop": STOP, "every": EVERY, "starts": {"beam": contact}}
            for _, _, contact, masters in LINES for master in masters for step in STEPS]
    with tempfile.TemporaryDirectory() as folder:
        files = [str(Path(folder) / name) for name in ("belt_drive.ssp", "jobs.json", "results.json")]
        subprocess.run([STICKSLIP, "system", "-o", files[0]], check=True)
        Path(files[1]).write_text(json.dumps(jobs))
        libraries = {**os.environ, "LD_LIBRARY_PATH": str(Path(PYTHON).parents[1] / "lib")}
        subprocess.run([PYTHON, str(ROOT / "tests/peers/run_system.py"), *files], check=True, env=libraries,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return iter(json.loads(Path(files[2]).read_text()))


def error(there, here):
    return math.sqrt(sum((a - b) ** 2 for a, b in zip(there, here, strict=True)) / sum(b * b for b in here))


def text(x, y, words, colour=INK, anchor="start", size=13):
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}">{words}</text>'


results = coupled()
errors = []
for label, _, contact, masters in LINES:
    here = monolithic(contact)
    each = [[error(next(results)["tip_displacement"], here) for _ in STEPS] for _ in masters]
    for other in each[1:]:
        assert all(abs(a / b - 1) < 1e-6 for a, b in zip(other, each[0])), (masters, each)
    errors.append(each[0])
    orders = [math.log2(a / b) for a, b in zip(each[0], each[0][1:])]
    print(f"{label}: errors {[f'{e:.2e}' for e in each[0]]}, orders {[f'{o:.2f}' for o in orders]}")

LEFT, RIGHT, TOP, BOTTOM = 80, 560, 20, 330
X = lambda h: LEFT + (RIGHT - LEFT) * (math.log10(h) - math.log10(4e-6)) / (math.log10(1.5e-4) - math.log10(4e-6))
Y = lambda e: TOP + (BOTTOM - TOP) * (0 - math.log10(e)) / 6
out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 390" font-family="sans-serif">',
       "<title>Error of the coupled system over the communication step</title>", '<rect width="900" height="390" fill="#ffffff"/>']
for power in range(-6, 1):
    y = Y(10.0**power)
    out.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{RIGHT}" y2="{y:.1f}" stroke="{GRID}"/>')
    out.append(text(LEFT - 8, y + 4, f'10<tspan baseline-shift="super" font-size="9">{power}</tspan>', anchor="end", size=12))
for h in (1e-5, 1e-4):
    out.append(f'<line x1="{X(h):.1f}" y1="{TOP}" x2="{X(h):.1f}" y2="{BOTTOM}" stroke="{GRID}"/>')
out += [text(X(h), BOTTOM + 18, f"{h * 1e6:g}", anchor="middle", size=12) for h in STEPS]
out.append(text((LEFT + RIGHT) / 2, BOTTOM + 40, "communication step H in \u00b5s", anchor="middle", size=12))
out.append(f'<text transform="translate(22 {(TOP + BOTTOM) / 2:.0f}) rotate(-90)" text-anchor="middle" font-size="12" fill="{INK}">error of the tip displacement, relative</text>')
for (label, colour, _, _), values in zip(LINES, errors):
    order = 0 if "rigid" in label else 2 if "derivatives" in label else 1
    if order:
        ends = [(h, values[-1] * (h / STEPS[-1]) ** order) for h in (STEPS[-1], STEPS[0])]
        (h1, e1), (h2, e2) = ends
        out.append(f'<line x1="{X(h1):.1f}" y1="{Y(e1):.1f}" x2="{X(h2):.1f}" y2="{Y(e2):.1f}" stroke="{GRAY}" stroke-dasharray="4 4"/>')
    points = " ".join(f"{X(h):.1f},{Y(e):.1f}" for h, e in zip(STEPS, values))
    out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>')
    out += [f'<circle cx="{X(h):.1f}" cy="{Y(e):.1f}" r="4" fill="{colour}"/>' for h, e in zip(STEPS, values)]
    out.append(text(RIGHT + 12, Y(values[0]) + 4, label, colour))
out.append(text(RIGHT + 12, BOTTOM, "dashed: slopes 1 and 2", GRAY, size=12))
out.append("</svg>")
Path(__file__).with_name("coupling_error.svg").write_text("\n".join(out) + "\n")
