"""Plates of a scene as values of the procedure, and the other way round."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from typing import Any

import bpy

from lappet.core.array_codec import CodecError
from lappet.core.value_codec import unpack
from lappet.procedure import Plate, PlateAnnotation, PlatePanel
from lappet.procedure.plate import JOURNALS

from .decimals import decimal, decimals

_FLAGS = ("labels", "letters", "arrows", "measures", "instruments", "skin_lines", "hatched")
_MOST_TONE, _MOST_COLUMNS = 10, 12


@dataclass(frozen=True)
class KeptPlates:
    """The plates as version 1 of the properties kept them."""

    plates: tuple[Plate, ...] = ()


def plates_from_version_1(scene: bpy.types.Scene) -> None:
    """Make plates that version 1 kept as a text properties; those that cannot be read are dropped."""
    text, scene.lappet.plates = str(scene.lappet.plates), ""
    if not text:
        return
    try:
        kept: KeptPlates = unpack(base64.b64decode(text, validate=True), KeptPlates)
    except (CodecError, binascii.Error, ValueError):
        return
    keep_plates(scene, kept.plates)


def keep_plates(scene: bpy.types.Scene, plates: tuple[Plate, ...]) -> None:
    """Give the scene plates in place of those that it had."""
    scene.lappet.pages.clear()
    for plate in plates:
        set_plate(scene.lappet.pages.add(), plate)
    scene.lappet.active_page = 0


def plate_values(scene: bpy.types.Scene) -> tuple[Plate, ...]:
    """The scene's plates."""
    return tuple(plate_value(each) for each in scene.lappet.pages)


def plate_value(each: Any) -> Plate:
    """A plate; annotations that are off, or have no anchor, are left out."""
    return Plate(
        str(each.name),
        each.style,
        int(each.tone),
        decimal(each.width),
        int(each.columns),
        str(each.language),
        each.view,
        "" if each.quantity == "NONE" else str(each.quantity),
        _point(each.section_at) if each.sectioned else None,
        _point(each.section_normal) if each.sectioned else None,
        labels=bool(each.labels),
        letters=bool(each.letters),
        arrows=bool(each.arrows),
        measures=bool(each.measures),
        instruments=bool(each.instruments),
        landmarks=tuple(str(label.name) for label in each.landmarks),
        panels=tuple(map(panel_value, each.panels)),
        annotations=tuple(annotation_value(note) for note in each.annotations if note.enabled and len(note.anchors)),
        text=decimal(each.text),
        journal="" if each.journal == "NONE" else str(each.journal),
        marks="" if each.marks == "NONE" else each.marks,
        marks_spacing=decimal(each.marks_spacing),
        skin_lines=bool(each.skin_lines),
        plan_pen="" if each.plan_pen == "WHOLE" else each.plan_pen,
        hatched=bool(each.hatched),
    )


def panel_value(each: Any) -> PlatePanel:
    """A panel."""
    own, timed = each.view == "OWN", each.step == "FRAME"
    return PlatePanel(
        str(each.name),
        "" if timed else each.step,
        decimal(each.time) if timed else 0.0,
        str(each.caption),
        "" if each.view in ("PLATE", "OWN") else each.view,
        _point(each.at) if each.cropped else None,
        decimal(each.across) if each.cropped else 0.0,
        str(each.inset_of),
        "" if each.ghost == "NONE" else each.ghost,
        _point(each.look_from) if own else None,
        _point(each.look_up) if own else None,
        _point(each.section_at) if each.sectioned else None,
        _point(each.section_normal) if each.sectioned else None,
        bool(each.ghost_filled),
    )


def annotation_value(note: Any) -> PlateAnnotation:
    """An annotation."""
    x, y = decimals(note.offset)
    return PlateAnnotation(
        str(note.name),
        note.kind,
        tuple(_point(anchor.co) for anchor in note.anchors),
        str(note.text),
        tuple(str(panel.name) for panel in note.panels),
        (x, y) if note.placed else None,
        note.when_excised,
    )


def set_plate(each: Any, plate: Plate) -> None:
    """Fill the properties of a new plate."""
    each.name, each.style, each.view, each.language = plate.name, plate.style, plate.view, plate.language
    each.tone = min(max(plate.tone, 0), _MOST_TONE)
    each.columns = min(max(plate.columns, 0), _MOST_COLUMNS)
    each.width = plate.width
    each.quantity = plate.quantity or "NONE"
    if plate.section_at is not None and plate.section_normal is not None:
        each.sectioned, each.section_at, each.section_normal = True, plate.section_at, plate.section_normal
    for name in _FLAGS:
        setattr(each, name, getattr(plate, name))
    each.text, each.marks_spacing, each.marks = plate.text, plate.marks_spacing, plate.marks or "NONE"
    each.plan_pen = plate.plan_pen or "WHOLE"
    each.journal = plate.journal if plate.journal in JOURNALS else "NONE"
    for label in plate.landmarks:
        each.landmarks.add().name = label
    for panel in plate.panels:
        set_panel(each.panels.add(), panel)
    for note in plate.annotations:
        set_annotation(each.annotations.add(), note)


def set_panel(each: Any, panel: PlatePanel) -> None:
    """Fill the properties of a new panel."""
    each.name, each.caption, each.inset_of = panel.name, panel.caption, panel.inset_of
    each.step, each.ghost, each.view = panel.step or "FRAME", panel.ghost or "NONE", panel.view or "PLATE"
    each.time, each.ghost_filled = panel.time, panel.ghost_filled
    if panel.look_from is not None and panel.look_up is not None:
        each.view, each.look_from, each.look_up = "OWN", panel.look_from, panel.look_up
    if panel.at is not None:
        each.cropped, each.at, each.across = True, panel.at, panel.across
    if panel.section_at is not None and panel.section_normal is not None:
        each.sectioned, each.section_at, each.section_normal = True, panel.section_at, panel.section_normal


def set_annotation(each: Any, note: PlateAnnotation) -> None:
    """Fill the properties of a new annotation."""
    each.name, each.kind, each.text, each.when_excised = note.name, note.kind, note.text, note.when_excised
    for anchor in note.anchors:
        each.anchors.add().co = anchor
    for panel in note.panels:
        each.panels.add().name = panel
    if note.offset is not None:
        each.placed, each.offset = True, note.offset


def _point(values: Any) -> tuple[float, float, float]:
    x, y, z = decimals(values)
    return (x, y, z)
