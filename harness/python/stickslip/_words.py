"""Arguments of functions as the command line that the library reads, so that both have the same
rules and defaults."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from importlib.resources import files
from typing import Any

Path = str | os.PathLike[str]

FMU = str(files("stickslip") / "StickSlipBeam.fmu")
"""The FMU that the package carries."""


def text(value: Any) -> str:
    """A value as the command line has it; numbers with all digits."""
    if isinstance(value, bool):
        raise TypeError(f"{value!r} is neither a number nor a text")
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, int) or hasattr(value, "__index__"):
        return str(int(value))
    return repr(float(value))


def words(command: str, positional: Iterable[Any] = (), **options: Any) -> list[str]:
    """The command line: `a_b=1` is `--a-b=1`, lists are separated by commas, `None` is left out,
    `True` is the bare option; mappings give the option once for each entry, as NAME=VALUE, and
    tuples once for each item."""
    line = [command]
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            line.append(option)
        elif isinstance(value, Mapping):
            line += [f"{option}={name}={text(item)}" for name, item in value.items()]
        elif isinstance(value, tuple):
            line += [f"{option}={text(item)}" for item in value]
        elif hasattr(value, "__iter__") and not isinstance(value, (str, os.PathLike)):
            line.append(f"{option}=" + ",".join(text(item) for item in value))
        else:
            line.append(f"{option}={text(value)}")
    given = [text(item) for item in positional]
    return line + (["--", *given] if given else [])


def fmu_or_own(fmu: Path | None) -> str:
    """The FMU given, or that of the package."""
    return FMU if fmu is None else os.fspath(fmu)
