"""Correlation dimension of a series."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, fmu_or_own, words

if TYPE_CHECKING:
    import pandas


class CorrelationDimension(Result):
    """Whether a series has a correlation dimension, and which."""

    PAGE = "dimension.html"

    def __init__(self, returned: dict[str, Any], folder: Folder) -> None:
        super().__init__(parsed(returned), returned["text"], folder)
        self.series: NDArray[np.float64] = returned["series"]
        self.radii: NDArray[np.float64] = returned["radii"]
        """Radii in the unit of the series."""
        self.pairs: NDArray[np.uint64] = np.array(returned["pairs"])
        """Pairs within each radius, one row for each embedding dimension from 1 on."""
        self.local_slopes: NDArray[np.float64] = np.array(returned["local_slopes"])

    @property
    def dimension(self) -> float | None:
        """The dimension, where the verdict claims one."""
        value: float | None = self.data["correlation_dimension"]
        return value

    @property
    def std(self) -> float | None:
        """Its standard deviation."""
        value: float | None = self.data["std"]
        return value

    @property
    def verdict(self) -> str:
        """The verdict in one word; `data["meaning"]` explains it."""
        return str(self.data["verdict"])

    def to_pandas(self) -> pandas.DataFrame:
        """Pairs over radii: one column for each embedding dimension."""
        import pandas

        names = [f"m={m}" for m in range(1, len(self.pairs) + 1)]
        return pandas.DataFrame(
            self.pairs.T, index=pandas.Index(self.radii, name="radius"), columns=names
        )

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        rows: list[Sequence[Any]] = [
            (d["m"], d["pairs"], d["slope_in_region"]) for d in self.data["dimensions"]
        ]
        return ["embedding dimension", "pairs", "slope in the scaling region"], rows

    def _lead(self) -> str:
        found = (
            ""
            if self.dimension is None
            else f" {self.dimension:.3f} +- {self.std or 0.0:.3f} (one standard deviation)"
        )
        return f"{self.verdict}{found}: {self.data['meaning']}"


def correlation_dimension(
    series: ArrayLike | Path | None = None,
    *,
    sample_interval: float | None = None,
    column: str | None = None,
    fmu: Path | None = None,
    belt_velocity: float | None = None,
    normal_force: float | None = None,
    settings: Mapping[str, float] | None = None,
    variable: str | None = None,
    samples: int | None = None,
    step: float | None = None,
    settle: float | None = None,
    noise_db: float | None = None,
    delay: int | None = None,
    theiler: int | None = None,
    max_dimension: int | None = None,
    norm: str | None = None,
    region: tuple[float, float] | None = None,
    thin: int | None = None,
    surrogates: int | None = None,
    seed: int | None = None,
    dither: bool = False,
    output: Path | None = None,
    progress: Progress = None,
) -> CorrelationDimension:
    """Correlation dimension of a series, with error bar, surrogate test and a verdict that may be
    "none".

    `series` is an array of even samples, `sample_interval` (s) apart, NaN where missing, or a CSV
    file; without one the output `variable` of an FMU [default: the package's own] is simulated. The
    rest as the command `dimension`.
    """
    folder = Folder(output)
    with tempfile.TemporaryDirectory(prefix="stickslip-") as scratch:
        model: Path | None = fmu
        file: Path | None = None
        if series is None:
            model = fmu_or_own(fmu)
        elif isinstance(series, (str, os.PathLike)):
            file = series
        else:
            file = _written(
                np.asarray(series, dtype=float), sample_interval, FilePath(scratch) / "series.csv"
            )
        line = words(
            "dimension",
            [] if file is None else [file],
            column=column,
            fmu=model,
            belt_velocity=belt_velocity,
            normal_force=normal_force,
            set=dict(settings or {}),
            variable=variable,
            samples=samples,
            step=step,
            settle=settle,
            noise_db=noise_db,
            delay=delay,
            theiler=theiler,
            max_dimension=max_dimension,
            norm=norm,
            region=None if region is None else list(region),
            thin=thin,
            surrogates=surrogates,
            seed=seed,
            dither=dither,
            output=folder.path,
        )
        with Told(progress) as tell:
            return CorrelationDimension(_native.perform(line, tell), folder)


def _written(values: NDArray[np.float64], interval: float | None, path: FilePath) -> FilePath:
    """The series as a CSV file with all digits; empty where missing."""
    texts = ["" if np.isnan(v) else repr(float(v)) for v in values]
    if interval is None:
        lines = ["series", *texts]
    else:
        lines = ["time_s,series", *(f"{k * interval!r},{text}" for k, text in enumerate(texts))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
