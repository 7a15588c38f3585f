"""Paint the panels of a plate without a window: `python -m lappet_blender.figure.paint_panels JOB.json`.

The job is what `lappet.plates.painting` writes. Standard output carries the messages of `lappet_blender.figure`.
"""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np

if hasattr(bpy.utils, "expose_bundled_modules"):
    bpy.utils.expose_bundled_modules()

from lappet.drawing.framing import SurgicalField, Viewpoint
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError

from .figure_messages import messages
from .painted_scene import PaintedPanel, PaintedScene


def paint(job: dict[str, Any], report: Callable[[Path, int, int], None]) -> None:
    """Paint all panels of a job. report: told each picture, its number and how many there are. Raises FigureError."""
    total = sum(len(row["panels"]) for row in job["rows"])
    done = 0
    for row in job["rows"]:
        scene = PaintedScene(
            SkinCache(Path(row["cache"])),
            _field(row),
            np.array(row["axes"]),
            job["tone"],
            row["goes_on"],
        )
        for given in row["panels"]:
            panel = _panel(given)
            scene.paint(panel, job["samples"])
            done += 1
            report(panel.picture, done, total)


def _field(row: dict[str, Any]) -> SurgicalField:
    axes = np.array(row["axes"])
    corners, center = np.array(row["corners"]), np.array(row["center"])
    return SurgicalField(corners, center, axes[0], axes[1], axes[2], (1.0, 1.0), row["context"])


def _panel(given: dict[str, Any]) -> PaintedPanel:
    view = Viewpoint(np.array(given["position"]), np.array(given["axes"]), given["distance"])
    width, height = given["pixels"]
    return PaintedPanel(
        given["time"], view, given["half_width"], (width, height), given["hooks"], Path(given["picture"])
    )


def main(arguments: list[str]) -> int:
    """Paint as a job says; return the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # an interrupt ends a long render at once
    say = messages()
    job = json.loads(Path(arguments[0]).read_text(encoding="utf-8"))
    try:
        paint(job, lambda path, number, of: say(picture=str(path), number=number, of=of))
    except FigureError as error:
        say(error=str(error))
        return 1
    say(done=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
