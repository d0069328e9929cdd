"""The integrations of make_machines.py beside closed solutions."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from make_machines import TAU, rubbed, smooth


def test_dry_friction_stops_a_slide():
    # From v, friction F stops a mass m after m v^2/(2 F).
    t = np.arange(1000) / 1000
    x = rubbed(lambda s, x, v: 0.0, 8.0, 3.0, (0.0, 1.2), t, 1e-4)
    assert abs(x[-1] - 3.0 * 1.2**2 / (2 * 8.0)) < 1e-9


def test_dry_friction_takes_four_deflections_from_each_cycle():
    # Coulomb damping: the amplitude of a free swing falls by 4 F/k in each period, until the spring no longer overcomes friction.
    m, f, dry = 0.9, 7.0, 0.06
    k = m * (TAU * f) ** 2
    t = np.arange(1001) / 7000
    x = rubbed(lambda s, x, v: -k * x, dry, m, (0.012, 0.0), t, 1 / 7000 / 10)
    assert abs(x[-1] - (0.012 - 4 * dry / k)) < 2e-8
    t = np.arange(21000) / 7000
    x = rubbed(lambda s, x, v: -k * x, dry, m, (5e-4, 0.0), t, 1 / 7000)
    assert np.ptp(x[-100:]) == 0 and abs(x[-1]) <= dry / k


def test_a_smooth_motion_is_that_of_a_damped_oscillator():
    w, z = TAU * 9.0, 0.015
    t = np.arange(2000) / 1000
    x = smooth(lambda s, y: [y[1], -2 * z * w * y[1] - w * w * y[0]], [1e-3, 0.0], t)
    wd = w * np.sqrt(1 - z * z)
    exact = 1e-3 * np.exp(-z * w * t) * (np.cos(wd * t) + z * w / wd * np.sin(wd * t))
    assert np.abs(x - exact).max() < 1e-10


def test_a_machine_is_the_same_whatever_else_is_made(tmp_path):
    make = Path(__file__).with_name("make_machines.py")
    for folder, names in (("a", ["drag"]), ("b", ["shaken", "drag"])):
        subprocess.run([sys.executable, make, "--out", tmp_path / folder, "--seed", "3", *names], check=True)
    a, b = ((tmp_path / f / "drag" / "run01.csv").read_text() for f in "ab")
    assert a == b
    truth = json.loads((tmp_path / "b" / "truth.json").read_text())
    assert [t["campaign"] for t in truth] == ["drag", "shaken"]
