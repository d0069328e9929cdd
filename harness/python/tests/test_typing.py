"""The package is typed: mypy accepts it, and a use of it, strictly."""

import subprocess
import sys

USE = """
import numpy as np
import stickslip

samples = np.arange(3.0), np.zeros(3)
campaign = stickslip.Campaign.from_arrays(*samples, belt_velocity=0.1, normal_force=1.0)
found = stickslip.compare(campaign)
error: float = found.worst.nrmse
study = stickslip.sweep("belt_velocity", values=[0.1], settings={"normal_force": 10.0})
wrong: str = stickslip.simulate(duration=1.0).time
"""


def test_the_package_and_its_use_are_typed(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "-p", "stickslip"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "use.py"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    errors = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert len(errors) == 1 and errors[0].startswith("use.py:10:"), done.stdout
