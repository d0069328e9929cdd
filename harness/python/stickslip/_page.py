"""Figures of a report, read back from the page: each stands in it as Plotly's JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class PageFigure:
    """A figure of a page."""

    caption: str
    """One sentence that says what it shows."""
    section: str
    """Title of the section that it stands in."""
    data: dict[str, Any]
    """`data` and `layout`, as Plotly reads them."""


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.figures: list[PageFigure] = []
        self.section = ""
        self.caption = ""
        self.into: list[str] | None = None
        self.inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag == "figure":
            self.inside, self.caption = True, ""
        elif self.inside and tag == "div" and "aria-label" in given:
            self.caption = given["aria-label"] or ""
        elif tag == "h2" or (self.inside and tag == "script"):
            self.into = []

    def handle_data(self, data: str) -> None:
        if self.into is not None:
            self.into.append(data)

    def handle_endtag(self, tag: str) -> None:
        if tag == "figure":
            self.inside = False
        if self.into is None or tag not in ("h2", "script"):
            return
        text = "".join(self.into)
        self.into = None
        if tag == "h2":
            self.section = text.strip()
        else:
            self.figures.append(PageFigure(self.caption, self.section, json.loads(text)))


def figures(page: Path) -> list[PageFigure]:
    """The figures of a report, from top to bottom."""
    reader = _Reader()
    reader.feed(page.read_text(encoding="utf-8"))
    return reader.figures
