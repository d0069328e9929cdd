"""one_effect.svg: the rig, and the motion with and without one missing effect.

Standard library only. Runs the command:  python3 docs/figures/one_effect.py [path of stickslip]
"""

import csv
import io
import subprocess
import sys
from pathlib import Path

STICKSLIP = sys.argv[1] if len(sys.argv) > 1 else str(Path(__file__).parents[2] / "target/release/stickslip")
BELT, FORCE, FROM, TO = 0.1, 100, 1.0, 1.3
EFFECT = ["--set", "belt_periodic_friction.amplitude=0.08", "--set", "belt_periodic_friction.wavelength=0.02"]
INK, GRAY, GRID, BLUE, ORANGE = "#222222", "#777777", "#dddddd", "#0072b2", "#d55e00"


def motion(settings):
    names = "tip_displacement,tip_velocity,contact_mode"
    command = [STICKSLIP, "simulate", "--belt-velocity", str(BELT), "--normal-force", str(FORCE), "--duration", str(TO),
               "--step", "2e-4", "--variables", names, *settings]
    rows = csv.DictReader(io.StringIO(subprocess.run(command, check=True, capture_output=True, text=True).stdout))
    rows = [{k: float(v) for k, v in row.items()} for row in rows]
    return [r for r in rows if r["time"] >= FROM]


def text(x, y, words, colour=INK, anchor="start", size=14, extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}" {extra}>{words}</text>'


def line(x1, y1, x2, y2, colour=INK, width=1.5, extra=""):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" stroke-width="{width}" {extra}/>'


def rig(left, top):
    """Cantilever from the ceiling, tip on the belt."""
    x, y = left + 95, top + 30
    out = [line(x - 50, y, x + 50, y, width=2)]
    out += [line(x - 50 + 10 * i, y, x - 42 + 10 * i, y - 10, GRAY) for i in range(11)]
    out.append(f'<path d="M{x} {y} C{x} {y + 70} {x + 4} {y + 110} {x + 26} {y + 165}" fill="none" stroke="{INK}" stroke-width="6"/>')
    out.append(f'<path d="M{x} {y} V{y + 165}" stroke="{GRAY}" stroke-dasharray="4 4" fill="none"/>')
    tip = x + 26
    belt = y + 172
    out += [f'<rect x="{x - 90}" y="{belt}" width="180" height="44" rx="22" fill="none" stroke="{INK}" stroke-width="3"/>',
            f'<circle cx="{x - 68}" cy="{belt + 22}" r="14" fill="none" stroke="{GRAY}"/>',
            f'<circle cx="{x + 68}" cy="{belt + 22}" r="14" fill="none" stroke="{GRAY}"/>']
    out += [line(x - 25, belt + 22, x + 25, belt + 22), f'<path d="M{x + 33} {belt + 22} l-11 -5 v10 z" fill="{INK}"/>', text(x - 32, belt + 27, "v\u2080", anchor="end")]
    out += [line(tip + 50, belt - 40, tip + 16, belt - 8, BLUE), f'<path d="M{tip + 10} {belt - 3} l12 -4 l-6 -7 z" fill="{BLUE}"/>', text(tip + 42, belt - 44, "F<tspan baseline-shift='sub' font-size='10'>N</tspan>", BLUE)]
    out.append(text(x + 4, y + 115, "w", GRAY, "end"))
    return out


def plot(rows, top, colour, title, label_x):
    left, right, height = 275, 880, 105
    w = [1e3 * r["tip_displacement"] for r in rows]
    low, high = LOW, HIGH
    x = lambda t: left + (right - left) * (t - FROM) / (TO - FROM)
    y = lambda v: top + height - height * (v - low) / (high - low)
    out = []
    stuck = None
    for r in rows + [{"time": TO, "contact_mode": 9}]:
        if r["contact_mode"] == 0 and stuck is None:
            stuck = r["time"]
        elif r["contact_mode"] != 0 and stuck is not None:
            width = x(r["time"]) - x(stuck)
            out.append(f'<rect x="{x(stuck):.1f}" y="{top}" width="{width:.1f}" height="{height}" fill="{colour}" opacity="0.12"/>')
            stuck = None
    out += [line(left, y(v), right, y(v), GRID, 1) + text(left - 8, y(v) + 4, f"{v:g}", anchor="end", size=12) for v in TICKS]
    points = " ".join(f"{x(r['time']):.1f},{y(v):.1f}" for r, v in zip(rows, w))
    out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.8"/>')
    out.append(text(left, top - 8, title, colour))
    if label_x:
        out += [text(x(FROM + 0.05 * i), top + height + 18, f"{FROM + 0.05 * i:.2f}", anchor="middle", size=12) for i in range(7)]
        out.append(text((left + right) / 2, top + height + 38, "time in s; shaded: the tip sticks to the belt", anchor="middle", size=12))
    return out


reference, changed = motion([]), motion(EFFECT)
every = [1e3 * r["tip_displacement"] for r in reference + changed]
LOW, HIGH = min(every) - 0.1, max(every) + 0.1
TICKS = [v for v in range(-9, 10) if LOW <= v <= HIGH]
out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 350" font-family="sans-serif">',
       "<title>Beam on a belt; tip displacement with and without friction varying along the belt</title>",
       '<rect width="900" height="350" fill="#ffffff"/>']
out += rig(20, 25)
out.append(text(115, 318, f"v\u2080 = {BELT} m/s, F<tspan baseline-shift='sub' font-size='9'>N</tspan> = {FORCE} N", anchor="middle", size=12))
out.append(f'<text transform="translate(228 165) rotate(-90)" text-anchor="middle" font-size="12" fill="{INK}">tip displacement w in mm</text>')
out += plot(reference, 35, BLUE, "reference model", False)
out += plot(changed, 185, ORANGE, "the same with one effect more: friction varies by 8 % along the belt, wavelength 20 mm", True)
out.append("</svg>")
Path(__file__).with_name("one_effect.svg").write_text("\n".join(out) + "\n")
