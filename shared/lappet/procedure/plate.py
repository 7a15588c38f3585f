"""Plates of a procedure: pages for print, with panels and with annotations that are anchored to the tissue.

They are drawn, not solved: no plate changes a frame or its key.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from lappet.procedure.exact_values import Point, double_point, set_fields, single_points

PlateStyleName = Literal["ink", "schematic", "halftone", "wash", "painted"]
PlateView = Literal["oblique", "top", "low"]
PlateMarks = Literal["", "grid", "squares", "dots"]
PlanPen = Literal["", "dashed", "dotted", "marker"]
PanelStep = Literal["", "plan", "cut", "raised", "placed", "sutured", "result"]
AnnotationKind = Literal["label", "length", "distance", "width", "depth", "angle", "arrow", "pivot"]
WhenExcised = Literal["leave-out", "last-place"]

PLATE_STYLES: tuple[PlateStyleName, ...] = get_args(PlateStyleName)
JOURNALS = ("springer", "elsevier", "plos")
PLATE_MARKS: tuple[PlateMarks, ...] = get_args(PlateMarks)
PLAN_PENS: tuple[PlanPen, ...] = get_args(PlanPen)
PLATE_VIEWS: tuple[PlateView, ...] = get_args(PlateView)
PANEL_STEPS: tuple[PanelStep, ...] = get_args(PanelStep)
# Kinds of annotations and how many anchors each has, at least and at most.
ANNOTATION_ANCHORS: dict[AnnotationKind, tuple[int, int]] = {
    "label": (1, 1),
    "length": (2, 64),
    "distance": (2, 2),
    "width": (2, 2),
    "depth": (1, 1),
    "angle": (3, 3),
    "arrow": (1, 2),
    "pivot": (1, 1),
}


@dataclass(frozen=True)
class PlateAnnotation:
    """A text, measure or arrow anchored to material points of the tissue (`LappetAnnotationAPI`).

    Parameters
    ----------
    name
        Its name, unique among the plate's annotations.
    kind
        "label": a text with a leader. "length": a length along the skin through the anchors; "distance": the straight
        distance of two; "width": the same, drawn beside them with two arrows; "depth": from a point of the skin to the
        underside, in cross-sections. "angle": the angle at the second of three. "arrow": the way of an anchor from the
        panel to the next one, or from one anchor to another. "pivot": the point about which a flap turns.
    anchors
        Points on the skin at rest in mm; each is followed through the frames.
    text
        What it says; a measure without a text says its value in the frame.
    panels
        Names of the panels on which it stands; none: on each on which all of its anchors are seen.
    offset
        Of the text from the first anchor on paper in mm, to the right and down: of a label the end of its leader, of
        others the text's middle. None: the program finds a place.
    when_excised
        What happens to it on panels on which the tissue of an anchor is gone.
    """

    name: str
    kind: AnnotationKind
    anchors: tuple[Point, ...]
    text: str = ""
    panels: tuple[str, ...] = ()
    offset: tuple[float, float] | None = None
    when_excised: WhenExcised = "leave-out"

    def __post_init__(self) -> None:
        offset = None if self.offset is None else (float(self.offset[0]) + 0.0, float(self.offset[1]) + 0.0)
        set_fields(self, anchors=single_points(self.anchors), panels=tuple(self.panels), offset=offset)


@dataclass(frozen=True)
class PlatePanel:
    """A panel of a plate (`LappetPanelAPI`).

    Parameters
    ----------
    name
        Its name, unique among the plate's panels.
    step
        The step of the operation that it shows, "" for the frame at `time`. A step that the operation does not have is
        left out.
    time
        Time code of its frame where there is no step.
    caption
        What stands below it; "": the catalogue's text.
    view
        Where the camera is; "": as on the plate.
    at
        A point on the skin at rest in mm about which it is cropped; None: all of the operation is shown.
    across
        How much tissue is seen across a cropped panel, mm.
    inset_of
        Name of the panel in whose corner it stands, "" for a place of its own.
    ghost
        The step whose outlines are drawn through, "" for none.
    look_from, look_up
        The direction from the tissue to a camera of its own, and which way is up in the picture; None: as `view` says.
    section_at, section_normal
        The plane in which the panel is cut, whatever the plate's is: a point at rest in mm and a normal; None: as the
        plate says.
    ghost_filled
        Whether what the ghost's cuts lay open, or its plan encloses, is filled as well, translucent.
    """

    name: str
    step: PanelStep = ""
    time: float = 0.0
    caption: str = ""
    view: PlateView | Literal[""] = ""
    at: Point | None = None
    across: float = 0.0
    inset_of: str = ""
    ghost: PanelStep = ""
    look_from: Point | None = None
    look_up: Point | None = None
    section_at: Point | None = None
    section_normal: Point | None = None
    ghost_filled: bool = False

    def __post_init__(self) -> None:
        names = ("at", "look_from", "look_up", "section_at", "section_normal")
        points = {name: getattr(self, name) for name in names}
        doubles = {name: None if each is None else double_point(each) for name, each in points.items()}
        set_fields(self, time=float(self.time) + 0.0, across=float(self.across) + 0.0, **doubles)

    @property
    def section(self) -> tuple[float, ...] | None:
        """The plane as a point in mm and a normal; None where it is the plate's."""
        if self.section_at is None or self.section_normal is None:
            return None
        return (*self.section_at, *self.section_normal)


@dataclass(frozen=True)
class Plate:
    """A page of drawings of a procedure (`LappetPlateAPI`).

    Parameters
    ----------
    name
        Its name, unique among the procedure's plates.
    style
        How it is drawn.
    tone
        Tone of the skin on the Monk scale, 1 to 10; 0 for the style's own.
    width
        Its width in print, mm.
    columns
        Panels in a row; 0: as many as fit.
    language
        Code of its language, such as "en".
    view
        Where the camera is.
    quantity
        A quantity of the skin that is mapped in color: "tension", "strain", "stress", or "" for none.
    section_at, section_normal
        The plane in which every panel but the plan is cut: a point at rest in mm and a normal; None for no section.
    labels, letters, arrows, measures, instruments
        Whether there are the program's own labels, letters at corners, ways of flaps, lengths and angles, and hooks.
    landmarks
        Labels of the landmarks that are named.
    panels
        Its panels; none: the steps of the operation.
    annotations
        What is written and drawn on it besides.
    text
        Size of labels in points; 0: 7, or the least that the journal prints.
    journal
        The publisher whose rules it keeps, such as "plos", or "".
    marks
        What is printed on the skin: "grid", "squares", "dots", or "" for nothing.
    marks_spacing
        Distance of the marks at rest in mm.
    skin_lines
        Whether the procedure's skin lines are drawn.
    plan_pen
        How planned cuts are drawn: whole lines (""), "dashed", "dotted", or broad as by a "marker" pen.
    hatched
        Whether the area undermined is hatched.
    """

    name: str
    style: PlateStyleName = "schematic"
    tone: int = 0
    width: float = 174.0
    columns: int = 0
    language: str = "en"
    view: PlateView = "oblique"
    quantity: str = ""
    section_at: Point | None = None
    section_normal: Point | None = None
    labels: bool = True
    letters: bool = True
    arrows: bool = True
    measures: bool = True
    instruments: bool = True
    landmarks: tuple[str, ...] = ()
    panels: tuple[PlatePanel, ...] = ()
    annotations: tuple[PlateAnnotation, ...] = ()
    text: float = 0.0
    journal: str = ""
    marks: PlateMarks = ""
    marks_spacing: float = 5.0
    skin_lines: bool = False
    plan_pen: PlanPen = ""
    hatched: bool = True

    def __post_init__(self) -> None:
        set_fields(
            self,
            width=float(self.width),
            text=float(self.text) + 0.0,
            marks_spacing=float(self.marks_spacing),
            section_at=None if self.section_at is None else double_point(self.section_at),
            section_normal=None if self.section_normal is None else double_point(self.section_normal),
            landmarks=tuple(self.landmarks),
            panels=tuple(self.panels),
            annotations=tuple(self.annotations),
        )
