"""The bundled procedure that `lappet demo` solves; it is built by `examples/z_plasty`."""

from __future__ import annotations

from pathlib import Path

from lappet.refused import RefusedError


def z_plasty() -> Path:
    """The file of the bundled Z-plasty. Raises RefusedError where the installation lacks it."""
    path = Path(__file__).with_name("z_plasty.usda")
    if not path.is_file():
        raise RefusedError(f"The bundled procedure {path} is missing; install Lappet again.")
    return path
