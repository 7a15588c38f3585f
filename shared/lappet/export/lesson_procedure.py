"""One solved procedure of a lesson: skin, bed, strands, labels, steps and where the camera stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_kind import KIND_COLORS, KINDS
from lappet.drawing.framing import SurgicalField, surgical_field
from lappet.drawing.skin_read import SkinCache
from lappet.export.lesson_arrays import LessonArrays
from lappet.export.lesson_labels import lesson_labels
from lappet.export.lesson_skin import LessonSkin
from lappet.export.lesson_strands import Line, strands
from lappet.plates.plate_scene import PlateScene, plate_scene
from lappet.plates.plate_steps import PlateStep, plate_steps
from lappet.procedure.vessel import VESSEL_COLORS

_SIZE = (160.0, 100.0)  # of the panel that the field is found for; the browser finds its own distance
_DIRECTIONS = 96


@dataclass(frozen=True, eq=False)
class LessonScene:
    """A solved procedure before the camera, and what of it is shown.

    Parameters
    ----------
    source
        The solved procedure.
    frames
        Time codes of the frames that are shown, ascending.
    steps
        The steps among them.
    scene
        The procedure before the camera.
    """

    source: SkinCache
    frames: tuple[float, ...]
    steps: tuple[PlateStep, ...]
    scene: PlateScene

    @staticmethod
    def of(source: SkinCache, frames: tuple[float, ...]) -> LessonScene:
        """Find the steps and place the camera.

        Parameters
        ----------
        source
            The solved procedure.
        frames
            Time codes of the frames that are shown, ascending.

        Returns
        -------
        LessonScene
            The scene.
        """
        steps = tuple(step for step in plate_steps(source, _normal(source)) if step.time in frames)
        times = [step.time for step in steps] or [frames[0], frames[-1]]
        return LessonScene(source, frames, steps, plate_scene(source, times, "oblique", _SIZE))


def lesson_procedure(shown: LessonScene, title: str, scales: Mapping[str, Any], arrays: LessonArrays) -> dict[str, Any]:
    """Write a procedure.

    Parameters
    ----------
    shown
        The solved procedure, its frames and steps.
    title
        Its name in the lesson.
    scales
        The color scales of its quantities (`lappet.export.lesson_skin.quantity_scales`).
    arrays
        Where its arrays go.

    Returns
    -------
    dict[str, Any]
        All that the viewer knows of it, for JSON.
    """
    source, frames, scene = shown.source, shown.frames, shown.scene
    skin = LessonSkin(source, frames, scales, arrays)
    return {
        "title": title,
        "fps": source.fps,
        "times": list(frames),
        "steps": [{"frame": frames.index(step.time), "kind": str(step.kind)} for step in shown.steps],
        "epochs": skin.epochs(),
        "quantities": scales,
        "layers": _layers(source),
        "bed": _bed(scene, frames, arrays),
        "scenery": [
            {
                "kind": mesh.kind,
                "positions": arrays.positions(mesh.points[None]),
                "triangles": arrays.add(mesh.triangles.astype(np.uint32)),
            }
            for mesh in source.scenery
        ],
        "strands": _strands(scene, frames, arrays),
        "labels": lesson_labels(scene, frames),
        "field": _field(scene.field),
    }


def _normal(source: SkinCache) -> NDArray[np.float64]:
    return surgical_field(source, (source.frames[0],)).normal


def _layers(source: SkinCache) -> dict[str, Any]:
    layers = source.layers
    return {
        "column": layers.column.tolist(),
        "depthFrom": [round(float(each), 4) for each in layers.depth_from],
        "kind": [KINDS[int(each)] for each in layers.kind],
        "colors": {KINDS[int(each)]: KIND_COLORS[KINDS[int(each)]] for each in np.unique(layers.kind)},
    }


def _bed(scene: PlateScene, frames: Sequence[float], arrays: LessonArrays) -> dict[str, Any] | None:
    if not len(scene.bed):
        return None
    states = np.stack([scene.bed.positions(time) for time in frames])
    return {"positions": arrays.positions(states), "triangles": arrays.add(scene.bed.triangles.astype(np.uint32))}


def _strands(scene: PlateScene, frames: Sequence[float], arrays: LessonArrays) -> dict[str, Any]:
    marks, threads, hooks = [], [], []
    for time in frames:
        marks.append(_lines(scene.marks.tubes(time)))
        threads.append(_lines(scene.threads.tubes(time)))
        hooks.append(_lines(scene.hooks.tubes(time)))
    found = {name: strands(each, arrays) for name, each in (("marks", marks), ("threads", threads), ("hooks", hooks))}
    for kind, color in VESSEL_COLORS.items():
        pieces = [[(one.points, one.radius) for one in scene.source.vessels(t) if one.kind == kind] for t in frames]
        if any(pieces):
            found[kind] = {**strands(pieces, arrays), "color": color}
    return found


def _lines(tubes: tuple[Sequence[NDArray[np.float64]], Sequence[Any]]) -> list[Line]:
    return list(zip(*tubes, strict=True))


def _field(field: SurgicalField) -> dict[str, Any]:
    """The axes of the field, and those of its points that decide how near a camera may stand."""
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(_DIRECTIONS)
    height = np.linspace(1.0, -1.0, _DIRECTIONS)
    flat = np.sqrt(1.0 - height**2)
    ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=1)
    outer = np.unique((field.points @ ways.T).argmax(axis=0))
    return {
        "center": field.center.tolist(),
        "right": field.right.tolist(),
        "up": field.up.tolist(),
        "normal": field.normal.tolist(),
        "points": np.round(field.points[outer], 3).tolist(),
        "context": field.context,
        "scale": field.stitch_scale,
    }
