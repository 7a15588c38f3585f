"""Meshes to make tissue of, in scenes whose unit is the metre."""

from __future__ import annotations

import itertools

import bpy
import numpy as np

from lappet.procedure import Procedure, Tissue
from lappet.tissue.patch import flat_patch
from lappet_blender.model.scene_procedure import fill_scene, read_scene

SIZE = (20.0, 16.0, 4.0)


def add_mesh(scene: bpy.types.Scene, name: str, places: list, faces: list) -> bpy.types.Object:
    """A mesh object that is selected and active."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(places, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def add_sheet(scene: bpy.types.Scene, cells: int = 8, height: float = 0.0, name: str = "skin") -> bpy.types.Object:
    """An open square of quadrilaterals, 20 mm wide, in the middle of the world; height: mm of a bump."""
    axis = np.linspace(-0.01, 0.01, cells + 1)
    places = [(x, y, 0.001 * height * np.exp(-(x * x + y * y) / 5e-5)) for x, y in itertools.product(axis, axis)]
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, -1)
    faces = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(-1, 4)
    return add_mesh(scene, name, places, faces.tolist())


def add_box(
    scene: bpy.types.Scene, low: tuple = (0.0, 0.0, 0.0), high: tuple = (0.02, 0.016, 0.004), name: str = "block"
) -> bpy.types.Object:
    """A closed box, m: faces bottom, top, front, right, back, left."""
    places = [[(low, high)[k][axis] for axis, k in enumerate(corner)] for corner in itertools.product((0, 1), repeat=3)]
    faces = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [4, 6, 7, 5], [6, 2, 3, 7], [2, 0, 1, 3]]
    return add_mesh(scene, name, places, faces)


def fill_with_patch(scene: bpy.types.Scene, tissue: Tissue | None = None) -> Procedure:
    """A flat patch as the scene's tissue; returns the procedure that filled it."""
    procedure = Procedure(tissue or flat_patch(SIZE, 2.0), end_time=10.0)
    fill_scene(scene, procedure, scene.collection)
    bpy.context.view_layer.objects.active = scene.lappet.tissue.object
    return procedure


def read(scene: bpy.types.Scene) -> Procedure:
    """The scene's procedure, which nothing may stand in the way of."""
    reading = read_scene(scene)
    assert reading.problems == ()
    assert reading.procedure is not None
    return reading.procedure


def add_curve(scene: bpy.types.Scene, kind: str, points: list[tuple[float, float, float]]) -> bpy.types.Object:
    """A curve object with a spline through points in mm, selected."""
    data = bpy.data.curves.new("crease", "CURVE")
    data.dimensions = "3D"
    if points:
        spline = data.splines.new(kind)
        row = spline.bezier_points if kind == "BEZIER" else spline.points
        row.add(len(points) - 1)
        for knot, point in zip(row, points, strict=True):
            place = [0.001 * value for value in point]
            if kind == "BEZIER":
                knot.co = place
                knot.handle_left_type = knot.handle_right_type = "VECTOR"
            else:
                knot.co = (*place, 1.0)
    obj = bpy.data.objects.new("crease", data)
    scene.collection.objects.link(obj)
    obj.select_set(True)
    return obj
