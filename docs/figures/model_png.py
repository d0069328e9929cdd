"""Draws the FMU's picture (model.png and the icon): a clamped beam whose tip rests on a belt.

usage: python3 docs/figures/model_png.py    (writes harness/src/command/pack/model.png; standard library only)
"""
import math
import struct
import zlib
from pathlib import Path

SIZE, FINE = 100, 4  # pixels; subpixels each way
INK, STEEL, BELT, RED = (40, 44, 52), (90, 120, 160), (70, 70, 70), (200, 60, 40)


def colour(x, y):
    """Colour at a point in 0..100 (y downwards), or None."""
    if y < 12 and 20 < x < 80:
        return INK if (x + y) % 8 < 3 or y > 9 else None  # clamp
    sag = 0.0014 * (y - 12) ** 2
    if 12 <= y <= 68 and abs(x - (46 + sag)) < 3:
        return STEEL  # beam
    if math.hypot(x - 50.4, y - 69) < 5:
        return RED  # contact
    for centre in (20, 80):
        r = math.hypot(x - centre, y - 84)
        if r < 8:
            return INK if r < 2 else STEEL
        if 8 <= r < 11 and (x - 50) * (centre - 50) > 900:
            return BELT
    if 20 <= x <= 80 and (73 <= y <= 76 or 92 <= y <= 95):
        return BELT
    if 88 <= y <= 90 and 40 <= x <= 56 or abs(y - 89) < (62 - x) / 2 and 56 < x < 62:
        return RED  # direction of the belt
    return None


def main():
    rows = b""
    for row in range(SIZE):
        rows += b"\0"
        for column in range(SIZE):
            seen = [colour((column + (i + 0.5) / FINE) * 100 / SIZE, (row + (j + 0.5) / FINE) * 100 / SIZE)
                    for i in range(FINE) for j in range(FINE)]
            here = [c for c in seen if c]
            mean = [sum(c[k] for c in here) // len(here) for k in range(3)] if here else [0, 0, 0]
            rows += bytes([*mean, 255 * len(here) // len(seen)])

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", SIZE, SIZE, 8, 6, 0, 0, 0))
    png += chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
    target = Path(__file__).resolve().parents[2] / "harness/src/command/pack/model.png"
    target.write_bytes(png)
    print(target, len(png), "bytes")


main()
