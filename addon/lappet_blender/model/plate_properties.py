"""Property groups of plates, in `scene.lappet.pages`: pages for print with their panels and annotations.

A plate changes no frame: nothing here tells the solving side of a change.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)

from lappet.drawing.skin_source import SCALARS
from lappet.procedure.plate import (
    ANNOTATION_ANCHORS,
    JOURNALS,
    PLAN_PENS,
    PLATE_MARKS,
    PLATE_STYLES,
    PLATE_VIEWS,
    Plate,
)

from .event_properties import LappetPoint
from .plate_names import is_shown, rename, set_shown

LANGUAGES = ("en", "de", "fr", "es", "zh")
_STEPS = (
    ("plan", "Plan", "What is planned"),
    ("cut", "Cut", "After the cuts"),
    ("raised", "Raised", "Where hooked tissue is highest"),
    ("placed", "Placed", "Before hooks let go or all sutures hold"),
    ("sutured", "Sutured", "When the last suture is closed"),
    ("result", "Result", "The last frame"),
)
STEPS = (*_STEPS, ("FRAME", "Frame", "A frame of your choice"))
GHOSTS = (("NONE", "None", "Nothing is drawn through it"), *_STEPS)
VIEWS = tuple((view, view.capitalize(), "") for view in PLATE_VIEWS)
PANEL_VIEWS = (
    ("PLATE", "As the Plate", "From where the plate is seen"),
    *VIEWS,
    ("OWN", "Own", "A camera of its own, taken from the view"),
)
STYLES = tuple((style, style.capitalize(), "") for style in PLATE_STYLES)
QUANTITIES = (("NONE", "None", "Nothing is mapped"), *((name, name.capitalize(), "") for name in SCALARS))
JOURNAL_ITEMS = (("NONE", "None", "No publisher's rules"), *((name, name.capitalize(), "") for name in JOURNALS))
MARKS = tuple((name or "NONE", (name or "none").capitalize(), "") for name in PLATE_MARKS)
PENS = tuple((name or "WHOLE", (name or "whole").capitalize(), "") for name in PLAN_PENS)
KINDS = tuple((kind, kind.capitalize(), "") for kind in ANNOTATION_ANCHORS)
EXCISED = (
    ("leave-out", "Leave Out", "It is left out where its tissue is gone"),
    ("last-place", "Last Place", "It stays where its tissue was last"),
)


def _title() -> Any:
    return StringProperty(
        name="Name",
        description="Letters, digits and underscores",
        get=lambda self: str(self.name),
        set=rename,
        options={"SKIP_SAVE"},
    )


def _language(_owner: Any, _context: Any, _typed: str) -> tuple[str, ...]:
    return LANGUAGES


class LappetPlateName(bpy.types.PropertyGroup):
    """A name in a list; `name` is PropertyGroup's own."""


class LappetPlatePanel(bpy.types.PropertyGroup):
    """A panel of a plate (`lappet.procedure.plate.PlatePanel`)."""

    title: _title()
    step: EnumProperty(name="Step", description="What it shows", items=STEPS, default="plan")
    time: FloatProperty(name="Frame", default=1.0, precision=2)
    caption: StringProperty(name="Caption", description="Empty: the text of the catalog")
    view: EnumProperty(name="Camera", description="Where the camera is", items=PANEL_VIEWS, default="PLATE")
    look_from: FloatVectorProperty(name="From", description="From the tissue to the camera", default=(0.0, 0.0, 1.0))
    look_up: FloatVectorProperty(name="Up", description="What is up in the picture", default=(0.0, 1.0, 0.0))
    cropped: BoolProperty(name="Crop", description="Show what lies about a place, seen with a longer lens")
    at: FloatVectorProperty(name="About", description="A place on the skin at rest, mm", precision=3)
    across: FloatProperty(name="Across", description="Tissue across the panel, mm", default=40.0, min=2.0)
    inset_of: StringProperty(name="Inset of", description="The panel in whose corner it stands; empty: its own place")
    ghost: EnumProperty(name="Ghost", description="A step whose outlines are drawn through", items=GHOSTS)
    ghost_filled: BoolProperty(name="Filled", description="What the ghost's cuts lay open is filled, translucent")
    sectioned: BoolProperty(name="Section", description="Show a cross-section at a plane of its own")
    section_at: FloatVectorProperty(name="At", description="A point of the plane, mm", precision=3)
    section_normal: FloatVectorProperty(name="Normal", default=(1.0, 0.0, 0.0))


class LappetAnnotation(bpy.types.PropertyGroup):
    """An annotation of a plate (`lappet.procedure.plate.PlateAnnotation`)."""

    title: _title()
    enabled: BoolProperty(name="Enabled", description="Part of the plate", default=True)
    shown: BoolProperty(
        name="Shown", description="Stands on the chosen panel", get=is_shown, set=set_shown, options={"SKIP_SAVE"}
    )
    kind: EnumProperty(name="Kind", items=KINDS)
    text: StringProperty(name="Text", description="Empty: a measure says its value, a label its name")
    anchors: CollectionProperty(type=LappetPoint)
    panels: CollectionProperty(type=LappetPlateName)
    placed: BoolProperty(name="Placed", description="It stands where it was put; otherwise a place is found")
    offset: FloatVectorProperty(
        name="Offset", description="From its first anchor on paper, mm to the right and down", size=2, precision=1
    )
    when_excised: EnumProperty(name="Excised", description="What happens where its tissue is gone", items=EXCISED)


class LappetPlate(bpy.types.PropertyGroup):
    """A page for print (`lappet.procedure.plate.Plate`)."""

    title: _title()
    style: EnumProperty(name="Style", description="How it is drawn", items=STYLES, default=Plate.style)
    tone: IntProperty(name="Skin Tone", description="On the Monk scale, 1 to 10; 0: the style's own", min=0, max=10)
    width: FloatProperty(name="Width", description="In print, mm", default=Plate.width, min=1.0, precision=1)
    columns: IntProperty(name="Columns", description="Panels in a row; 0: as many as fit", min=0, max=12)
    language: StringProperty(name="Language", description="en, de, fr, es or zh", default="en", search=_language)
    view: EnumProperty(name="Camera", description="Where the camera is", items=VIEWS, default=Plate.view)
    quantity: EnumProperty(name="Map", description="A quantity of the skin, mapped in color", items=QUANTITIES)
    sectioned: BoolProperty(name="Section", description="Show a cross-section in every panel but the plan")
    section_at: FloatVectorProperty(name="At", description="A point of the plane, mm", precision=3)
    section_normal: FloatVectorProperty(name="Normal", default=(1.0, 0.0, 0.0))
    labels: BoolProperty(name="Labels", description="Names with leaders", default=True)
    letters: BoolProperty(name="Letters", description="Letters at the corners of cuts", default=True)
    arrows: BoolProperty(name="Arrows", description="Ways of the flaps", default=True)
    measures: BoolProperty(name="Measures", description="Lengths and angles of the plan", default=True)
    instruments: BoolProperty(name="Instruments", description="Hooks", default=True)
    landmarks: CollectionProperty(type=LappetPlateName)
    text: FloatProperty(name="Text", description="Points; 0: 7, or the journal's least", min=0.0, max=24.0, precision=1)
    journal: EnumProperty(name="Publisher", description="Whose rules the plate keeps", items=JOURNAL_ITEMS)
    marks: EnumProperty(name="Marks", description="What is printed on the skin", items=MARKS)
    marks_spacing: FloatProperty(
        name="Apart", description="Distance of the marks at rest, mm", default=Plate.marks_spacing, min=1.0, max=50.0
    )
    skin_lines: BoolProperty(name="Skin Lines", description="The skin lines of the procedure")
    plan_pen: EnumProperty(name="Plan", description="How planned cuts are drawn", items=PENS)
    hatched: BoolProperty(name="Hatched", description="The area undermined is hatched", default=True)
    panels: CollectionProperty(type=LappetPlatePanel)
    active_panel: IntProperty(name="Panel")
    annotations: CollectionProperty(type=LappetAnnotation)
    active_annotation: IntProperty(name="Annotation")


CLASSES = (LappetPlateName, LappetPlatePanel, LappetAnnotation, LappetPlate)
