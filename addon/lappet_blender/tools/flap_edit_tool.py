"""Edits a laid flap of the library: an operator for each design, dragged by a handle or filled in a panel.

Without a handle the operator lays the flap anew with the values that it gets. With one it follows the mouse, shows the
plan on the skin, and ends by the same: one step of undo, and its measures in the panel of the last operation.
"""

from typing import Any, ClassVar

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from numpy.typing import ArrayLike

from lappet.checks.narrow_flaps import narrow_flaps
from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.flap_handles import HandledFlap
from lappet.designs.laid_flaps import changed_flap, laid_flap
from lappet.designs.library import DESIGNS
from lappet.designs.library_design import LibraryDesign
from lappet.procedure import FlapLines, LaidFlap, Procedure
from lappet.tissue.skin_sheet import SkinSheet

from ..events.flap_operators import measure_property, turned_about
from ..events.flap_relay import relay_flap, scene_procedure
from ..events.operator_values import given
from ..interface.problem_sentence import problem_sentence
from ..interface.said import said
from ..model.decimals import decimal, decimals
from ..model.laid_flaps import active_flap
from .drawing import DrawnLine, Point
from .preview import Preview, show_preview
from .skin_modal import Result, SkinModal
from .view_under_mouse import View

LINES: dict[str, FlapLines] = {"GIVEN": "", "ALONG": "along", "ACROSS": "across"}
_LINES_OF = {lines: name for name, lines in LINES.items()}
_FROM_PIXELS = 3.0  # the mouse has moved


class _FlapEdit(SkinModal):
    """What the operators share."""

    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}
    edits_procedure = True
    title = "Edit Flap"
    hints = (
        ("MOUSE_MOVE", "Drag along the skin"),
        ("EVENT_RETURN", "Finish"),
        ("EVENT_ESC", "Cancel"),
    )
    design: ClassVar[LibraryDesign]
    flap: str
    handle: str
    at: Any
    lines: str
    direction: Any
    turned: float
    mirrored: bool

    def run(self, context: bpy.types.Context) -> str:
        scene = context.scene
        procedure = scene_procedure(scene)
        laid = laid_flap(procedure, self.flap or active_flap(scene))
        if laid.design != self.design.name:
            raise refused(ProblemCode.DESIGN_UNKNOWN, laid.name, self.design.name, known=laid.design)
        made, lost = relay_flap(scene, procedure, self._wanted(procedure, laid))
        for found in (*lost, *narrow_flaps(made, set())):
            self.report({"WARNING"}, problem_sentence(found))
        return f"{self.design.title}: laid anew."

    def _wanted(self, procedure: Procedure, laid: LaidFlap) -> LaidFlap:
        """The flap with what the operator was given; what was not given it shows from now on."""
        had = dict(laid.measures)
        measures = {each.name: given(self, each.name, had[each.name]) for each in self.design.parameters}
        start = given(self, "time", laid.start)
        self._fill("at", laid.at)
        self._fill("direction", laid.direction)
        self._fill("mirrored", laid.mirrored)
        self._fill("lines", _LINES_OF[laid.lines])
        follows = LINES[self.lines]
        way = laid.direction if tuple(self.direction) == _single(laid.direction) else decimals(self.direction)
        changed = changed_flap(
            procedure,
            laid,
            at=None if tuple(self.at) == _single(laid.at) else decimals(self.at),
            direction=None if follows else way,
            lines=None if follows and follows == laid.lines else follows,
            measures={name: _exact(value, had[name]) for name, value in measures.items()},
            mirrored=self.mirrored,
            start=start,
        )
        if self.turned == 0.0:
            return changed
        normal = SkinSheet.of(procedure.tissue).at(changed.at)[1][0]
        way = turned_about(np.array(changed.direction), normal, self.turned).tolist()
        return changed_flap(procedure, changed, direction=way)

    def _fill(self, name: str, value: Any) -> None:
        if not self.properties.is_property_set(name):
            setattr(self, name, value)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> Result:
        if not self.handle:
            self.flap = self.flap or active_flap(context.scene)
            return self.execute(context)
        self._begun = False
        if not self.attempt(lambda: self._take(context)):
            return {"CANCELLED"}
        return SkinModal.invoke(self, context, event)

    def _take(self, context: bpy.types.Context) -> None:
        procedure = scene_procedure(context.scene)
        self.flap = self.flap or active_flap(context.scene)
        self._before = laid_flap(procedure, self.flap)
        self._handled = HandledFlap(procedure, self._before)
        self._said = ""
        self._pressed_at: tuple[float, float] | None = None

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        if self._pressed_at is None:
            self._pressed_at = view.mouse
            return None
        return self.confirmed(context)

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if view is None:
            return None
        self._pressed_at = self._pressed_at or view.mouse
        away = max(abs(a - b) for a, b in zip(view.mouse, self._pressed_at, strict=True))
        hit = view.pick(context.scene) if self._begun or away > _FROM_PIXELS else None
        if hit is not None:
            self._begun = True
            self.drag(context, hit.rest)
        return None

    def drag(self, context: bpy.types.Context, to: Point) -> None:
        """Drag the handle to a point of the skin at rest, mm, and show the plan there."""
        try:
            self._handled.move(self.handle, to)
            curves = self._handled.curves()
            self._said = _said(self._handled, self.handle)
        except RefusedError as wrong:
            self._said = problem_sentence(wrong.problems[0])
            return
        lines = [
            DrawnLine(tuple((float(x), float(y), float(z)) for x, y, z in curve), "LINEAR", closed)
            for curve, closed in curves
        ]
        show_preview(Preview(context.scene.name, lines=lines, snap=to))

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        return self.confirmed(context)

    def confirmed(self, context: bpy.types.Context) -> Result | None:
        if not self._begun or self._handled.laid == self._before:
            return {"CANCELLED"}
        self.fill(self._handled.laid)
        return self.execute(context)

    def fill(self, laid: LaidFlap) -> None:
        """Take the values of a flap that was dragged as those that the operator is given."""
        self.at, self.direction, self.lines = laid.at, laid.direction, _LINES_OF[laid.lines]
        for name, value in laid.measures:
            setattr(self, name, value)

    def text(self, context: bpy.types.Context) -> str:
        return f"{said(self.design.title)}: {self._said or said('drag the handle along the skin')}"


def _exact(value: float, had: float) -> float:
    """A measure from a property: the one that the flap had where single precision is all that differs."""
    return had if _single([value]) == _single([had]) else decimal(value)


def _single(values: ArrayLike) -> tuple[float, ...]:
    """Values as Blender's properties hold them."""
    return tuple(np.asarray(values, np.float32).astype(np.float64).tolist())


def _said(handled: HandledFlap, name: str) -> str:
    return next(each.says for each in handled.handles() if each.name == name)


_SHOWN: set[str] = {"SKIP_SAVE"}
_HIDDEN = {"HIDDEN", "SKIP_SAVE"}


def _operator(design: LibraryDesign) -> type[bpy.types.Operator]:
    """The operator `lappet.flap_edit_NAME` of a design."""
    fields: dict[str, Any] = {
        "flap": StringProperty(
            name="Flap",
            description="Name of the laid flap; empty = that of the active event",
            options=_HIDDEN,
        ),
        "handle": StringProperty(options=_HIDDEN),
    }
    fields |= {each.name: measure_property(each, options=_SHOWN) for each in design.parameters}
    fields |= {
        "at": FloatVectorProperty(
            name="Place", description=f"In mm: {design.center}", size=3, precision=2, options=_SHOWN
        ),
        "direction": FloatVectorProperty(size=3, options=_HIDDEN),
        "lines": EnumProperty(
            name="Direction",
            description=f"What runs so: {design.direction}",
            items=(
                ("GIVEN", "As It Is", "As it was laid or turned"),
                ("ALONG", "Along Skin Lines", "Along the lines of the skin, also where it is moved to"),
                ("ACROSS", "Across Skin Lines", "Square to the lines of the skin, also where it is moved to"),
            ),
            options=_SHOWN,
        ),
        "turned": FloatProperty(
            name="Turned", description="Turned in the skin by this angle", subtype="ANGLE", options=_SHOWN
        ),
        "mirrored": BoolProperty(name="Mirrored", description="Mirrored about its direction", options=_SHOWN),
        "time": FloatProperty(name="Frame", description="Before the first cut", options=_SHOWN),
    }
    attributes: dict[str, Any] = {
        "__doc__": "Lay the flap anew: moved, turned, mirrored or with other measures. Changes to its events by hand "
        "are lost",
        "__annotations__": fields,
        "bl_label": f"Edit {design.title}",
        "design": design,
    }
    return type(f"LAPPET_OT_flap_edit_{design.name.replace('-', '_')}", (_FlapEdit, bpy.types.Operator), attributes)


def edit_operator(design: str) -> str:
    """The name of the operator that edits a flap of a design."""
    return f"lappet.flap_edit_{design.replace('-', '_')}"


OPERATORS = tuple(_operator(design) for design in DESIGNS.values())
CLASSES = OPERATORS
