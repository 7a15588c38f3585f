"""Operators on the lines of the skin, which are drawn with Blender's own curves."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, FloatVectorProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import SkinLine

from ..model.skin_line_values import set_skin_line
from .drawn_curves import drawn_curves
from .tissue_operator import OnTissue

TENSION = (20.0, 10.0)  # kPa along and across, as of the face's skin


class LAPPET_OT_skin_lines_add(OnTissue, bpy.types.Operator):
    """Let the fibers of the skin run along curves that were drawn on it"""

    bl_label = "Skin Lines from Curves"

    object: StringProperty(name="Object", description="Name of the curve; empty = the selected curves")
    use_tension: BoolProperty(name="Tension", description="Give the tension in vivo", default=False)
    tension: FloatVectorProperty(
        name="Tension", description="In vivo, along and across the line, kPa", size=2, default=TENSION, min=0.0
    )

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        lines = scene.lappet.skin_lines
        taken = {line.name for line in lines}
        tension = tuple(self.tension) if self.use_tension else None
        for drawn in drawn_curves(context, self.object, taken):
            set_skin_line(lines.add(), SkinLine(drawn.name, drawn.points, tension))


class LAPPET_OT_skin_line_remove(OnTissue, bpy.types.Operator):
    """Remove a line of the skin; a curve that it was drawn as stays"""

    bl_label = "Remove Skin Line"

    name: StringProperty(name="Name")

    def run(self, context: bpy.types.Context) -> None:
        lines = context.scene.lappet.skin_lines
        index = lines.find(self.name)
        if index < 0:
            known = ", ".join(line.name for line in lines) or "none"
            raise refused(ProblemCode.SKIN_LINE_UNKNOWN, "", self.name, known=known)
        lines.remove(index)


CLASSES = (LAPPET_OT_skin_lines_add, LAPPET_OT_skin_line_remove)
