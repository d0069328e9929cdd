"""Quality of a campaign's data."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stickslip import _native
from stickslip._result import parsed, table_html
from stickslip._words import Path, words
from stickslip.campaign import Campaign, folder_of

if TYPE_CHECKING:
    import pandas


class Quality:
    """What `check` finds; `data` is its JSON, `str()` its page."""

    def __init__(self, data: dict[str, Any], text: str) -> None:
        self.data = data
        self.text = text

    @property
    def findings(self) -> list[dict[str, Any]]:
        """What contradicts the campaign's file: `id`, `severity`, `runs`, `measured`, `stated`,
        `remedy`."""
        found: list[dict[str, Any]] = self.data["findings"]
        return found

    @property
    def usable(self) -> bool:
        """Whether nothing was found that can't be meant."""
        return all(finding["severity"] != "error" for finding in self.findings)

    def to_pandas(self) -> pandas.DataFrame:
        """One row for each run."""
        import pandas

        return pandas.DataFrame(self.data["runs"])

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<Quality: {len(self.data['runs'])} runs, {len(self.findings)} findings>"

    def _repr_html_(self) -> str:
        keys = ["severity", "id", "runs", "measured", "stated", "remedy"]
        rows: list[Sequence[Any]] = [
            [", ".join(f[k]) if k == "runs" else f[k] for k in keys] for f in self.findings
        ]
        runs = self.data["runs"]
        names = [key for key in runs[0] if not isinstance(runs[0][key], (list, dict))]
        table = table_html(names, [[run[key] for key in names] for run in runs])
        lead = f"Campaign '{self.data['campaign']}': {len(rows)} findings"
        return f"<p>{html.escape(lead)}</p>{table}" + (table_html(keys, rows) if rows else "")


def check(campaign: Campaign | Path) -> Quality:
    """Looks at the data before long work: units, signs, swapped files, sampling, sensor."""
    found = _native.perform(words("check", [folder_of(campaign)]))
    return Quality(parsed(found), found["text"])
