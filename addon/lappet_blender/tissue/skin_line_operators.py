"""Operators on the lines of the skin, which are drawn with Blender's own curves."""

from __future__ import annotations

from itertools import pairwise

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatVectorProperty, StringProperty
from mathutils.geometry import interpolate_bezier
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import SkinLine

from ..model.skin_line_values import set_skin_line
from ..model.tissue_values import identifier
from ..model.world_matrix import object_to_mm
from .tissue_objects import named_object
from .tissue_operator import OnTissue

TENSION = (20.0, 10.0)  # kPa along and across, as of the face's skin
# A freehand stroke has a knot every few pixels, and each knot's ends a curve between them.
_SAMPLES, _MOST_POINTS = 6, 40


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
        found: list[SkinLine] = []
        for obj in _curves(context, self.object):
            matrix = object_to_mm(scene, obj)
            splines = _splines(obj)
            if not splines:
                raise refused(ProblemCode.CURVE_EMPTY, obj.name)
            for points in splines:
                name = identifier(obj.name, taken)
                taken.add(name)
                placed = points @ matrix[:3, :3].T + matrix[:3, 3]
                found.append(SkinLine(name, tuple(map(tuple, placed)), tension))
        for line in found:
            set_skin_line(lines.add(), line)


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


def _curves(context: bpy.types.Context, name: str) -> list[bpy.types.Object]:
    """The named object or the selected curves. Raises RefusedError where it is no curve, or none is selected."""
    if not name:
        curves = [obj for obj in context.view_layer.objects.selected if obj.type == "CURVE"]
        if curves:
            return sorted(curves, key=lambda obj: obj.name)
    obj = named_object(context, name)
    if obj.type != "CURVE":
        raise refused(ProblemCode.OBJECT_NOT_A_CURVE, obj.name, obj.type.lower())
    return [obj]


def _splines(obj: bpy.types.Object) -> list[NDArray[np.float64]]:
    """The points (n, 3) along each spline of a curve with at least two, in its own coordinates."""
    found = []
    for spline in obj.data.splines:
        if spline.type == "BEZIER":
            points = _bezier(spline)
        else:
            points = np.array([point.co[:3] for point in spline.points], np.float64).reshape(-1, 3)
        if len(points) > 1:
            kept = np.linspace(0, len(points) - 1, min(len(points), _MOST_POINTS)).round().astype(int)
            found.append(points[kept])
    return found


def _bezier(spline: bpy.types.Spline) -> NDArray[np.float64]:
    knots = spline.bezier_points
    parts = [np.array([knot.co for knot in knots[:1]], np.float64).reshape(-1, 3)]
    for one, two in pairwise(knots):
        curve = interpolate_bezier(one.co, one.handle_right, two.handle_left, two.co, _SAMPLES + 1)
        parts.append(np.array(curve[1:], np.float64))
    return np.concatenate(parts)


CLASSES = (LAPPET_OT_skin_lines_add, LAPPET_OT_skin_line_remove)
