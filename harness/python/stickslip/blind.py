"""Diagnoses of campaigns whose answers are known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder, Result, parsed
from stickslip._words import Path, fmu_or_own, words

PROGRAM = str(_native.__file__)
"""The file whose content says by which program a result was found."""


class BlindTest(Result):
    """Diagnoses of campaigns with known answers, and counts."""

    @property
    def campaigns(self) -> list[dict[str, Any]]:
        """One entry for each campaign."""
        found: list[dict[str, Any]] = self.data["campaigns"]
        return found

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        keys = [
            "campaign",
            "kind",
            "hidden",
            "named",
            "verdict",
            "probability",
            "outcome",
            "seconds",
        ]
        return keys, [[_words(case[key]) for key in keys] for case in self.campaigns]

    def _lead(self) -> str:
        right = sum(case["right"] for case in self.campaigns)
        return f"{right} of {len(self.campaigns)} verdicts are right"


def blind_test(
    folder: Path,
    *,
    only: Iterable[str] | None = None,
    fmu: Path | None = None,
    output: Path | None = None,
    force: bool = False,
    progress: Progress = None,
) -> BlindTest:
    """Diagnoses every campaign of a folder with truth.json, or `only` those named, one on each
    processor, and counts. What is finished in `output` is not done again."""
    into = Folder(output)
    line = blind_words(folder, into.path, only=only, fmu=fmu, force=force)
    with Told(progress) as tell:
        found = _native.perform(line, tell, False, PROGRAM)
    return BlindTest(parsed(found), found["text"], into)


def blind_words(
    folder: Path, output: Path, *, only: Iterable[str] | None, fmu: Path | None, force: bool
) -> list[str]:
    """The command line of a blind test."""
    return words(
        "blind-test",
        [folder],
        only=None if only is None else list(only),
        fmu=fmu_or_own(fmu),
        output=output,
        force=force,
    )


def _words(value: Any) -> Any:
    return " + ".join(value) if isinstance(value, list) else value
