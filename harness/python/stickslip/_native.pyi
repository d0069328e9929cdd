"""The extension module: command lines in, JSON and arrays out."""

from collections.abc import Callable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

_Progress = Callable[[str, float], object] | None
_Floats = NDArray[np.float64]
_Given = float | _Floats
_Run = tuple[str, _Floats, _Floats, _Given, _Given, _Given | None, _Given | None]

def perform(
    words: list[str],
    progress: _Progress = None,
    alone: bool = False,
    program: str | PathLike[str] | None = None,
) -> dict[str, Any]: ...
def plan(words: list[str]) -> str: ...
def load_campaign(path: str | PathLike[str]) -> dict[str, Any]: ...
def write_campaign(
    folder: str | PathLike[str],
    name: str | None,
    beam: str | None,
    quantity: str,
    runs: list[_Run],
) -> None: ...
def toml_of_json(json: str) -> str: ...
def sweep_chain(words: list[str], chain: int) -> None: ...
def diagnose_later(words: list[str], progress: _Progress = None) -> tuple[str, str]: ...
def diagnose_known(
    words: list[str], gains: list[list[float]], progress: _Progress = None
) -> tuple[str, str]: ...
def null_gains(words: list[str], first: int, end: int) -> list[list[float]]: ...
