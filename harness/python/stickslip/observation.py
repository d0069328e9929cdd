"""Friction force and friction characteristic from one measured motion."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, words
from stickslip.campaign import Beam, Campaign, Run, _beam_text, folder_of

if TYPE_CHECKING:
    import pandas


class Observation(Result):
    """What the observer says of a run; arrays have one entry for each sample."""

    PAGE = "observer.html"

    def __init__(self, returned: dict[str, Any], folder: Folder) -> None:
        super().__init__(parsed(returned), returned["text"], folder)
        self.time: NDArray[np.float64] = returned["time"]
        """s"""
        self.measured: NDArray[np.float64] = returned["measured"]
        """What was measured less its offset, m, m/s or m/s^2; NaN where missing."""
        self.force: NDArray[np.float64] = returned["force"]
        """Friction force, N."""
        self.force_std: NDArray[np.float64] = returned["force_std"]
        """Its standard deviation, N; NaN for the pole-placed observer, which knows none."""
        self.displacement: NDArray[np.float64] = returned["displacement"]
        """m"""
        self.velocity: NDArray[np.float64] = returned["velocity"]
        """m/s"""
        self.relative_velocity: NDArray[np.float64] = returned["relative_velocity"]
        """Velocity less belt velocity, m/s."""
        self.mode: NDArray[np.int8] = returned["mode"]
        """0 in stick, -1 and 1 in slip."""

    def to_pandas(self) -> pandas.DataFrame:
        """The signals, one row for each sample."""
        import pandas

        names = [
            "measured",
            "force",
            "force_std",
            "displacement",
            "velocity",
            "relative_velocity",
            "mode",
        ]
        columns = {name: getattr(self, name) for name in names}
        return pandas.DataFrame(columns, index=pandas.Index(self.time, name="time"))

    def characteristic(self) -> pandas.DataFrame:
        """Friction coefficient over relative velocity, one row for each bin."""
        import pandas

        return pandas.DataFrame(self.data["bins"])

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        keys = ["relative_velocity_m_per_s", "mu", "spread", "standard_error", "count"]
        return keys, [[b[key] for key in keys] for b in self.data["bins"]]

    def _lead(self) -> str:
        laws = self.data["laws"]
        best = f"; best friction law: {laws[0]['law']}" if laws else ""
        share = 100 * self.data["stick_fraction"]
        return f"Run {self.data['run']}, {self.data['method']}: {share:.0f} % in stick{best}"


def observe(
    run: Run | Path,
    *,
    campaign: Campaign | Path | None = None,
    beam: Beam = None,
    belt_velocity: float | None = None,
    normal_force: float | None = None,
    time_column: str | None = None,
    displacement_column: str | None = None,
    method: str | None = None,
    pole_frequency: float | None = None,
    poles: Sequence[complex] | None = None,
    estimate_frequencies: float | None = None,
    offset: float | None = None,
    friction_coefficient: float | None = None,
    output: Path | None = None,
    progress: Progress = None,
) -> Observation:
    """Estimates the friction force (N) and the friction characteristic of a run.

    A run of a campaign knows its beam and operating point; a CSV file needs `beam`, `belt_velocity`
    (m/s) and `normal_force` (N), or `campaign`. `method` is `stick-slip`, `kalman` or `pole`;
    `estimate_frequencies` the share within which natural frequencies are estimated too; `offset`
    (m, m/s of a velocity) is subtracted. A velocity and an acceleration leave the level of the force
    open: `friction_coefficient` states it, as the median coefficient in slip (1).
    """
    folder = Folder(output)
    if isinstance(run, Run):
        file: Path = run.file
        if beam is None and campaign is None:
            campaign = run.campaign
    else:
        file = run
    with tempfile.TemporaryDirectory(prefix="stickslip-") as scratch:
        if isinstance(beam, Mapping):
            known = FilePath(scratch) / "beam.toml"
            known.write_text(_beam_text(beam) or "", encoding="utf-8")
            beam = known
        line = words(
            "observe",
            [os.fspath(file)],
            campaign=None if campaign is None else folder_of(campaign),
            beam=beam,
            belt_velocity=belt_velocity,
            normal_force=normal_force,
            time_column=time_column,
            displacement_column=displacement_column,
            method=method,
            pole_frequency=pole_frequency,
            poles=None if poles is None else " ".join(map(_pole, poles)),
            estimate_frequencies=estimate_frequencies,
            offset=offset,
            friction_coefficient=friction_coefficient,
            output=folder.path,
        )
        with Told(progress) as tell:
            return Observation(_native.perform(line, tell), folder)


def _pole(pole: complex) -> str:
    """-400+700i"""
    pole = complex(pole)
    return repr(pole.real) if pole.imag == 0 else f"{pole.real!r}{pole.imag:+}i"
