"""The physical effects that an FMU offers."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stickslip import _native
from stickslip._result import parsed, table_html
from stickslip._words import Path, fmu_or_own, words

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect, in its unit."""

    name: str
    variable: str
    """Name of the FMU's variable."""
    description: str
    unit: str
    off: float
    typical: float
    min: float
    max: float
    role: str


@dataclass(frozen=True)
class Effect:
    """A physical effect."""

    id: str
    title: str
    equation: str
    description: str
    source: str
    signature: str
    """How it shows in a measurement."""
    confounders: str
    """What looks alike."""
    parameters: list[Parameter]
    states: list[str]

    def _repr_html_(self) -> str:
        e = html.escape
        rows = [
            (p.variable, p.unit, p.off, p.typical, p.min, p.max, p.description)
            for p in self.parameters
        ]
        header = ("variable", "unit", "off", "typical", "lowest", "highest", "")
        text = f"<p><b>{e(self.id)}</b>: {e(self.title)}</p><pre>{e(self.equation)}</pre>"
        text += f"<p>{e(self.description)}</p>"
        return text + table_html(header, rows)


class Effects(Sequence[Effect]):
    """Effects by number or identifier."""

    def __init__(self, effects: list[Effect]) -> None:
        self._effects = effects

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            for effect in self._effects:
                if effect.id == key:
                    return effect
            raise KeyError(key)
        return self._effects[key]

    def __len__(self) -> int:
        return len(self._effects)

    def __iter__(self) -> Iterator[Effect]:
        return iter(self._effects)

    def to_pandas(self) -> pandas.DataFrame:
        """One row for each effect."""
        import pandas

        return pandas.DataFrame(self._rows(), columns=["id", "title", "equation"])

    def _rows(self) -> list[tuple[str, str, str]]:
        return [(e.id, e.title, e.equation) for e in self._effects]

    def __repr__(self) -> str:
        return f"<Effects: {', '.join(e.id for e in self._effects)}>"

    def _repr_html_(self) -> str:
        return table_html(("id", "title", "equation"), self._rows(), most=len(self))


def effects(*, fmu: Path | None = None, library: bool = False) -> Effects:
    """The effects that an FMU [default: the package's own] offers; `library`: those that a
    diagnosis tries where none of the catalogue explains the data."""
    found = _native.perform(words("effects", fmu=fmu_or_own(fmu), library=library))
    entries: Any = parsed(found)
    return Effects(
        [
            Effect(**{**entry, "parameters": [Parameter(**p) for p in entry["parameters"]]})
            for entry in entries
        ]
    )
