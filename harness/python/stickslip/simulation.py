"""One operating point of an FMU."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import table_html
from stickslip._words import Path, fmu_or_own, words

if TYPE_CHECKING:
    import pandas
    import plotly.graph_objects


class Simulation:
    """A motion: `time` in s, and the variables by name, each in its own unit."""

    def __init__(
        self,
        time: NDArray[np.float64],
        values: dict[str, NDArray[np.float64]],
        units: dict[str, str],
    ) -> None:
        self.time = time
        self.values = values
        self.units = units

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.values[name]

    def __len__(self) -> int:
        return len(self.time)

    def to_pandas(self) -> pandas.DataFrame:
        """One column for each variable, over `time` in s."""
        import pandas

        return pandas.DataFrame(self.values, index=pandas.Index(self.time, name="time"))

    def plot(self, *names: str) -> plotly.graph_objects.Figure:
        """The variables over time, one above the other; without names the first two."""
        from plotly.subplots import make_subplots

        shown = names or tuple(self.values)[:2]
        figure = make_subplots(rows=len(shown), cols=1, shared_xaxes=True)
        for row, name in enumerate(shown, start=1):
            figure.add_scatter(x=self.time, y=self[name], name=name, mode="lines", row=row, col=1)
            unit = self.units.get(name, "")
            label = name.replace("_", " ") + (f" [{unit}]" if unit and unit != "1" else "")
            figure.update_yaxes(title_text=label, row=row, col=1)
        figure.update_xaxes(title_text="time [s]", row=len(shown), col=1)
        return figure

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        return f"<Simulation: {len(self)} samples up to {end:g} s of {', '.join(self.values)}>"

    def _repr_html_(self) -> str:
        rows = [
            (name, self.units.get(name, ""), float(v.min()), float(v.max()), float(v[-1]))
            for name, v in self.values.items()
        ]
        header = ("variable", "unit", "lowest", "highest", "at the end")
        return f"<p>{len(self)} samples, {self.time[0]:g} to {self.time[-1]:g} s</p>" + table_html(
            header, rows
        )


def simulate(
    *,
    fmu: Path | None = None,
    belt_velocity: float | None = None,
    normal_force: float | None = None,
    settings: Mapping[str, float] | None = None,
    duration: float | None = None,
    step: float | None = None,
    inputs: Path | Mapping[str, ArrayLike] | None = None,
    input_interpolation: str | None = None,
    variables: Iterable[str] | None = None,
    progress: Progress = None,
) -> Simulation:
    """Runs one operating point of an FMU [default: the package's own].

    `belt_velocity` in m/s, `normal_force` in N, `duration` and output interval `step` in s;
    `settings` are other start values by variable name, in the variable's unit. `inputs` are a CSV
    file or arrays, `time` in s and one for each input that varies, such as `external_force`.
    `variables` are those recorded [default: every output].
    """
    with tempfile.TemporaryDirectory(prefix="stickslip-") as scratch:
        if isinstance(inputs, Mapping):
            inputs = _written(inputs, FilePath(scratch) / "inputs.csv")
        line = words(
            "simulate",
            fmu=fmu_or_own(fmu),
            belt_velocity=belt_velocity,
            normal_force=normal_force,
            set=dict(settings or {}),
            duration=duration,
            step=step,
            input=inputs,
            input_interpolation=input_interpolation,
            variables=None if variables is None else list(variables),
        )
        with Told(progress) as tell:
            found = _native.perform(line, tell)
    names: Sequence[str] = list(found["values"])
    return Simulation(found["time"], found["values"], dict(zip(names, found["units"])))


def _written(columns: Mapping[str, ArrayLike], path: FilePath) -> FilePath:
    """The arrays as a CSV file with all digits."""
    arrays: list[Any] = [np.asarray(column, dtype=float) for column in columns.values()]
    lines = [",".join(columns)]
    lines += [",".join(map(repr, map(float, row))) for row in zip(*arrays, strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
