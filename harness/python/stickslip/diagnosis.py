"""Which physical effect the model lacks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, fmu_or_own, words
from stickslip.campaign import Campaign, folder_of

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Estimate:
    """A value with its standard deviation, in the unit of the FMU's variable."""

    value: float
    std: float


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was found."""

    id: str
    parameters: dict[str, Estimate]
    confounded_with: list[str]
    """Effects that these data can't distinguish from it."""
    evidence: dict[str, Any]


class Diagnosis(Result):
    """The outcome of `diagnose` or `try_effects`; `data` is diagnosis.json."""

    @classmethod
    def read(cls, folder: Path, text: str = "") -> Diagnosis:
        """What a diagnosis has left in a folder."""
        data = json.loads((FilePath(folder) / "diagnosis.json").read_text(encoding="utf-8"))
        return cls(data, text or data["summary"], Folder(folder))

    @property
    def verdict(self) -> str:
        """`effect_found`, `no_missing_effect` or `unknown_effect`."""
        return str(self.data["verdict"])

    @property
    def probability(self) -> float | None:
        """Of the verdict, among all that was compared."""
        value: float | None = self.data["verdict_probability"]
        return value

    @property
    def summary(self) -> str:
        """What was found and how sure it is, in words."""
        return str(self.data["summary"])

    @property
    def effects(self) -> list[FoundEffect]:
        """The effects found, in the order in which they were added."""
        return [
            FoundEffect(
                id=e["id"],
                parameters={n: _estimate(p) for n, p in e["parameters"].items()},
                confounded_with=e["confounded_with"],
                evidence=e["evidence"],
            )
            for e in self.data["effects"]
        ]

    @property
    def calibrated(self) -> dict[str, Estimate]:
        """Calibrated parameters of the model, by FMU variable."""
        return {name: _estimate(value) for name, value in self.data["calibrated"].items()}

    @property
    def gains_by_chance(self) -> list[list[float]]:
        """Largest gains in simulated campaigns without the effect, for each step; empty unless
        `null` asked for them."""
        gains: list[list[float]] = self.data.get("gains_by_chance", [])
        return gains

    @property
    def remarks(self) -> list[str]:
        """What the data leave open, and why."""
        return list(self.data["remarks"])

    @property
    def fmu(self) -> FilePath:
        """The calibrated ("repaired") FMU."""
        return self.folder / "StickSlipBeam.fmu"

    def ladder(self) -> pandas.DataFrame:
        """The error ladder: one row for each step."""
        import pandas

        frame = pandas.DataFrame(self.data["error_ladder"])
        return frame.drop(columns=["by_run"])

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        header = ["candidate", "gain", "probability", "fit_over_noise", "free_values", "fitted"]
        rows: list[Sequence[Any]] = [
            (
                c["id"],
                c["score"],
                c["probability"],
                c["fit_over_noise"],
                c["free_values"],
                c["fitted"],
            )
            for c in self.data["candidates"]
        ]
        return header, rows

    def _lead(self) -> str:
        return self.summary


def diagnose(
    campaign: Campaign | Path,
    *,
    fmu: Path | None = None,
    output: Path | None = None,
    hold_out: str | None = None,
    library: Path | None = None,
    null: int = 0,
    force: bool = False,
    progress: Progress = None,
) -> Diagnosis:
    """Finds the physical effect that an FMU [default: the package's own] lacks.

    `hold_out` says which runs are kept out of every fit, `library` is a folder of effects of your
    own, `null` the number of campaigns without the effect to simulate for the chance of a gain by
    chance. `progress` is `True`, or called with what is done and its share of the whole. Ctrl-C
    stops it; with `output` given, the same call goes on from there.
    """
    folder = Folder(output)
    line = diagnose_words(
        campaign, folder.path, fmu=fmu, hold_out=hold_out, library=library, null=null, force=force
    )
    with Told(progress) as tell:
        found = _native.perform(line, tell)
    return Diagnosis(parsed(found), found["text"], folder)


def diagnose_words(
    campaign: Campaign | Path,
    output: Path,
    *,
    fmu: Path | None,
    hold_out: str | None,
    library: Path | None,
    null: int,
    force: bool,
) -> list[str]:
    """The command line of a diagnosis."""
    return words(
        "diagnose",
        [folder_of(campaign)],
        fmu=fmu_or_own(fmu),
        output=output,
        hold_out=hold_out,
        library=library,
        null=null,
        force=force,
    )


def try_effects(
    campaign: Campaign | Path,
    *effects: str,
    fmu: Path | None = None,
    output: Path | None = None,
    force: bool = False,
    progress: Progress = None,
) -> Diagnosis:
    """The same by hand: adds the named effects to the calibrated model, one step of the error
    ladder at a time."""
    folder = Folder(output)
    line = words(
        "try",
        [folder_of(campaign)],
        add=tuple(effects),
        fmu=fmu_or_own(fmu),
        output=folder.path,
        force=force,
    )
    with Told(progress) as tell:
        found = _native.perform(line, tell)
    return Diagnosis(parsed(found), found["text"], folder)


def _estimate(value: dict[str, Any]) -> Estimate:
    nan = float("nan")
    return Estimate(*(nan if value[key] is None else value[key] for key in ("value", "std")))
