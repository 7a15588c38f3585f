"""What a new file of the template holds: a patch of skin, a Z-plasty on it, a camera, lights, room for the strips."""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Matrix, Vector

from lappet.designs.library_operation import add_flap
from lappet.models.new_model import new_model
from lappet.procedure import Procedure

from ..model.scene_filling import fill_scene
from ..model.units import mm_per_unit
from ..strips.scene_strips import scene_strips
from ..strips.step_names import proposed_steps
from ..strips.strip_operators import set_markers

WORKSPACE = "Lappet"
MODEL, FLAP = "patch", "z-plasty"
_START = 5.0  # frame of the first cut: until then the plan is seen
_FILL = 1.15  # how much more than the field the camera sees
_TIMELINE = 230  # pixels of the Timeline at a scale of 1


def first_procedure() -> Procedure:
    """The procedure of a new file: the flat patch with a Z-plasty of the library."""
    patch = new_model(MODEL)
    middle = 0.5 * (patch.tissue.points.min(axis=0) + patch.tissue.points.max(axis=0))
    middle[2] = patch.tissue.points[:, 2].max()
    at = (float(middle[0]), float(middle[1]), float(middle[2]))
    return add_flap(patch, FLAP, at, np.array([1.0, 0.0, 0.0]), {}, start=_START)


def begin() -> None:
    """Fill the file that was just made: the scene at once, the windows when they are there."""
    fill_first_scene(bpy.context.scene or bpy.data.scenes[0])
    if not bpy.app.background:
        bpy.app.timers.register(_arrange, first_interval=0.1)


def fill_first_scene(scene: bpy.types.Scene) -> None:
    """Give a scene the first procedure in mm, a camera and a light that hold it, and markers for its steps."""
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 0.001
    scene.unit_settings.length_unit = "MILLIMETERS"
    procedure = first_procedure()
    home = next(iter(scene.collection.children), None)
    if home is None:
        home = bpy.data.collections.new(MODEL.capitalize())
        scene.collection.children.link(home)
    home.name = MODEL.capitalize()
    scene.frame_end = math.ceil(procedure.end_time)
    fill_scene(scene, procedure, home)
    scene.lappet.active_event = 0
    scene.frame_set(scene.frame_start)
    points = procedure.tissue.points / mm_per_unit(scene)
    _camera(scene, home, points)
    _light(home, points)
    set_markers(scene, proposed_steps(scene_strips(scene), scene.frame_start, scene.frame_end))


def _camera(scene: bpy.types.Scene, home: bpy.types.Collection, points: np.ndarray) -> None:
    """A camera that looks down at a slant and holds the points."""
    data = bpy.data.cameras.new("Camera")
    data.lens = 70.0
    middle = Vector(0.5 * (points.min(axis=0) + points.max(axis=0)))
    back = Vector((0.12, -0.62, 0.77)).normalized()
    radius = 0.5 * float(np.linalg.norm(np.ptp(points, axis=0))) * _FILL
    distance = radius / math.sin(0.5 * data.angle_y)
    camera = bpy.data.objects.new("Camera", data)
    camera.matrix_world = (
        Matrix.Translation(middle + distance * back) @ back.to_track_quat("Z", "Y").to_matrix().to_4x4()
    )
    data.clip_start, data.clip_end = 0.01 * distance, 10.0 * distance
    home.objects.link(camera)
    scene.camera = camera


def _light(home: bpy.types.Collection, points: np.ndarray) -> None:
    """A sun from the upper left, as drawings have it."""
    data = bpy.data.lights.new("Light", "SUN")
    data.energy, data.angle = 3.0, math.radians(12.0)
    light = bpy.data.objects.new("Light", data)
    away = Vector((-0.45, 0.35, 0.82)).normalized()
    light.matrix_world = Matrix.Translation(away * float(np.ptp(points, axis=0).max())) @ (
        away.to_track_quat("Z", "Y").to_matrix().to_4x4()
    )
    home.objects.link(light)


def _arrange() -> None:
    """Make a workspace of the first window's: its view on the field, the sidebar at Lappet, a tall Timeline."""
    manager = bpy.context.window_manager
    window = manager.windows[0] if manager is not None and len(manager.windows) else None
    if window is None or window.workspace is None:
        return
    window.workspace.name = WORKSPACE
    points = _world_points(window.scene)
    for area in window.screen.areas:
        if area.type == "VIEW_3D":
            _look_at(window, area, points)
        elif area.type == "DOPESHEET_EDITOR":
            region = next(each for each in area.regions if each.type == "WINDOW")
            with bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region):
                bpy.ops.lappet.strips_room(height=_TIMELINE)
                bpy.ops.action.view_all()


def _world_points(scene: bpy.types.Scene) -> np.ndarray:
    tissue = scene.lappet.tissue.object
    corners = np.array([tissue.matrix_world @ Vector(corner) for corner in tissue.bound_box])
    return corners.astype(np.float64)


def _look_at(window: bpy.types.Window, area: bpy.types.Area, points: np.ndarray) -> None:
    space = area.spaces.active
    view = space.region_3d
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    view.view_perspective = "PERSP"
    view.view_location = Vector(0.5 * (points.min(axis=0) + points.max(axis=0)))
    view.view_rotation = Vector((0.12, -0.62, 0.77)).to_track_quat("Z", "Y")
    view.view_distance = 1.35 * size
    space.clip_start, space.clip_end = 0.01 * size, 100.0 * size
    space.show_region_ui = True
    sidebar = next((each for each in area.regions if each.type == "UI"), None)
    if sidebar is not None and hasattr(sidebar, "active_panel_category"):
        bpy.app.timers.register(lambda: _tab(area), first_interval=0.2)


def _tab(area: bpy.types.Area) -> None:
    """Show the sidebar's tab Lappet; Blender knows the tabs once it has drawn them."""
    for region in area.regions:
        if region.type == "UI":
            try:
                region.active_panel_category = "Lappet"
            except (TypeError, ValueError, AttributeError):
                return  # no tab of that name: the sidebar stays as it is
