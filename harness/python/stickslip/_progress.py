"""What long work says of its progress."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TextIO

Progress = bool | Callable[[str, float], object] | None
"""`True` for a line on standard error, or a function of what is done and the share (0 to 1) of the
whole."""


class Line:
    """One line of text that is written over and over: a bar, the share and what is done."""

    WIDTH = 100

    def __init__(self, stream: TextIO | None = None) -> None:
        self.stream = sys.stderr if stream is None else stream
        self.begun = False

    def __call__(self, what: str, share: float) -> None:
        done = round(20 * min(max(share, 0.0), 1.0))
        line = f"{100 * share:3.0f} %|{'#' * done:<20}| {what}"
        print(f"\r{line[: self.WIDTH]:<{self.WIDTH}}", end="", file=self.stream, flush=True)
        self.begun = True

    def end(self) -> None:
        if self.begun:
            print(f"\r{'':<{self.WIDTH}}\r", end="", file=self.stream, flush=True)


class Told:
    """`with Told(progress) as tell:` gives what the extension module calls, or `None`."""

    def __init__(self, progress: Progress) -> None:
        self.line = Line() if progress is True else None
        self.tell = self.line or (progress if callable(progress) else None)

    def __enter__(self) -> Callable[[str, float], object] | None:
        return self.tell

    def __exit__(self, *_: object) -> None:
        if self.line:
            self.line.end()
