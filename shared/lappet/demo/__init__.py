"""The bundled procedure that `lappet demo` solves: the Z-plasty of `examples/z_plasty`."""

from __future__ import annotations

from pathlib import Path

from lappet.refused import RefusedError

SPACING = 4.0 / 3.0  # mm: three cells through the skin, a few seconds a step


def z_plasty() -> Path:
    """The file of the bundled Z-plasty. Raises RefusedError where the installation lacks it."""
    here = Path(__file__).resolve()
    for path in (here.with_name("z_plasty.usda"), here.parents[3] / "examples" / "z_plasty" / "z_plasty.usda"):
        if path.is_file():
            return path
    raise RefusedError(f"The bundled procedure {here.with_name('z_plasty.usda')} is missing; install Lappet again.")
