"""friction_law.svg: eq. (7) of Stelter 1992 as printed and as read. Standard library only: python3 docs/figures/friction_law.py"""

from math import exp
from pathlib import Path

MU0, A1, A2, V1, C2 = 0.66, 0.5, 0.5, 0.02, 0.25  # the paper: c1 = -V1 m/s


def slow(v):
    return 1 - A2 + A2 * exp(-C2 * v)


def as_read(v):
    return MU0 * (1 - A1 + A1 * exp(-v / V1)) * slow(v)


def as_printed(v):
    return MU0 * (1 - A1 + (A1 * exp(-V1 / v) if v > 0 else 0.0)) * slow(v)


WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 400, 70, 20, 46, 56
V_MAX, MU_MAX = 0.5, 0.7
PAPER, INK, GRID, BLUE, ORANGE = "#ffffff", "#222222", "#dddddd", "#0072b2", "#d55e00"


def x(v):
    return LEFT + (WIDTH - LEFT - RIGHT) * v / V_MAX


def y(mu):
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * mu / MU_MAX


def curve(law, colour, dash=""):
    points = [V_MAX * (i / 600) ** 2 for i in range(601)]
    path = " ".join(f"{x(v):.1f},{y(law(v)):.1f}" for v in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2.5" stroke-dasharray="{dash}"/>'


def text(at_x, at_y, words, anchor="start", colour=INK, extra=""):
    return f'<text x="{at_x:.1f}" y="{at_y:.1f}" text-anchor="{anchor}" fill="{colour}" {extra}>{words}</text>'


def main():
    peak = max((V_MAX * i / 50000 for i in range(1, 50001)), key=as_printed)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="14">',
           "<title>Friction coefficient over relative velocity: eq. (7) as printed and as read</title>",
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="{PAPER}"/>']
    for i in range(6):
        v = 0.1 * i
        out += [f'<line x1="{x(v):.1f}" x2="{x(v):.1f}" y1="{y(0):.1f}" y2="{y(MU_MAX):.1f}" stroke="{GRID}"/>',
                text(x(v), y(0) + 20, f"{v:.1f}", "middle")]
    for i in range(8):
        mu = 0.1 * i
        out += [f'<line x1="{x(0):.1f}" x2="{x(V_MAX):.1f}" y1="{y(mu):.1f}" y2="{y(mu):.1f}" stroke="{GRID}"/>',
                text(x(0) - 8, y(mu) + 5, f"{mu:.1f}", "end")]
    out += [curve(as_read, BLUE), curve(as_printed, ORANGE, "8 5"),
            f'<circle cx="{x(peak):.1f}" cy="{y(as_printed(peak)):.1f}" r="4" fill="{ORANGE}"/>',
            text(LEFT, 26, "Friction coefficient \u03bc(v), eq. (7): the same five numbers, read in two ways", extra='font-weight="bold"'),
            text(x(0.06), y(0.42), "as read, exp(|v|/c\u2081): starts at \u03bc\u2080 = 0.66 and falls: self-sustained vibration", colour=BLUE),
            text(x(0.06), y(0.655), f"as printed, exp(c\u2081/|v|): starts at {as_printed(1e-9):.2f}, rises up to {peak:.2f} m/s: every motion dies out", colour=ORANGE),
            text((x(0) + x(V_MAX)) / 2, HEIGHT - 12, "relative velocity |v| in m/s", "middle"),
            text(18, (y(0) + y(MU_MAX)) / 2, "\u03bc", "middle"), "</svg>"]
    Path(__file__).with_name("friction_law.svg").write_text("\n".join(out) + "\n")
    for v in (0.0, 0.01, 0.05, 0.1, 0.2, 0.5):
        print(f"{v:5.2f} m/s  as read {as_read(v):.4f}  as printed {as_printed(v):.4f}")
    print(f"as printed: highest {as_printed(peak):.4f} at {peak:.3f} m/s")


main()
