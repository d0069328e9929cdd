"""Measurements of machines that are no beam on a belt, with hidden physics and their answers in truth.json.

    python make_machines.py --out DIR --seed S [NAME ...]

Every machine is drawn anew: its constants lie around typical ones, those that campaign.toml states are off by what it states as their
standard deviations, and the display adds white noise. Each is integrated here, apart from the model of this project: smooth motions by
SciPy's DOP853, motions with dry friction by steps of Runge and Kutta's midpoint rule that end where the velocity vanishes, the contact with
bristles by LSODA. truth.json lists the campaign, what is hidden, the effect that describes it (null where none does) and its constants.

NAME is one of
    drive      a slide with dry friction and a damper of different strength in the two directions, moved by a force that is swept
    drag       a free decay with drag in proportion to the square of the velocity
    stop       an oscillator that is swept through its resonance and touches a spring on one side there
    backlash   an oscillator under a multisine that touches springs on both sides
    absorber   an oscillator under a multisine on which a small one hangs
    joint      free decays with a cubic spring and dry friction: two effects
    shaken     an oscillator with a cubic spring on a clamp that shakes
    bristles   a mass on a belt whose contact has bristles (LuGre)
    hysteresis an oscillator under a multisine with a force that hardens in loading and yields in unloading (Bouc-Wen as in the benchmark of
               Noel and Schoukens, 2016)
"""

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

TAU = 2 * np.pi
STILL = {"belt_velocity_m_per_s": 0.0, "normal_force_n": 0.0}


class Bench:
    """Draws a machine and writes what is measured on it."""

    def __init__(self, out, seed, name):
        self.random = np.random.default_rng([seed, sum(map(ord, name))])
        self.folder = Path(out) / name
        self.name = name

    def around(self, value, share=0.2):
        """A constant within a share of a typical value."""
        return value * self.random.uniform(1 - share, 1 + share)

    def write(self, mode, noise, runs, column=None, more="", rig=""):
        """Writes runs, each its keys, times, displacements and the column's values; mode: true frequency (Hz), damping ratio, mass (kg)."""
        self.folder.mkdir(parents=True, exist_ok=True)
        f, z, m = mode
        stated = lambda value, std: float(value + std * self.random.uniform(-1, 1))
        text = f'name = "{self.name}"\n[beam]\nnatural_frequencies_hz = [{stated(f, 3e-3 * f):.6g}]\n'
        if f > 0:
            text += f"natural_frequencies_std_hz = {3e-3 * f:.3g}\n"
        text += f"damping_ratios = [{stated(z, 0.1 * z):.4g}]\n"
        if z > 0:
            text += f"damping_ratios_std = {0.1 * z:.3g}\n"
        text += f"mass_kg = {stated(m, 0.015 * m):.5g}\nmass_std_kg = {0.015 * m:.3g}\ntip_values = [1.0]\ntip_values_std = 0.001\n{more}"
        text += rig + '[channels]\ntime_column = "time_s"\ndisplacement_column = "x"\n'
        if column:
            text += f'{column} = "u"\n'
        for i, (keys, t, x, u) in enumerate(runs, 1):
            file = f"run{i:02d}.csv"
            columns = [t, x + self.random.normal(0, noise, len(t))] + ([u] if column else [])
            head = "time_s,x" + (",u" if column else "")
            np.savetxt(self.folder / file, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.10g")
            text += f'\n[[run]]\nfile = "{file}"\n' + "".join(f"{k} = {float(v)}\n" for k, v in keys.items())
        (self.folder / "campaign.toml").write_text(text)

    def multisine(self, rate, count, low, high, rms):
        """Times, values and a spline of a random-phase multisine of even amplitudes."""
        period = count / rate
        lines = np.arange(int(np.ceil(low * period)), int(high * period) + 1) / period
        phases = self.random.uniform(0, TAU, len(lines))
        at = lambda t: np.cos(TAU * np.outer(t, lines) + phases).sum(1)
        t = np.arange(count) / rate
        scale = rms / at(t).std()
        dense = np.arange(0, period + 1e-3, 1 / (16 * rate))
        return t, scale * at(t), CubicSpline(dense, scale * at(dense))


def smooth(rates, state, t):
    """A motion whose rates are continuous."""
    found = solve_ivp(rates, (t[0], t[-1]), state, t_eval=t, method="DOP853", rtol=1e-9, atol=1e-12, max_step=5e-4)
    if not found.success:
        raise ArithmeticError(found.message)
    return found.y[0]


def rubbed(force, dry, mass, state, t, step):
    """A motion with dry friction `dry` (N) under `force(t, x, v)` (N) without it, at even times t."""
    x, v = state
    rows = []
    every = round((t[1] - t[0]) / step)
    for i in range(every * len(t)):
        if i % every == 0:
            rows.append(x)
        now, left = i * step, step
        while left > 0:
            rest = force(now, x, 0.0)
            if v == 0 and abs(rest) <= dry:
                break
            sign = np.sign(v) if v else np.sign(rest)
            rate = lambda s, y, w: (force(s, y, w) - dry * sign) / mass
            middle = v + 0.5 * left * rate(now, x, v)
            after = v + left * rate(now + 0.5 * left, x + 0.5 * left * v, middle)
            if v * after >= 0:
                x, v, left = x + left * middle, after, 0.0
            else:
                part = left * v / (v - after)
                x, v, now, left = x + 0.5 * part * v, 0.0, now + part, left - part
    return np.array(rows)


def drive(b):
    m, dry, ways = b.around(3.0), b.around(8.0), (b.around(18.0), b.around(11.0))
    runs = []
    for amplitude, low in ((30, 0.8), (22, 1.3), (26, 0.5)):
        t = np.arange(5000) / 1000
        push = lambda s: amplitude * np.sin(TAU * (low * s + 0.15 * s * s))
        x = rubbed(lambda s, y, v: push(s) - (ways[0] if v > 0 else ways[1]) * v, dry, m, (0.0, 0.0), t, 1e-4)
        runs.append(({**STILL, "normal_force_n": 30.0}, t, x, push(t)))
    b.write((0.0, 0.0, m), 5e-6, runs, "external_force_column")
    return "damping that differs with the direction", ["term_asymmetric_damping"], {"c": ways[0] - ways[1]}


def drag(b):
    m, f, z, k = b.around(0.8), b.around(3.2), b.around(0.002), b.around(0.35)
    runs = []
    for x0 in (0.05, 0.03, 0.04):
        t = np.arange(4000) / 400
        x = smooth(lambda s, y: [y[1], -2 * z * TAU * f * y[1] - (TAU * f) ** 2 * y[0] - k * abs(y[1]) * y[1] / m], [x0, 0], t)
        runs.append((STILL, t, x, None))
    b.write((f, z, m), 2e-5, runs)
    return "drag", ["quadratic_drag"], {"coefficient": k}


def stop(b):
    m, f, z, gap, ratio = b.around(1.2), b.around(9.0, 0.1), b.around(0.015), b.around(4e-3), b.around(3.0)
    w = TAU * f
    runs = []
    for amplitude in (1.2, 2.5, 0.9, 2.0):
        t = np.arange(4000) / 1000
        push = lambda s: amplitude * np.sin(TAU * (0.55 * f + 0.1 * f * s) * s)
        rates = lambda s, y: [y[1], push(s) / m - 2 * z * w * y[1] - w * w * (y[0] + ratio * max(y[0] - gap, 0))]
        runs.append((STILL, t, smooth(rates, [0, 0], t), push(t)))
    b.write((f, z, m), 4e-6, runs, "external_force_column")
    return "a stop on one side", ["term_stop"], {"g": gap, "k": ratio * w * w * m}


def backlash(b):
    m, f, z, gap, ratio = b.around(2.0), b.around(15.0), b.around(0.02), b.around(2.5e-3), b.around(2.0)
    w = TAU * f
    runs = []
    for rms in (12.0, 8.0, 16.0, 10.0):
        t, u, push = b.multisine(600.0, 2400, 4, 40, rms)
        beyond = lambda x: max(x - gap, 0) + min(x + gap, 0)
        rates = lambda s, y: [y[1], push(s) / m - 2 * z * w * y[1] - w * w * (y[0] + ratio * beyond(y[0]))]
        runs.append((STILL, t, smooth(rates, [0, 0], t), u))
    b.write((f, z, m), 3e-6, runs, "external_force_column")
    return "springs beyond a gap on both sides", ["term_two_stops"], {"g": gap, "k": ratio * w * w * m}


def absorber(b):
    m, f, z = b.around(1.5), b.around(12.0, 0.1), b.around(0.01)
    share, other, damping = b.around(0.04), b.around(19.0, 0.1), b.around(0.02)
    w, wa, ma = TAU * f, TAU * other, share * m
    runs = []
    for rms in (3.0, 2.0, 4.0):
        t, u, push = b.multisine(500.0, 2000, 3, 60, rms)

        def rates(s, y):
            pull = ma * (wa * wa * (y[2] - y[0]) + 2 * damping * wa * (y[3] - y[1]))
            return [y[1], (push(s) + pull) / m - 2 * z * w * y[1] - w * w * y[0], y[3], -pull / ma]

        runs.append((STILL, t, smooth(rates, [0, 0, 0, 0], t), u))
    b.write((f, z, m), 2e-6, runs, "external_force_column")
    return "a small mass on a spring", ["term_vibration_absorber"], {"m": ma, "f": other, "D": damping}


def joint(b):
    m, f, z, cubic, dry = b.around(0.9), b.around(7.0), b.around(0.004), b.around(3e5), b.around(0.06)
    w = TAU * f
    runs = []
    for x0 in (0.012, 0.02, 0.008, 0.016):
        t = np.arange(3000) / 1000
        force = lambda s, x, v: -m * (2 * z * w * v + w * w * x) - cubic * x**3
        runs.append((STILL, t, rubbed(force, dry, m, (x0, 0.0), t, 1e-4), None))
    b.write((f, z, m), 2e-6, runs)
    return "a cubic spring and dry friction", ["cubic_stiffness", "term_dry_damping"], {"coefficient": cubic, "f": dry}


def shaken(b):
    m, f, z, bend = b.around(0.4), b.around(22.0, 0.1), b.around(0.012), b.around(1.2e4)
    w = TAU * f
    runs = []
    for amplitude in (3.0, 5.0, 2.0):
        t = np.arange(3000) / 1000
        shake = lambda s: amplitude * np.sin(TAU * (0.64 * f + 0.11 * f * s) * s)
        rates = lambda s, y: [y[1], -shake(s) - 2 * z * w * y[1] - w * w * y[0] * (1 - bend * y[0] ** 2)]
        runs.append((STILL, t, smooth(rates, [0, 0], t), shake(t)))
    b.write((f, z, m), 2e-6, runs, "clamp_acceleration_column", more="clamp_shares = [1.0]\n")
    return "a cubic spring", ["cubic_stiffness"], {"coefficient": -bend * w * w * m}


def bristles(b):
    m, f, z, stiff, damp = b.around(1.0), b.around(6.0), b.around(0.006), b.around(2.5e4), b.around(30.0)
    k, c = m * (TAU * f) ** 2, 2 * z * m * TAU * f
    runs = []
    for belt, load in ((0.02, 12.0), (0.04, 12.0), (0.03, 18.0), (0.06, 15.0), (0.025, 15.0)):
        t = np.arange(3000) / 1000

        def rates(s, y):
            slip = belt - y[1]
            level = load * (0.25 + 0.17 * np.exp(-abs(slip) / 0.05))
            bend = slip - stiff * abs(slip) / level * y[2]
            return [y[1], (stiff * y[2] + damp * bend - c * y[1] - k * y[0]) / m, bend]

        found = solve_ivp(rates, (0, t[-1] + 2), [0, 0, 0], t_eval=t + 2, method="LSODA", rtol=1e-9, atol=1e-12, max_step=2e-3)
        runs.append(({"belt_velocity_m_per_s": belt, "normal_force_n": load}, t, found.y[0], None))
    b.write((f, z, m), 1e-6, runs, rig="[rig]\nbelt_velocity_std = 0.005\nnormal_force_std = 0.02\n")
    return "bristles in the contact", ["presliding_compliance"], {"bristle_stiffness": stiff, "bristle_damping": damp}


def hysteresis(b):
    m, c, k, a = 2.0, 10.0, 5e4, 5e4
    beta, gamma, delta = 1e3, 0.8, -1.1
    runs = []
    for rms in (50.0, 30.0, 50.0, 20.0):
        t, u, push = b.multisine(750.0, 1500, 5, 150, rms)

        def rates(s, y):
            loop = a * y[1] - beta * (gamma * abs(y[1]) * y[2] + delta * y[1] * abs(y[2]))
            return [y[1], (push(s) - c * y[1] - k * y[0] - y[2]) / m, loop]

        runs.append((STILL, t, smooth(rates, [0, 0, 0], t), u))
    f = np.sqrt((k + a) / m) / TAU
    b.write((f, c / (2 * m * TAU * f), m), 2e-6, runs, "external_force_column")
    return "hysteresis of the spring", None, {}


MACHINES = [drive, drag, stop, backlash, absorber, joint, shaken, bristles, hysteresis]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("names", nargs="*", choices=[*(m.__name__ for m in MACHINES), []], metavar="NAME")
    arguments = parser.parse_args()
    truth = []
    for machine in MACHINES:
        if arguments.names and machine.__name__ not in arguments.names:
            continue
        bench = Bench(arguments.out, arguments.seed, machine.__name__)
        hidden, effects, constants = machine(bench)
        truth.append({"campaign": bench.name, "hidden": hidden, "effects": effects, "constants": constants})
    (Path(arguments.out) / "truth.json").write_text(json.dumps(truth, indent=1) + "\n")


if __name__ == "__main__":
    main()
