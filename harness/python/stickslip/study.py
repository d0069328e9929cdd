"""Motions over one parameter or two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, fmu_or_own, words


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
        keys = ["start", "period", "main_frequency_hz", "amplitude_m", "stick_fraction", "lyapunov_per_s", "status"]
        table: list[Sequence[Any]] = [[*r["at"].values(), *(_number(r[key]) for key in keys)] for r in rows]
        return names + keys, table

    def _lead(self) -> str:
        rows = self.data["rows"]
        return f"{len(rows)} motions over {', '.join(rows[0]['at'])}"


def sweep(parameter: str, *, output: Path | None = None, progress: Progress = None, **options: Any) -> Study:
    """Studies the motions of the model over a parameter, or two. The other arguments are those of `study_words`.

    A study that was stopped goes on with the same call, where `output` is given.
    """
    folder = Folder(output)
    line = study_words(parameter, output=folder.path, **options)
    with Told(progress) as tell:
        return Study(_native.perform(line, tell), folder)


def study_words(
    parameter: str,
    *,
    output: Path,
    from_: float | None = None,
    to: float | None = None,
    points: int | None = None,
    values: Sequence[float] | None = None,
    second_parameter: str | None = None,
    second_from: float | None = None,
    second_to: float | None = None,
    second_points: int | None = None,
    second_values: Sequence[float] | None = None,
    settings: Mapping[str, float] | None = None,
    start: str | Sequence[str] | None = None,
    grid: str | None = None,
    section: str | None = None,
    strobe_period: float | None = None,
    settle: int | None = None,
    cycles: int | None = None,
    orbits: bool = False,
    fmu: Path | None = None,
    threads: int | None = None,
) -> list[str]:
    """The command line of a study.

    `points` values of `parameter` between `from_` and `to`, or `values`, in the variable's unit; likewise those of the
    second parameter. `start` is `fixed`, `up`, `down` or `grid`, or several of them; `section` is `peak`, `release` or
    `strobe` (each `strobe_period`, s). `settle` peaks are discarded, `cycles` measured. `orbits` follows periodic motions
    as branches.
    """
    return words(
        "sweep",
        parameter=parameter,
        from_=from_,
        to=to,
        points=points,
        values=None if values is None else list(values),
        second_parameter=second_parameter,
        second_from=second_from,
        second_to=second_to,
        second_points=second_points,
        second_values=None if second_values is None else list(second_values),
        set=dict(settings or {}),
        start=start if start is None or isinstance(start, str) else list(start),
        grid=grid,
        section=section,
        strobe_period=strobe_period,
        settle=settle,
        cycles=cycles,
        orbits=orbits,
        fmu=fmu_or_own(fmu),
        threads=threads,
        output=output,
    )


def _number(value: Any) -> Any:
    """JSON has no infinity: the table has it as a text."""
    return float(value) if value in ("inf", "-inf") else value
