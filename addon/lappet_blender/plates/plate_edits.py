"""Edits of a scene's plates. Each takes names or nothing, for the chosen plate, panel and annotation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.plate_templates import from_template
from lappet.procedure.plate import ANNOTATION_ANCHORS, AnnotationKind

from ..files.export_usd import procedure_of
from ..model.plate_names import active_annotation, active_panel, active_plate, free_name
from ..model.plate_values import set_plate

Point = Sequence[float]


def chosen_plate(scene: bpy.types.Scene) -> Any:
    """The chosen plate; raises RefusedError where there is none."""
    plate = active_plate(scene)
    if plate is None:
        raise refused(ProblemCode.PLATE_NONE_CHOSEN, "", "plate")
    return plate


def chosen_panel(scene: bpy.types.Scene) -> Any:
    """The chosen panel; raises RefusedError where there is none."""
    panel = active_panel(scene)
    if panel is None:
        raise refused(ProblemCode.PLATE_NONE_CHOSEN, "", "panel")
    return panel


def chosen_annotation(scene: bpy.types.Scene) -> Any:
    """The chosen annotation; raises RefusedError where there is none."""
    note = active_annotation(scene)
    if note is None:
        raise refused(ProblemCode.PLATE_NONE_CHOSEN, "", "annotation")
    return note


def add_plate(scene: bpy.types.Scene, template: str) -> str:
    """Add a plate from a template and choose it; raises RefusedError where the scene holds no procedure."""
    made = from_template(procedure_of(scene), template)
    set_plate(scene.lappet.pages.add(), made)
    scene.lappet.active_page = len(scene.lappet.pages) - 1
    return made.name


def add_panel(scene: bpy.types.Scene, step: str, time: float) -> str:
    """Add a panel to the chosen plate, behind the chosen one, and choose it."""
    plate = chosen_plate(scene)
    name = free_name(plate.panels, step if step != "FRAME" else f"frame_{time:g}", "panel")
    panel = plate.panels.add()
    panel.name, panel.step, panel.time = name, step, time
    after = min(plate.active_panel + 1, len(plate.panels) - 1)
    plate.panels.move(len(plate.panels) - 1, after)
    plate.active_panel = after
    return name


def add_annotation(scene: bpy.types.Scene, kind: AnnotationKind, points: Sequence[Point], text: str = "") -> str:
    """Add an annotation with anchors at rest in mm to the chosen plate and choose it.

    Raises RefusedError for as many anchors as its kind cannot have.
    """
    plate = chosen_plate(scene)
    least, most = ANNOTATION_ANCHORS[kind]
    if not least <= len(points) <= most:
        wanted = f"{least}" if least == most else f"{least} to {most}"
        raise refused(ProblemCode.ANNOTATION_ANCHORS, "", len(points), kind=kind, wanted=wanted)
    name = free_name(plate.annotations, text or kind, kind)
    note = plate.annotations.add()
    note.name, note.kind, note.text = name, kind, text
    for point in points:
        note.anchors.add().co = point
    plate.active_annotation = len(plate.annotations) - 1
    return name


def place_annotation(scene: bpy.types.Scene, name: str, offset: Sequence[float]) -> None:
    """Put the text of an annotation somewhere on paper, mm from its first anchor to the right and down."""
    plate = chosen_plate(scene)
    index = plate.annotations.find(name)
    if index < 0:
        raise refused(ProblemCode.PLATE_NONE_CHOSEN, name, "annotation")
    note = plate.annotations[index]
    note.placed, note.offset = True, (round(offset[0], 1), round(offset[1], 1))
    plate.active_annotation = index


def remove_item(owner: Any, items: str, active: str) -> None:
    """Take the chosen item out of a list."""
    index = getattr(owner, active)
    if 0 <= index < len(getattr(owner, items)):
        gone = str(getattr(owner, items)[index].name)
        getattr(owner, items).remove(index)
        setattr(owner, active, max(0, min(index, len(getattr(owner, items)) - 1)))
        if items == "panels":
            _panel_is_gone(owner, gone)


def move_item(owner: Any, items: str, active: str, by: int) -> None:
    """Move the chosen item of a list up (-1) or down (1)."""
    index, count = getattr(owner, active), len(getattr(owner, items))
    if 0 <= index < count and 0 <= index + by < count:
        getattr(owner, items).move(index, index + by)
        setattr(owner, active, index + by)


def _panel_is_gone(plate: Any, name: str) -> None:
    """Nothing names a panel that is gone: its insets get places of their own, and what stood on it alone is off."""
    for panel in plate.panels:
        if panel.inset_of == name:
            panel.inset_of = ""
    for note in plate.annotations:
        index = note.panels.find(name)
        if index >= 0:
            note.panels.remove(index)
            note.enabled = bool(note.enabled and len(note.panels))
