"""What the tests share: the demonstration's campaign, and a small one of the model itself."""

from pathlib import Path

import numpy as np
import pytest

import stickslip

REPOSITORY = Path(__file__).resolve().parents[3]
BEAM = {
    "natural_frequencies_hz": [80.0, 510.0],
    "damping_ratios": [0.00015, 0.00085],
    "mass_kg": 0.427,
}


@pytest.fixture(scope="session")
def demo() -> stickslip.Campaign:
    return stickslip.Campaign(REPOSITORY / "reference-data" / "demo")


def motion(belt_velocity, normal_force, samples, output="tip_displacement", noise_std=1e-6):
    """Times and an output of the reference model once it has settled, at 4 kHz, with noise in the
    output's unit."""
    found = stickslip.simulate(
        belt_velocity=belt_velocity,
        normal_force=normal_force,
        duration=2.0,
        step=2.5e-4,
        variables=[output],
        settings={
            "mode[1].damping_ratio": 0.00015,
            "mode[2].damping_ratio": 0.00085,
            "mode[1].mass": 0.427,
            "mode[2].mass": 0.427,
        },
    )
    noise = np.random.default_rng(round(1e6 * belt_velocity)).normal(0, noise_std, samples)
    return found.time[-samples:], found[output][-samples:] + noise


@pytest.fixture(scope="session")
def small_arrays():
    """Times, displacements, belt velocities and normal forces of two short runs of the model."""
    points = [(0.04, 36.0), (0.06, 60.0)]
    runs = [motion(v, f, samples=800) for v, f in points]
    return (
        [r[0] for r in runs],
        [r[1] for r in runs],
        [p[0] for p in points],
        [p[1] for p in points],
    )


@pytest.fixture(scope="session")
def small(small_arrays, tmp_path_factory):
    """The campaign of these runs."""
    time, displacement, belt, load = small_arrays
    folder = tmp_path_factory.mktemp("campaigns") / "small"
    return stickslip.Campaign.from_arrays(
        time, displacement, belt_velocity=belt, normal_force=load, beam=BEAM, folder=folder
    )
