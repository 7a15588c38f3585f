"""An operator for each design of the flap library, which adds the whole operation; their menu, and them as pictures."""

from typing import Any, ClassVar

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from numpy.typing import NDArray

from lappet.checks.narrow_flaps import narrow_flaps
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.designs.fitted_design import fit_to_defect, marked_defect, without_drawn
from lappet.designs.laid_design import require_on_skin
from lappet.designs.library import DESIGNS
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.library_operation import add_flap, has_lines, skin_line_direction
from lappet.procedure import FlapLines, Procedure
from lappet.tissue.skin_sheet import SkinSheet

from ..interface.operator_base import OperatorBase
from ..interface.problem_sentence import problem_sentence
from ..model.event_list import find_event, remove_event
from ..model.laid_flaps import active_flap
from ..model.units import to_mm
from .event_check import tissue_of
from .flap_mark import marked_outline_of
from .flap_relay import put_flap, remove_flap, scene_procedure
from .flap_thumbnails import thumbnail
from .operator_values import given

_DIRECTIONS = (
    ("ALONG", "Along Skin Lines", "Along the lines of the skin, or the fibers of its material"),
    ("ACROSS", "Across Skin Lines", "Square to the lines of the skin"),
    ("X", "Scene X", "Along the scene's x axis, as far as the skin has that direction"),
)
_COLUMNS = 5  # of the library


class _FlapAdd(OperatorBase):
    """What all the operators share: where a design lies, how it is turned, and when it is done."""

    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO", "PRESET"}
    edits_procedure = True
    design: LibraryDesign
    at: Any
    lines: str
    fit: bool
    selection: bool
    region: str
    turned: float
    mirrored: bool

    def run(self, context: bpy.types.Context) -> str:
        scene = context.scene
        tissue = tissue_of(scene)
        procedure = scene_procedure(scene)
        outline = _active_name(scene) if self.fit else ""
        drawn = marked_defect(procedure, outline) if self.fit else marked_outline_of(scene, self.selection, self.region)
        at = to_mm(scene, scene.cursor.location) if drawn is None else drawn.mean(axis=0)
        at = np.array(self.at) if self.properties.is_property_set("at") else at
        on_skin, normals = SkinSheet.of(tissue).at(at)
        place = on_skin[0]
        if drawn is None:
            require_on_skin(self.design.name, at, place)
        direction = turned_about(self._direction(procedure, place), normals[0], self.turned)
        measures = {each.name: float(getattr(self, each.name)) for each in self.design.parameters}
        if drawn is not None:
            fitted = fit_to_defect(tissue, self.design.name, drawn, direction, measures, mirrored=self.mirrored)
            place, measures = np.array(fitted.at), fitted.values
        start = given(self, "time", scene.frame_current)
        flap = add_flap(
            procedure,
            self.design.name,
            place,
            direction,
            measures,
            mirrored=self.mirrored,
            start=start,
            lines=self._follows(procedure),
        )
        count = put_flap(scene, procedure, flap)
        if self.fit:
            _take_away(scene, procedure, without_drawn(procedure, outline))
        for found in narrow_flaps(flap, set()):
            self.report({"WARNING"}, problem_sentence(found))
        return f"{self.design.title}: {count} events."

    def _direction(self, procedure: Procedure, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """The direction in mm before it is turned by `turned`."""
        if self.lines == "X":
            return np.array([1.0, 0.0, 0.0])
        try:
            return skin_line_direction(procedure, at, across=self.lines == "ACROSS")
        except RefusedError as refused:
            if self.properties.is_property_set("lines") or refused.problems[0].code != ProblemCode.DESIGN_NO_LINES:
                raise
            return np.array([1.0, 0.0, 0.0])

    def _follows(self, procedure: Procedure) -> FlapLines:
        """How the flap follows the lines of the skin when it is moved: not where it was turned away from them."""
        if self.lines == "X" or self.turned != 0.0 or not has_lines(procedure):
            return ""
        return "across" if self.lines == "ACROSS" else "along"


def _active_name(scene: bpy.types.Scene) -> str:
    events, active = scene.lappet.events, scene.lappet.active_event
    return str(events[active].name) if 0 <= active < len(events) else ""


def _take_away(scene: bpy.types.Scene, procedure: Procedure, left: Procedure) -> None:
    """Remove the events of a procedure that are not left."""
    names = {each.name for each in left.events}
    for each in procedure.events:
        if each.name not in names and (event := find_event(scene, each.name)) is not None:
            remove_event(scene, event)


def turned_about(direction: NDArray[np.float64], normal: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """A direction turned about a normal (radians, counter-clockwise)."""
    return np.cos(angle) * direction + np.sin(angle) * np.cross(normal, direction)


def measure_property(parameter: Parameter, **settings: Any) -> Any:
    """A property of an operator for a measure of a design."""
    return FloatProperty(
        name=parameter.name.replace("_", " ").title(),
        description=f"{parameter.meaning[:1].upper()}{parameter.meaning[1:]}{_unit(parameter)}; {parameter.range_text}",
        default=parameter.default,
        min=parameter.least,
        max=parameter.most,
        precision=2,
        **settings,
    )


def _unit(parameter: Parameter) -> str:
    return {"mm": " in mm", "°": " in degrees"}.get(parameter.unit, "")


def _operator(design: LibraryDesign) -> type[bpy.types.Operator]:
    """The operator `lappet.flap_NAME` of a design."""
    fields: dict[str, Any] = {each.name: measure_property(each) for each in design.parameters}
    here: Any = {"SKIP_PRESET"}  # one's own presets keep the measures: where, which way and when is each flap's own
    fields |= {
        "at": FloatVectorProperty(
            name="Place",
            description=f"In mm: {design.center}; if not given, the 3D cursor",
            size=3,
            precision=2,
            options=here,
        ),
        "lines": EnumProperty(
            name="Direction",
            description=f"What runs so: {design.direction}",
            items=_DIRECTIONS,
            default="ACROSS" if design.lines == "across" else "ALONG",
            options={"SKIP_SAVE"},  # of choices Blender offers no other way to keep them out of presets
        ),
        "turned": FloatProperty(
            name="Turned", description="Turned in the skin by this angle", subtype="ANGLE", options=here
        ),
        "fit": BoolProperty(
            name="Fit to Active Outline",
            description="Lie where the closed incision or landmark is that is active in the timeline, as large as that",
            options=here,
        ),
        "selection": BoolProperty(
            name="Fit to Selection",
            description="Lie where the selected faces of the tissue are, as large as these",
            options=here,
        ),
        "region": StringProperty(
            name="Fit to Region",
            description="Lie where a vertex group, a face group or a face attribute of the tissue is, as large as it",
            options=here,
        ),
        "mirrored": BoolProperty(name="Mirrored", description="Mirrored about its direction"),
        "time": FloatProperty(
            name="Frame", description="Before the first cut; if not given, the current frame", options=here
        ),
    }
    attributes: dict[str, Any] = {
        "__doc__": design.indication.rstrip("."),
        "__annotations__": fields,
        "bl_label": design.title,
    }
    attributes["design"] = design
    return type(f"LAPPET_OT_flap_{design.name.replace('-', '_')}", (_FlapAdd, bpy.types.Operator), attributes)


class LAPPET_OT_flap_remove(OperatorBase, bpy.types.Operator):
    """Remove all events of the flap that the active event belongs to"""

    bl_label = "Remove Flap"
    edits_procedure = True

    flap: StringProperty(name="Flap", description="Name of the laid flap", options={"HIDDEN", "SKIP_SAVE"})

    def run(self, context: bpy.types.Context) -> str:
        scene = context.scene
        name = self.flap or active_flap(scene)
        count = remove_flap(scene, name)
        return f"{name}: {count} events removed."


class VIEW3D_MT_lappet_flap(bpy.types.Menu):
    bl_label = "Flap"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.operator_context = "EXEC_DEFAULT"
        for operator in OPERATORS:
            self.layout.operator(operator.bl_idname, icon_value=thumbnail(operator.design.name))


class VIEW3D_PT_lappet_flaps(bpy.types.Panel):
    """The flap library as pictures; opened from the timeline."""

    bl_label = "Flap Library"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_ui_units_x = 34

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.label(text="At the 3D cursor, from the current frame on; F9 changes its measures.")
        grid = layout.grid_flow(row_major=True, columns=_COLUMNS, even_columns=True, even_rows=True, align=False)
        grid.operator_context = "EXEC_DEFAULT"
        for operator in OPERATORS:
            cell = grid.column(align=True)
            cell.template_icon(icon_value=thumbnail(operator.design.name), scale=4.5)
            cell.operator(operator.bl_idname, text=operator.design.title)
        layout.operator("lappet.flap_assets", icon="ASSET_MANAGER")


OPERATORS = tuple(_operator(design) for design in DESIGNS.values())
CLASSES = (*OPERATORS, LAPPET_OT_flap_remove, VIEW3D_MT_lappet_flap, VIEW3D_PT_lappet_flaps)
