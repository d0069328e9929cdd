"""An FMU against a measured campaign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, fmu_or_own, words
from stickslip.campaign import Campaign, Quantity, folder_of, suffix


@dataclass(frozen=True)
class RunComparison:
    """Model and measurement of one run. Curves share `time`; the model is aligned with the
    measurement."""

    name: str
    belt_velocity: float
    """m/s"""
    normal_force: float
    """N"""
    nrmse: float
    """Error of the model over the spread of the measurement, 1."""
    noise_floor: float
    """The same of a perfect model, 1."""
    measured_metrics: dict[str, Any]
    model_metrics: dict[str, Any]
    remarks: list[str]
    time: NDArray[np.float64]
    """s"""
    quantity: Quantity
    """What the sensor at the tip measured."""
    unit: str
    """Its SI unit."""
    measured: NDArray[np.float64]
    """In that unit."""
    model: NDArray[np.float64]
    """The same quantity."""
    residual: NDArray[np.float64]
    """Measured minus model."""
    sticks: NDArray[np.bool_] | None = None
    """Whether the tip moves with the belt, as measured; `None` where the sensor looks elsewhere."""
    model_velocity: NDArray[np.float64] | None = None
    """m/s, where a displacement was measured; NaN where two motions of the model meet."""
    model_displacement: NDArray[np.float64] | None = None
    """m, where something else was measured."""


class Comparison(Result):
    """An FMU at every operating point of a campaign."""

    def __init__(self, returned: dict[str, Any], folder: Folder) -> None:
        super().__init__(parsed(returned), returned["text"], folder)
        entries = zip(self.data["runs"], returned["curves"])
        self.runs = [_run(entry, curves) for entry, curves in entries]
        """The runs, worst first."""

    def __getitem__(self, name: str) -> RunComparison:
        for run in self.runs:
            if run.name == name:
                return run
        raise KeyError(name)

    @property
    def worst(self) -> RunComparison:
        """The run with the largest error."""
        return self.runs[0]

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        pairs = [
            ("period_s", "period"),
            ("amplitude_" + suffix(self.worst.unit), "amplitude"),
            ("stick_share", "stick_fraction"),
        ]
        header = ["run", "belt_velocity_m_per_s", "normal_force_n", "nrmse", "noise_floor"]
        header += [f"{side}_{name}" for name, _ in pairs for side in ("model", "measured")]
        rows: list[Sequence[Any]] = []
        for r in self.runs:
            row = [r.name, r.belt_velocity, r.normal_force, r.nrmse, r.noise_floor]
            for _, key in pairs:
                row += [r.model_metrics.get(key), r.measured_metrics.get(key)]
            rows.append(row)
        return header, rows

    def _lead(self) -> str:
        data, worst = self.data, self.worst
        return (
            f"{data['fmu']} against campaign '{data['campaign']}', {len(self.runs)} runs, "
            f"worst first: NRMSE {worst.nrmse:.3g} in {worst.name}"
        )


def compare(
    campaign: Campaign | Path,
    *,
    fmu: Path | None = None,
    output: Path | None = None,
    settings: Mapping[str, float] | None = None,
    fail_above: float | None = None,
    force: bool = False,
    progress: Progress = None,
) -> Comparison:
    """Runs an FMU [default: the package's own] at every operating point of a campaign and compares.

    `settings` are start values by variable name, in the variable's unit. An NRMSE above
    `fail_above` raises `GateFailed`. `force` begins even where `check` finds values that can't be
    meant. Files go into `output` [default: a temporary folder].
    """
    folder = Folder(output)
    line = words(
        "compare",
        [folder_of(campaign)],
        fmu=fmu_or_own(fmu),
        output=folder.path,
        set=dict(settings or {}),
        fail_above=fail_above,
        force=force,
    )
    with Told(progress) as tell:
        return Comparison(_native.perform(line, tell), folder)


def _run(entry: dict[str, Any], curves: dict[str, Any]) -> RunComparison:
    return RunComparison(
        name=entry["name"],
        belt_velocity=entry["belt_velocity_m_per_s"],
        normal_force=entry["normal_force_n"],
        nrmse=float("nan") if entry["nrmse"] is None else entry["nrmse"],
        noise_floor=entry["noise_floor"],
        measured_metrics=entry["measured"],
        model_metrics=entry["model"],
        remarks=entry["remarks"],
        **curves,
    )
