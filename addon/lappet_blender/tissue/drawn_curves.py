"""What was drawn with Blender's own curves, as courses in mm: lines of the skin, vessels."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import bpy
import numpy as np
from mathutils.geometry import interpolate_bezier
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Point

from ..model.tissue_values import identifier
from ..model.world_matrix import object_to_mm
from .tissue_objects import named_object

# A freehand stroke has a knot every few pixels, and each knot's ends a curve between them.
_SAMPLES, _MOST_POINTS = 6, 40


@dataclass(frozen=True)
class DrawnCurve:
    """A spline of a curve object. name: one that no prim has yet. points: along it in mm of the world."""

    name: str
    points: tuple[Point, ...]


def drawn_curves(context: bpy.types.Context, name: str, taken: set[str]) -> list[DrawnCurve]:
    """The splines of the named curve, or of the selected ones.

    taken: names that others have already; those that are given here are added. Raises RefusedError where the object is
    no curve, none is selected, or one has no spline of two points.
    """
    scene, found = context.scene, []
    for obj in _objects(context, name):
        matrix = object_to_mm(scene, obj)
        splines = _splines(obj)
        if not splines:
            raise refused(ProblemCode.CURVE_EMPTY, obj.name)
        for points in splines:
            fresh = identifier(obj.name, taken)
            taken.add(fresh)
            placed = points @ matrix[:3, :3].T + matrix[:3, 3]
            found.append(DrawnCurve(fresh, tuple((float(x), float(y), float(z)) for x, y, z in placed)))
    return found


def _objects(context: bpy.types.Context, name: str) -> list[bpy.types.Object]:
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
