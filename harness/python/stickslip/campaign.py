"""Measured campaigns."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import _native
from stickslip._result import Folder, table_html
from stickslip._words import Path, words

if TYPE_CHECKING:
    import pandas
    import plotly.graph_objects

Beam = Path | Mapping[str, Any] | None
"""What is known of the structure: a TOML file with `[beam]`, or the keys of that table, as
`{"natural_frequencies_hz": [80, 510], "mass_kg": 0.4}`; with the keys `beam`, `uncertainty` and
`rig` all three tables."""

Quantity = Literal["displacement", "velocity", "acceleration"]
"""What the sensor at the tip measures."""

Source = float | str
"""A value in the SI unit, the name of a channel of the file, or `mean:CHANNEL`."""


@dataclass(frozen=True)
class Run:
    """One measured run, in SI units."""

    name: str
    file: FilePath
    belt_velocity: float
    """m/s; the mean, where it varies"""
    normal_force: float
    """N; the mean, where it varies"""
    time: NDArray[np.float64]
    """s"""
    quantity: Quantity
    """What the sensor at the tip measured."""
    unit: str
    """Its SI unit: m, m/s or m/s^2."""
    measured: NDArray[np.float64]
    """What it read, in that unit."""
    inputs: dict[str, NDArray[np.float64]]
    """What varies in time, by the FMU's names, SI units."""
    noise_std: float
    """Of what was measured, in its unit."""
    sample_interval: float
    """s"""
    understood: str | None
    """How the file was read, where it is not plain CSV in SI units."""
    campaign: FilePath = field(repr=False)
    """Folder of the campaign."""
    keep: Folder | None = field(repr=False)
    """Keeps a temporary folder as long as the run."""

    @property
    def displacement(self) -> NDArray[np.float64]:
        """What was measured, where that is a displacement, in m."""
        if self.quantity != "displacement":
            raise AttributeError(
                f"run {self.name} holds a {self.quantity} in {self.unit}: take `measured`"
            )
        return self.measured


class Campaign:
    """A folder with campaign.toml and a CSV for each run. `Campaign(FOLDER)` reads one; the
    functions `from_...` write one, into `folder` [default: a temporary one that goes with the
    object]."""

    def __init__(self, folder: Path) -> None:
        self._keep: Folder | None = None
        self._read(FilePath(folder))

    def _read(self, folder: FilePath) -> None:
        found = _native.load_campaign(folder)
        self.folder = FilePath(found["folder"])
        self.name: str = found["name"]
        self.beam: dict[str, list[float]] = found["beam"]
        """What is known of the structure; empty lists where nothing is."""
        self.quantity: Quantity = found["quantity"]
        """What the sensor at the tip measured, the same in all runs."""
        self.unit: str = found["unit"]
        """Its SI unit."""
        shared = {"quantity": self.quantity, "unit": self.unit, "campaign": self.folder}
        self.runs = [
            Run(**{**run, "file": FilePath(run["file"])}, **shared, keep=self._keep)
            for run in found["runs"]
        ]

    @classmethod
    def from_arrays(
        cls,
        time: ArrayLike | Sequence[ArrayLike],
        displacement: ArrayLike | Sequence[ArrayLike],
        *,
        belt_velocity: ArrayLike | Sequence[ArrayLike],
        normal_force: ArrayLike | Sequence[ArrayLike],
        external_force: ArrayLike | Sequence[ArrayLike] | None = None,
        clamp_acceleration: ArrayLike | Sequence[ArrayLike] | None = None,
        quantity: Quantity = "displacement",
        names: Sequence[str] | None = None,
        name: str | None = None,
        beam: Beam = None,
        folder: Path | None = None,
    ) -> Campaign:
        """Of samples in memory: `time` in s, `displacement` in m, belt velocity in m/s, forces in
        N, acceleration of the clamp in m/s^2, each a value or one for each sample. With another `quantity` the second argument holds
        a velocity in m/s or an acceleration in m/s^2. One run of plain arrays; several of lists
        with an entry for each run."""
        several = _is_several(time)
        times: list[Any] = list(time) if several else [time]  # type: ignore[arg-type]
        count = len(times)
        moved: list[Any] = list(displacement) if several else [displacement]  # type: ignore[arg-type]
        belts = _each("belt_velocity", belt_velocity, count, several)
        loads = _each("normal_force", normal_force, count, several)
        forces = _each("external_force", external_force, count, several)
        clamps = _each("clamp_acceleration", clamp_acceleration, count, several)
        called = list(names) if names is not None else [f"run{k:02}" for k in range(1, count + 1)]
        for what, entries in ((quantity, moved), ("names", called)):
            if len(entries) != count:
                raise ValueError(
                    f"{what} has {len(entries)} entries for {count} runs; give one for each"
                )
        runs = [
            (str(n), _array(t), _array(w), _input(v), _input(f), _excitation(e), _excitation(a))
            for n, t, w, v, f, e, a in zip(
                called, times, moved, belts, loads, forces, clamps
            )
        ]

        def write(into: FilePath) -> None:
            _native.write_campaign(into, name, _beam_text(beam), quantity, runs)

        return cls._made(write, folder, name)

    @classmethod
    def from_dataframe(
        cls,
        frame: pandas.DataFrame | Mapping[str, pandas.DataFrame],
        *,
        time: str | None = None,
        displacement: str | None = None,
        velocity: str | None = None,
        acceleration: str | None = None,
        belt_velocity: float | str,
        normal_force: float | str,
        external_force: float | str | None = None,
        clamp_acceleration: float | str | None = None,
        run: str | None = None,
        name: str | None = None,
        beam: Beam = None,
        folder: Path | None = None,
    ) -> Campaign:
        """Of a pandas DataFrame in SI units: names of columns, or values in place of those of the
        inputs. One of `displacement`, `velocity` and `acceleration` names what was measured; `time`
        is a column [default: the index]. Several runs: a mapping of names to frames, or one frame
        with a column `run` that names them."""
        if isinstance(frame, Mapping):
            parts = {str(key): part for key, part in frame.items()}
        elif run is not None:
            parts = {str(key): part for key, part in frame.groupby(run, sort=False)}
        else:
            parts = {"run01": frame}

        def of(part: pandas.DataFrame, source: float | str | None) -> Any:
            if isinstance(source, str):
                return part[source].to_numpy(dtype=float)
            return source

        columns: dict[Quantity, str | None] = {
            "displacement": displacement,
            "velocity": velocity,
            "acceleration": acceleration,
        }
        given = [(key, column) for key, column in columns.items() if column is not None]
        if len(given) != 1:
            raise ValueError(
                f"{len(given)} of displacement, velocity and acceleration are given; name one column"
            )
        ((quantity, measured),) = given
        lists: dict[str, list[Any]] = {
            "time": [],
            "measured": [],
            "belt": [],
            "load": [],
            "force": [],
            "clamp": [],
        }
        for part in parts.values():
            lists["time"].append(
                part.index.to_numpy(dtype=float) if time is None else of(part, time)
            )
            lists["measured"].append(of(part, measured))
            lists["belt"].append(of(part, belt_velocity))
            lists["load"].append(of(part, normal_force))
            lists["force"].append(of(part, external_force))
            lists["clamp"].append(of(part, clamp_acceleration))
        return cls.from_arrays(
            lists["time"],
            lists["measured"],
            belt_velocity=lists["belt"],
            normal_force=lists["load"],
            external_force=lists["force"] if external_force is not None else None,
            clamp_acceleration=lists["clamp"] if clamp_acceleration is not None else None,
            quantity=quantity,
            names=list(parts),
            name=name,
            beam=beam,
            folder=folder,
        )

    @classmethod
    def from_files(
        cls,
        files: Path | Iterable[Path],
        *,
        belt_velocity: Source | Sequence[Source] | None = None,
        normal_force: Source | Sequence[Source] | None = None,
        external_force: Source | Sequence[Source] | None = None,
        clamp_acceleration: Source | Sequence[Source] | None = None,
        time: str | None = None,
        rate: float | None = None,
        displacement: str | None = None,
        velocity: str | None = None,
        acceleration: str | None = None,
        unit: str | Mapping[str, str] | None = None,
        scale: float | Mapping[str, float] | None = None,
        start: float | None = None,
        end: float | None = None,
        skip_missing: bool = False,
        name: str | None = None,
        beam: Beam = None,
        folder: Path | None = None,
    ) -> Campaign:
        """Of loggers' files, one run each: CSV, MATLAB, HDF5, UFF 58, WAV, Parquet, TDMS, told by
        their content; `from_csv` and `from_mat` are other names of this function.

        Belt velocity (m/s), normal force and external force (N) and acceleration of the clamp
        (m/s^2) are a value, a channel or `mean:CHANNEL`, one for all files or a list with one for
        each. `time` and `displacement` are
        channels [default: found by name and unit], `rate` samples per second for files without
        times; `velocity` or `acceleration` name the channel of what a vibrometer or an
        accelerometer measured in place of a displacement; `unit` and `scale` are those of what was
        measured, or by channel. `start` and `end` (s) cut. As the command `import`."""
        given = [files] if isinstance(files, (str, os.PathLike)) else list(files)
        with tempfile.TemporaryDirectory(prefix="stickslip-") as scratch:
            known: Path | None = None
            if isinstance(beam, Mapping):
                known = FilePath(scratch) / "beam.toml"
                FilePath(known).write_text(_beam_text(beam) or "", encoding="utf-8")
            else:
                known = beam

            def write(into: FilePath) -> None:
                line = words(
                    "import",
                    given,
                    output=into,
                    belt_velocity=_sources(belt_velocity),
                    normal_force=_sources(normal_force),
                    external_force=_sources(external_force),
                    clamp_acceleration=_sources(clamp_acceleration),
                    time=time,
                    rate=rate,
                    displacement=displacement,
                    velocity=velocity,
                    acceleration=acceleration,
                    unit=unit,
                    scale=scale,
                    start=start,
                    end=end,
                    skip_missing=skip_missing,
                    name=name,
                    beam=known,
                )
                _native.perform(line)

            return cls._made(write, folder, name)

    from_csv = from_files
    from_mat = from_files

    @classmethod
    def _made(cls, write: Any, folder: Path | None, name: str | None) -> Campaign:
        keep = Folder(folder)
        # A campaign without a name has its folder's.
        into = (
            keep.path
            if folder is not None
            else keep.path / (name or "campaign").replace(os.sep, "_")
        )
        write(into)
        made = cls.__new__(cls)
        made._keep = keep
        made._read(into)
        return made

    def __getitem__(self, name: str) -> Run:
        for run in self.runs:
            if run.name == name:
                return run
        raise KeyError(name)

    def __len__(self) -> int:
        return len(self.runs)

    def __fspath__(self) -> str:
        return str(self.folder)

    def to_pandas(self) -> pandas.DataFrame:
        """One row for each run."""
        import pandas

        header, rows = self._table()
        return pandas.DataFrame(rows, columns=list(header))

    def plot(self, *names: str) -> plotly.graph_objects.Figure:
        """What was measured over time, run by run; without names all runs."""
        import plotly.graph_objects

        figure = plotly.graph_objects.Figure()
        for run in self.runs:
            if not names or run.name in names:
                figure.add_scatter(x=run.time, y=run.measured, name=run.name, mode="lines")
        figure.update_xaxes(title_text="time [s]")
        figure.update_yaxes(title_text=f"tip {self.quantity} [{self.unit}]")
        return figure.update_layout(
            title_text=f"Campaign '{self.name}' as measured", showlegend=True
        )

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        header = [
            "run",
            "belt_velocity_m_per_s",
            "normal_force_n",
            "samples",
            "duration_s",
            "noise_" + suffix(self.unit),
        ]
        rows: list[Sequence[Any]] = [
            (
                r.name,
                r.belt_velocity,
                r.normal_force,
                len(r.time),
                float(r.time[-1] - r.time[0]),
                r.noise_std,
            )
            for r in self.runs
        ]
        return header, rows

    def __repr__(self) -> str:
        return f"<Campaign '{self.name}': {len(self.runs)} runs in {self.folder}>"

    def _repr_html_(self) -> str:
        header, rows = self._table()
        return f"<p>Campaign '{self.name}', {len(self.runs)} runs</p>" + table_html(header, rows)


def suffix(unit: str) -> str:
    """A unit as the names of columns have it."""
    return unit.replace("/", "_per_").replace("^", "")


def folder_of(campaign: Campaign | Path) -> str:
    """The folder of a campaign, which may be given as its path."""
    return os.fspath(campaign)


def _is_several(time: Any) -> bool:
    """Whether a list of arrays is given, and not one array."""
    if isinstance(time, np.ndarray):
        return time.ndim > 1 or time.dtype == object
    first = next(iter(time), 0.0)
    return np.ndim(first) > 0


def _each(what: str, given: Any, count: int, several: bool) -> list[Any]:
    """An input's value or samples for each run."""
    if not several or given is None or np.ndim(np.asarray(given, dtype=object)) == 0:
        return [given] * count
    entries = list(given)
    if len(entries) != count:
        raise ValueError(f"{what} has {len(entries)} entries for {count} runs; give one for each")
    return entries


def _array(values: Any) -> NDArray[np.float64]:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise ValueError(f"an array of one dimension is expected, but this has {array.ndim}")
    return array


def _input(value: Any) -> float | NDArray[np.float64]:
    return float(value) if np.ndim(value) == 0 else _array(value)


def _excitation(value: Any) -> float | NDArray[np.float64] | None:
    return None if value is None else _input(value)


def _sources(given: Any) -> Any:
    """One source, or one for each file, as an option takes it."""
    return given if given is None or isinstance(given, (str, float, int)) else list(given)


def _beam_text(beam: Beam) -> str | None:
    """The text of a TOML file with `[beam]`."""
    if beam is None:
        return None
    if isinstance(beam, Mapping):
        tables = beam if "beam" in beam else {"beam": beam}
        plain = json.dumps(tables, default=lambda value: np.asarray(value).tolist())
        return _native.toml_of_json(plain)
    return FilePath(beam).read_text(encoding="utf-8")
