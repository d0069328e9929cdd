"""A campaign as its folder states it, with what the peers share: nominal model, blocks of time, nothing of truth.json.

Every second block of 50 ms is kept out of the fits; forecasts start in those alone, from 0.15 s on. The search by BIC, which fits one
window of each run, ends it before.
"""

import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

GENERATOR = Path(__file__).resolve().parents[3] / "reference-data" / "computed" / "generator"
sys.path.insert(0, str(GENERATOR))
from simulate import Rig  # noqa: E402

BLOCK = 0.05  # s
FIRST_FORECAST = 0.15  # s; before it lies the window of bic.py


@dataclass
class Run:
    """One record: times (s), measured displacement (m), belt velocity (m/s), normal force (N)."""

    t: np.ndarray
    w: np.ndarray
    belt: float
    normal: float

    @property
    def dt(self):
        return (self.t[-1] - self.t[0]) / (self.t.size - 1)

    def kept_out(self):
        """True for samples of the blocks that no fit may see."""
        return np.floor((self.t - self.t[0]) / BLOCK).astype(int) % 2 == 1


def load(folder):
    """(nominal Rig, runs). The friction law is the rig's default: the start values that the project's FMU has too."""
    data = tomllib.loads((Path(folder) / "campaign.toml").read_text())
    beam = data["beam"]
    rig = Rig(list(beam["natural_frequencies_hz"]), list(beam["damping_ratios"]), beam["mass_kg"])
    runs = []
    for entry in data["run"]:
        t, w = np.loadtxt(Path(folder) / entry["file"], delimiter=",", skiprows=1, unpack=True)
        runs.append(Run(t, w, entry["belt_velocity_m_per_s"], entry["normal_force_n"]))
    return rig, runs
