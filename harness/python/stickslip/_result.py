"""What all results have in common."""

from __future__ import annotations

import html
import json
import shutil
import tempfile
import textwrap
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from stickslip import _page
from stickslip._words import Path

if TYPE_CHECKING:
    import pandas
    import plotly.graph_objects


class Folder:
    """The folder of a result: the one given, or a temporary one that goes with the result."""

    def __init__(self, given: Path | None) -> None:
        self.temporary = (
            None if given is not None else tempfile.TemporaryDirectory(prefix="stickslip-")
        )
        self.path = FilePath(self.temporary.name if self.temporary else given or ".")


class Result:
    """A result: `data` is the JSON of the command, `str()` what it prints, `folder` holds its
    files."""

    PAGE = "report.html"
    """Name of the report in the folder."""

    def __init__(self, data: dict[str, Any], text: str, folder: Folder) -> None:
        self.data = data
        self.text = text
        self._folder = folder

    @property
    def folder(self) -> FilePath:
        """Where the files of the result are. A temporary folder goes with the result; `save` keeps
        them."""
        return self._folder.path

    @property
    def report(self) -> FilePath:
        """The report, an HTML page for any browser."""
        return self.folder / self.PAGE

    def save(self, folder: Path) -> FilePath:
        """Copies the files of the result into a folder, and returns it."""
        return FilePath(shutil.copytree(self.folder, folder, dirs_exist_ok=True))

    @property
    def figures(self) -> list[_page.PageFigure]:
        """The report's figures, from top to bottom: caption, section, and data and layout as Plotly
        reads them."""
        return _page.figures(self.report) if self.report.exists() else []

    def plot(self, which: int | str = 0) -> plotly.graph_objects.Figure:
        """A figure of the report: its number from top to bottom, counted from 0, or a part of its
        caption or section."""
        import plotly.graph_objects

        found = self.figures
        if not found:
            raise LookupError("this result has no report with figures")
        if isinstance(which, str):
            fits = [f for f in found if which.lower() in f"{f.section} {f.caption}".lower()]
            if not fits:
                known = "; ".join(f.caption for f in found)
                raise LookupError(
                    f"no figure of the report has '{which}' in its caption; there are: {known}"
                )
            chosen = fits[0]
        else:
            chosen = found[which]
        figure = plotly.graph_objects.Figure(chosen.data)
        lines = textwrap.wrap(html.escape(chosen.caption), 90)
        title = {"text": "<br>".join(lines), "font": {"size": 13}, "y": 0.96, "yanchor": "top"}
        # The legend stands between the title and the picture.
        return figure.update_layout(title=title, margin={"t": 55 + 18 * len(lines)})

    def to_pandas(self) -> pandas.DataFrame:
        """The main table as a DataFrame."""
        import pandas

        header, rows = self._table()
        return pandas.DataFrame(rows, columns=list(header))

    def _table(self) -> tuple[Sequence[str], list[Sequence[Any]]]:
        """Header, units in it, and rows of the main table."""
        raise NotImplementedError

    def _lead(self) -> str:
        """A sentence or two above the table in notebooks."""
        return ""

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        lead = self._lead() or self.text.strip().split("\n")[0]
        return f"<{type(self).__name__}: {lead}>"

    def _repr_html_(self) -> str:
        header, rows = self._table()
        return f"<p>{html.escape(self._lead())}</p>" + table_html(header, rows)


def table_html(header: Sequence[str], rows: Sequence[Sequence[Any]], most: int = 20) -> str:
    """A table for notebooks; of a long one the first rows."""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in header)
    shown = rows[:most]
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell(v))}</td>" for v in row) + "</tr>" for row in shown
    )
    left = len(rows) - len(shown)
    more = f"<p>... and {left} rows more, <code>to_pandas()</code> has all.</p>" if left else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def cell(value: Any) -> str:
    """A value as tables show it: four digits."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)


def parsed(returned: dict[str, Any]) -> dict[str, Any]:
    """The JSON of what the extension module returned."""
    data: dict[str, Any] = json.loads(returned["json"])
    return data
