"""The bundled procedure that `lappet demo` solves: the Z-plasty of `examples/z_plasty`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

from lappet.core.problem import RefusedError
from lappet.core.version import version

SPACING = 4.0 / 3.0  # mm: three cells through the skin, a few seconds a step


def z_plasty() -> Path:
    """The file of the bundled Z-plasty. Raises RefusedError where the installation lacks it."""
    here = Path(__file__).resolve()
    for path in (here.with_name("z_plasty.usda"), here.parents[3] / "examples" / "z_plasty" / "z_plasty.usda"):
        if path.is_file():
            return path
    raise RefusedError(f"The bundled procedure {here.with_name('z_plasty.usda')} is missing; install Lappet again.")


def figures_of(cache: Path, folder: Path, render: Callable[[Path, Path], list[Path]]) -> list[Path]:
    """The pictures of a skin cache in `folder`: those of an earlier run where cache and program are the same.

    render: draws a cache into a folder and returns the pictures, as `lappet.output.render.render_cache` does.
    """

    folder = folder.resolve()
    stamp = folder / "rendered.json"
    drawn = f"{version()} {hashlib.blake2b(cache.read_bytes(), digest_size=16).hexdigest()}"
    try:
        before = json.loads(stamp.read_text(encoding="utf-8"))
        pictures = [folder / name for name in before["pictures"]]
        if before["drawn"] == drawn and pictures and all(picture.is_file() for picture in pictures):
            return pictures
    except (OSError, ValueError, KeyError, TypeError):
        pass  # none yet, or not ours: draw them
    folder.mkdir(parents=True, exist_ok=True)
    pictures = render(cache, folder)
    names = [picture.resolve().relative_to(folder).as_posix() for picture in pictures]
    stamp.write_text(json.dumps({"drawn": drawn, "pictures": names}), encoding="utf-8")
    return pictures
