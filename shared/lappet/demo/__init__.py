"""The bundled procedure that `lappet demo` solves: the Z-plasty of `examples/z_plasty`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.core.version import version

SPACING = 4.0 / 3.0  # mm: three cells through the skin, a few seconds a step


def z_plasty() -> Path:
    """Find the file of the bundled Z-plasty.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RefusedError
        If the installation lacks it.
    """
    here = Path(__file__).resolve()
    for path in (here.with_name("z_plasty.usda"), here.parents[3] / "examples" / "z_plasty" / "z_plasty.usda"):
        if path.is_file():
            return path
    raise refused(ProblemCode.DEMO_MISSING, here.with_name("z_plasty.usda"))


def figures_of(cache: Path, folder: Path, render: Callable[[Path, Path], list[Path]]) -> list[Path]:
    """Draw the pictures of a skin cache, or find those of an earlier run where cache and program are the same.

    Parameters
    ----------
    cache
        The skin cache.
    folder
        Folder for the pictures.
    render
        Draws a cache into a folder and returns the pictures, as `lappet.output.render.render_cache` does.

    Returns
    -------
    list[Path]
        The pictures.
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
