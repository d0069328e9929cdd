"""A parameter study in this project, in heyoka (one point at a time and in its batch mode) and in a Numba loop of
Runge-Kutta steps: the same points of Figure 6, the same cycles, the same section points, equal accuracy.

    python3 benches/peers/sweep.py

Everything runs on one core each; times are processor times (the least of several rounds, in which all take turns), so
that other work on the machine counts as little as it can. Compilation is not counted. On first use it installs its
peers into target/sweep-venv.

The truth is heyoka in long double at tolerance 1e-18. The error of a run is the largest one of its section points (peaks
w' = 0), in time as a share of the mean time between peaks, in displacement as a share of the highest peak; the first
peaks, which this project does not report, are left out. Of the motions' errors the median counts: the worst point
depends on luck.
"""

import os
import subprocess
import sys
from pathlib import Path
from time import process_time

ROOT = Path(__file__).resolve().parents[2]
try:
    import numpy as np
    import sweep_heyoka
    import sweep_numba
except ImportError:
    folder = ROOT / "target" / "sweep-venv"
    if Path(sys.prefix) == folder:
        raise
    python = folder / "bin" / "python"
    subprocess.check_call([sys.executable, "-m", "venv", folder])
    requirements = ROOT / "benches" / "peers" / "requirements.txt"
    subprocess.check_call([python, "-m", "pip", "install", "--quiet", "-r", requirements])
    os.execv(python, [python, *sys.argv])

SETTLE, CYCLES = 10, 190
ROUNDS = 24
# Motions of period one: others would not agree in their last section points, whoever computes them.
VELOCITIES = np.linspace(0.096, 0.0969, 16)
# The Numba loop takes so long that these have to do.
FEW = slice(None, None, 8)
# What this project's sweeps use where nothing else is asked for.
TOLERANCE = 1e-10
# Agreement that is asked for between all runs that are compared.
SAME = 1e-7


class Ours:
    """This project, in its own process; tells its processor time itself."""

    def __init__(self):
        command = ["cargo", "bench", "--quiet", "-p", "beam-physics", "--bench", "sweep", "--", "peer"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=ROOT, stdin=pipe, stdout=pipe, text=True)

    def run(self, tolerance, settle=SETTLE, cycles=CYCLES):
        """Seconds, periods and peaks (time, displacement) of all points."""
        print(tolerance, settle, cycles, *VELOCITIES, file=self.process.stdin, flush=True)
        seconds = float(self.process.stdout.readline())
        lines = [self.process.stdout.readline().split() for _ in VELOCITIES]
        periods = [int(line[0]) for line in lines]
        return seconds, periods, [np.array(line[1:], dtype=float).reshape(-1, 2) for line in lines]


def timed(peer, velocities, ends):
    begun = process_time()
    peaks = peer.run(velocities, ends)
    return process_time() - begun, peaks


def errors(found, truth):
    """The largest error of each point; see above."""
    out = []
    for peaks, true in zip(found, truth):
        if len(peaks) < CYCLES or len(true) != SETTLE + CYCLES:
            return [np.inf]
        true = true[-CYCLES:]
        scale = np.array([(true[-1, 0] - true[0, 0]) / (CYCLES - 1), true[:, 1].max()])
        out.append(float(np.max(np.abs(peaks[-CYCLES:] - true) / scale)))
    return out


def equal(make, settings, truth, velocities, ends, goal):
    """The first, hence quickest, of the settings that is as good as the goal."""
    for setting in settings:
        found = errors(make(setting).run(velocities, ends), truth)
        print(f"    {setting:g}: error {np.median(found):.1e}, at worst {np.max(found):.1e}", flush=True)
        if np.median(found) <= goal:
            return setting
    sys.exit("no setting of the peer is as good as this project")


def main():
    ours = Ours()
    _, periods, _ = ours.run(TOLERANCE, 1000, 200)
    if set(periods) != {1}:
        sys.exit(f"not all motions have period one: {periods}")
    _, _, mine = ours.run(TOLERANCE)
    # All stop shortly after the last peak that is counted.
    ends = np.array([peaks[-1, 0] + 1e-3 for peaks in mine])
    truth = sweep_heyoka.Scalar(1e-18, np.longdouble).run(VELOCITIES, ends)
    truth = [peaks.astype(float) for peaks in truth]
    goal = np.median(errors(mine, truth))
    print(f"{len(VELOCITIES)} points, {SETTLE + CYCLES} cycles; this project at {TOLERANCE:g}: error {goal:.1e}")
    print("heyoka, by tolerance")
    tolerances = [1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14]
    tolerance = equal(sweep_heyoka.Scalar, tolerances, truth, VELOCITIES, ends, goal)
    print("Numba, by step in s")
    few = VELOCITIES[FEW], ends[FEW]
    steps = [2e-6, 1e-6, 5e-7, 2.5e-7]
    step = equal(sweep_numba.Loop, steps, truth[FEW], *few, goal)

    peers = {f"heyoka, one at a time, {tolerance:g}": (sweep_heyoka.Scalar(tolerance), VELOCITIES, ends)}
    for lanes, wide in [(4, False), (8, False), (8, True), (16, True)]:
        name = f"heyoka, batch of {lanes}{', AVX-512' if wide else ''}, {tolerance:g}"
        peers[name] = (sweep_heyoka.Batch(tolerance, lanes, wide), VELOCITIES, ends)
    peers[f"Numba, RK4, {step:g} s"] = (sweep_numba.Loop(step), *few)

    best, results = {}, {}
    for _ in range(ROUNDS):
        seconds, _, results["this project"] = ours.run(TOLERANCE)
        best["this project"] = min(best.get("this project", np.inf), seconds / len(VELOCITIES))
        for name, (peer, velocities, until) in peers.items():
            seconds, results[name] = timed(peer, velocities, until)
            best[name] = min(best.get(name, np.inf), seconds / len(velocities))
    cycles = SETTLE + CYCLES
    print(f"\nprocessor time, least of {ROUNDS} rounds, one core")
    print(f"{'':<36} {'us/cycle':>9} {'cycles/s':>9} {'this project':>13}  {'error':>8} {'at worst':>8}")
    for name, seconds in best.items():
        true = truth[FEW] if name.startswith("Numba") else truth
        found = errors(results[name], true)
        if np.max(found) > SAME:
            sys.exit(f"{name} finds other section points: {np.max(found):.1e}")
        print(
            f"{name:<36} {1e6 * seconds / cycles:9.1f} {cycles / seconds:9.0f} "
            f"{seconds / best['this project']:12.2f}x  {np.median(found):8.1e} {np.max(found):8.1e}"
        )
    quickest = min(seconds for name, seconds in best.items() if name.startswith("heyoka"))
    print(f"this project against heyoka's best: {quickest / best['this project']:.2f} times the cycles per second and core")


main()
