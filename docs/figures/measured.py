"""measured.svg: how far each step of the error ladder brings the model to data that nobody here made.

Standard library only:  python3 docs/figures/measured.py TITLE=FOLDER ... , where FOLDER has the diagnosis.json
of `stickslip diagnose`. The values that the committed picture shows are in docs/measured.md.
"""

import json
import math
import sys
from pathlib import Path

INK, GRAY, GRID, BLUE, ORANGE = "#222222", "#777777", "#dddddd", "#0072b2", "#d55e00"
LEFT, TOP, ROW, WIDTH, GAP = 290, 58, 30, 430, 34
FROM, TO = 0.1, 100.0


def place(percent):
    return LEFT + WIDTH * math.log(max(percent, FROM) / FROM) / math.log(TO / FROM)


def text(x, y, words, colour=INK, anchor="start", size=14, weight="normal"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}" '
            f'font-weight="{weight}">{words}</text>')


def ladder(folder):
    steps = json.loads((Path(folder) / "diagnosis.json").read_text())["error_ladder"]
    noise = [s["holdout_nrmse"] / s["holdout_over_noise"] for s in steps if s["holdout_over_noise"]]
    return [(s["step"], 100 * s["holdout_nrmse"]) for s in steps], 100 * min(noise)


def main():
    body, y = [], TOP
    for title, folder in (argument.split("=", 1) for argument in sys.argv[1:]):
        steps, noise = ladder(folder)
        body.append(text(16, y + 14, title, weight="bold"))
        y += 24
        begin = y
        for name, error in steps:
            colour = ORANGE if name.startswith("+") else BLUE
            body.append(text(LEFT - 10, y + 19, name, anchor="end", size=13))
            body.append(f'<rect x="{LEFT}" y="{y + 4}" width="{place(error) - LEFT:.1f}" height="{ROW - 8}" fill="{colour}"/>')
            body.append(text(place(error) + 6, y + 19, f"{error:.2f} %", size=13))
            y += ROW
        if noise > FROM:
            body.append(f'<line x1="{place(noise):.1f}" y1="{begin}" x2="{place(noise):.1f}" y2="{y}" stroke="{INK}" '
                        'stroke-width="1.5" stroke-dasharray="5 3"/>')
        y += GAP - 24
    grid = []
    for tick in (0.1, 1, 10, 100):
        x = place(tick)
        grid.append(f'<line x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{y}" stroke="{GRID}"/>')
        grid.append(text(x, y + 18, f"{tick:g}", GRAY, "middle", 13))
    grid.append(text(LEFT + WIDTH / 2, y + 40, "error of prediction on what was kept out, % of the motion's standard deviation",
                     GRAY, "middle", 13))
    legend = []
    for x, colour, words in ((LEFT, BLUE, "known model"), (LEFT + 130, ORANGE, "with the effects found")):
        legend.append(f'<rect x="{x}" y="22" width="14" height="14" fill="{colour}"/>{text(x + 20, 34, words, size=13)}')
    x = LEFT + 310
    legend.append(f'<line x1="{x}" y1="29" x2="{x + 22}" y2="29" stroke="{INK}" stroke-width="1.5" stroke-dasharray="5 3"/>'
                  + text(x + 28, 34, "sensor noise", size=13))
    svg = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 {y + 54}" font-family="sans-serif">'
           f'<rect width="100%" height="100%" fill="white"/>{"".join(grid + body + legend)}</svg>\n')
    Path(__file__).with_suffix(".svg").write_text(svg)


main()
