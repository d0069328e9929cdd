"""Motions over one parameter or two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, fmu_or_own, words

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Study(Result):
    """A finished study."""

    PAGE = "sweep.html"

    def __init__(self, returned: dict[str, Any], folder: Folder) -> None:
        super().__init__(parsed(returned), returned["text"], folder)
        self.section: list[NDArray[np.float64]] = returned["section"]
        """Displacements (m) at the section points, row by row of the table."""

    @property
    def coexisting(self) -> list[dict[str, Any]]:
        """Motions that coexist at a point, with their shares of the starts."""
        found: list[dict[str, Any]] = self.data["coexisting"]
        return found

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        rows = self.data["rows"]
        names = list(rows[0]["at"]) if rows else []
        keys = [
            "start",
            "period",
            "main_frequency_hz",
            "amplitude_m",
            "stick_fraction",
            "lyapunov_per_s",
            "status",
        ]
        table: list[Sequence[Any]] = [
            [*r["at"].values(), *(_number(r[key]) for key in keys)] for r in rows
        ]
        return names + keys, table

    def _lead(self) -> str:
        rows = self.data["rows"]
        return f"{len(rows)} motions over {', '.join(rows[0]['at'])}"


class StudyOptions(TypedDict, total=False):
    """What a study does besides the parameter that is varied."""

    from_: float | None
    """Lowest value, in the variable's unit."""
    to: float | None
    points: int | None
    values: Sequence[float] | None
    """The values, in place of a range."""
    second_parameter: str | None
    second_from: float | None
    second_to: float | None
    second_points: int | None
    second_values: Sequence[float] | None
    settings: Mapping[str, float] | None
    """Other start values by variable name, in the variable's unit."""
    start: str | Sequence[str] | None
    """`fixed`, `up`, `down` or `grid`, or several of them."""
    grid: str | None
    """Bends and velocities of the grid of starts, as `5x3`."""
    section: str | None
    """`peak`, `release` or `strobe`."""
    strobe_period: float | None
    """s"""
    settle: int | None
    """Peaks discarded."""
    cycles: int | None
    """Peaks measured."""
    orbits: bool
    """Follow periodic motions as branches."""
    fmu: Path | None
    """FMU whose start values are used [default: the package's own]."""
    threads: int | None


def sweep(
    parameter: str,
    *,
    output: Path | None = None,
    progress: Progress = None,
    **options: Unpack[StudyOptions],
) -> Study:
    """Studies the motions of the model over a parameter, or two: `sweep("belt_velocity",
    from_=0.05, to=0.2, points=31)`.

    The other arguments are those of `StudyOptions`. A study that was stopped goes on with the same
    call, where `output` is given.
    """
    folder = Folder(output)
    with Told(progress) as tell:
        return Study(_native.perform(study_words(parameter, folder.path, options), tell), folder)


def study_words(parameter: str, output: Path, options: StudyOptions) -> list[str]:
    """The command line of a study."""
    known = StudyOptions.__annotations__
    unknown = [name for name in options if name not in known]
    if unknown:
        raise TypeError(f"'{unknown[0]}' is no option of a study; there are {', '.join(known)}")
    given: dict[str, Any] = dict(options)
    lists = {
        name: list(given[name])
        for name in ("values", "second_values")
        if given.get(name) is not None
    }
    settings = dict(given.pop("settings", None) or {})
    given["fmu"] = fmu_or_own(given.get("fmu"))
    return words("sweep", parameter=parameter, set=settings, output=output, **{**given, **lists})


def _number(value: Any) -> Any:
    """JSON has no infinity: the table has it as a text."""
    return float(value) if value in ("inf", "-inf") else value
