"""Panels painted by Blender: skin, wounds, threads and instruments in light, below the lines and texts of a plate."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lappet.drawing.framing import half_angles
from lappet.output.render import blender_python, run_figures
from lappet.plates.plate_page import PlatePage
from lappet.plates.plate_scene import PlateScene
from lappet.plates.plate_style import MONK, PlateStyle, Shading

MOST_SAMPLES, LEAST_SAMPLES = 6, 3  # of Cycles, a pixel; the pictures are denoised
_DENSE = 200.0  # pixels per inch; where there are more, each needs fewer samples for the same print


@dataclass(frozen=True, eq=False)
class Painted:
    """A panel to paint.

    Parameters
    ----------
    scene
        The procedure before the panel's camera.
    time
        Time code of its frame.
    size
        Its width and height in mm.
    hooks
        Whether hooks are drawn.
    """

    scene: PlateScene
    time: float
    size: tuple[float, float]
    hooks: bool


def page_paintings(
    page: PlatePage,
    style: PlateStyle,
    tone: int | None,
    dpi: float,
    say: Callable[[str], None] = lambda line: None,
) -> dict[int, bytes]:
    """Paint what of a page is painted: not cross-sections and maps.

    Parameters
    ----------
    page
        The page.
    style
        How it looks.
    tone
        Tone of the skin on the Monk scale, 1 to 10; None for a warm one between the fourth and the fifth.
    dpi
        Pixels per inch.
    say
        Called with a line of text for every panel.

    Returns
    -------
    dict[int, bytes]
        By the index of a panel, its picture, a PNG.

    Raises
    ------
    RefusedError
        If bpy is missing or fails.
    """
    if style.shading is not Shading.PAINTING or page.key:
        return {}
    chosen = {k: panel for k, panel in enumerate(page.panels) if not panel.section}
    wanted = [Painted(each.scene, each.step.time, each.size, each.hooks) for each in chosen.values()]
    with tempfile.TemporaryDirectory(prefix="lappet_painting_") as folder:
        pictures = paint(wanted, tone, dpi, Path(folder), say)
        return {k: picture.read_bytes() for k, picture in zip(chosen, pictures, strict=True)}


def paint(
    panels: Sequence[Painted],
    tone: int | None,
    dpi: float,
    folder: Path,
    say: Callable[[str], None] = lambda line: None,
) -> list[Path]:
    """Paint panels in one Blender process.

    Parameters
    ----------
    panels
        The panels.
    tone
        Tone of the skin on the Monk scale, 1 to 10; None for a warm one of its own.
    dpi
        Pixels per inch.
    folder
        Where to write the pictures.
    say
        Called with a line of text for every panel.

    Returns
    -------
    list[Path]
        The picture of each panel, a PNG that is transparent where there is nothing.

    Raises
    ------
    RefusedError
        If bpy is missing or fails.
    """
    if not panels:
        return []
    pictures = [folder / f"panel_{k:05d}.png" for k in range(len(panels))]
    rows: dict[Path, dict[str, Any]] = {}
    for panel, picture in zip(panels, pictures, strict=True):
        row = rows.setdefault(panel.scene.source.path, _row(panel.scene))
        row["panels"].append(_panel(panel, dpi, picture))
    job = {
        "rows": list(rows.values()),
        "tone": "" if tone is None else MONK[tone - 1],
        "samples": samples_at(dpi),
    }
    path = folder / "job.json"
    path.write_text(json.dumps(job), encoding="utf-8")
    run_figures([blender_python(), "-m", "lappet_blender.figure.paint_panels", str(path)], next(iter(rows)), say)
    return pictures


def samples_at(dpi: float) -> int:
    """Choose how many samples of Cycles a pixel has.

    Parameters
    ----------
    dpi
        Pixels per inch.

    Returns
    -------
    int
        The number.
    """
    return int(np.clip(round(MOST_SAMPLES * _DENSE / dpi), LEAST_SAMPLES, MOST_SAMPLES))


def _row(scene: PlateScene) -> dict[str, Any]:
    """What the panels of a procedure share."""
    points = scene.field.points
    return {
        "cache": str(scene.source.path.resolve()),
        "corners": _numbers([points.min(axis=0), points.max(axis=0)]),
        "center": _numbers(scene.field.center),
        "context": scene.field.context,
        "axes": _numbers(scene.axes),
        "goes_on": scene.goes_on,
        "panels": [],
    }


def _panel(panel: Painted, dpi: float, picture: Path) -> dict[str, Any]:
    view = panel.scene.view
    return {
        "time": panel.time,
        "position": _numbers(view.position),
        "axes": _numbers(view.axes),
        "distance": view.distance,
        "half_width": half_angles(panel.size)[0] / panel.scene.zoom,
        "pixels": [max(round(side / 25.4 * dpi), 1) for side in panel.size],
        "hooks": panel.hooks,
        "picture": str(picture),
    }


def _numbers(values: Iterable[Any]) -> Any:
    return np.asarray(values, np.float64).tolist()
