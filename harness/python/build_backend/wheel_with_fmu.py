"""maturin's build backend; before it builds, the FMU is packed that the wheel carries."""

import os
import subprocess
from pathlib import Path

from maturin import build_editable as _build_editable
from maturin import (  # the other hooks are maturin's own
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_wheel,
)
from maturin import build_wheel as _build_wheel

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_wheel",
]

PACKAGE = Path(__file__).resolve().parents[1]


def _pack() -> None:
    cargo = os.environ.get("CARGO", "cargo")
    manifest = PACKAGE / "Cargo.toml"
    fmu = PACKAGE / "stickslip" / "StickSlipBeam.fmu"
    program = ["--bin", "stickslip-wheel-fmu", "--", str(fmu)]
    subprocess.run(
        [cargo, "run", "--release", "--quiet", "--manifest-path", str(manifest), *program],
        check=True,
    )


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    _pack()
    return _build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    _pack()
    return _build_editable(wheel_directory, config_settings, metadata_directory)
