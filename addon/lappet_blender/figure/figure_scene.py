"""The studio of the plate: seamless backdrop, three soft lights, camera, and the render settings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from lappet.drawing.framing import LENS, SENSOR, SurgicalField, Viewpoint

from ..look.skin_import import SCALE
from .png_file import publish_png

ENGINES = {"cycles": "CYCLES", "workbench": "BLENDER_WORKBENCH"}
BACKDROP_REACH = 60.0  # of the paper from its middle, times the field's extent: to the horizon of a low camera


def clear_scene() -> bpy.types.Scene:
    """An empty scene in place of whatever Blender starts with."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


@dataclass(frozen=True)
class Studio:
    """Where a plate is built: the scene that is rendered, the collection of its objects, Blender units per mm."""

    scene: bpy.types.Scene
    collection: bpy.types.Collection
    units: float = SCALE


def figure_studio() -> Studio:
    """The scene of the context."""
    return Studio(bpy.context.scene, bpy.context.scene.collection)


def add_camera(view: Viewpoint, studio: Studio) -> bpy.types.Object:
    """A long lens at a viewpoint (mm)."""
    data = bpy.data.cameras.new("Camera")
    data.lens, data.sensor_width, data.sensor_fit = LENS, SENSOR, "AUTO"
    data.clip_start, data.clip_end = 0.05 * view.distance * studio.units, 40 * view.distance * studio.units
    camera = bpy.data.objects.new("Camera", data)
    camera.matrix_world = _placed(view.position, view.axes, studio.units)
    studio.collection.objects.link(camera)
    studio.scene.camera = camera
    return camera


def _placed(position: NDArray[np.float64], axes: NDArray[np.float64], units: float) -> Matrix:
    return Matrix(np.vstack([np.column_stack([axes.T, position * units]), [0, 0, 0, 1]]).tolist())


def _add_light(
    name: str,
    studio: Studio,
    field: SurgicalField,
    reach: float,
    towards: tuple[float, float, float],
    size: float,
    power: float,
) -> None:
    """A square area light that looks at the field's center; power is scaled so that distance does not matter."""
    axes = np.stack([field.right, field.up, field.normal])
    back = np.asarray(towards, float) @ axes
    back /= np.linalg.norm(back)
    right = np.cross(field.up, back)
    right /= np.linalg.norm(right)
    data = bpy.data.lights.new(name, "AREA")
    data.shape, data.size = "DISK", size * reach * studio.units
    data.energy = power * (reach * studio.units) ** 2
    light = bpy.data.objects.new(name, data)
    light.matrix_world = _placed(
        field.center + reach * back, np.stack([right, np.cross(back, right), back]), studio.units
    )
    studio.collection.objects.link(light)


def add_lights(field: SurgicalField, studio: Studio, key: float = 11.5, sky: float = 0.36) -> None:
    """Key from the upper left, fill from the right, rim from behind, and an even sky. key, sky: their strengths."""
    reach = 4.5 * field.extent
    _add_light("Key", studio, field, reach, (-0.85, 0.55, 1.0), 0.45, key)
    _add_light("Fill", studio, field, reach, (1.0, -0.5, 0.8), 1.1, 3.0)
    _add_light("Rim", studio, field, reach, (0.35, 1.2, 0.5), 0.7, 4.0)
    world = bpy.data.worlds.new("World")
    studio.scene.world = world
    if not world.use_nodes:
        world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.93, 0.96, 1.0, 1.0)
    background.inputs["Strength"].default_value = sky


def add_backdrop(field: SurgicalField, lowest: float, material: bpy.types.Material, studio: Studio) -> bpy.types.Object:
    """A wide sheet of paper across the field's normal. lowest: mm along the normal, under everything."""
    axes = np.stack([field.right, field.up, field.normal])
    middle = field.center + (lowest - field.center @ field.normal) * field.normal
    half = BACKDROP_REACH * field.extent
    corners = [middle + half * (x * axes[0] + y * axes[1]) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mesh = bpy.data.meshes.new("Backdrop")
    mesh.from_pydata([tuple(c * studio.units) for c in corners], [], [(0, 1, 2, 3)])
    mesh.materials.append(material)
    sheet = bpy.data.objects.new("Backdrop", mesh)
    studio.collection.objects.link(sheet)
    return sheet


def set_render(scene: bpy.types.Scene, engine: str, threads: int = 0, textured: bool = False) -> None:
    """Engine, quality and color: Cycles on the processor with denoising, or Workbench for drafts.

    textured: whether Workbench shows the pictures of `look.solid_texture`.
    """
    scene.render.engine = ENGINES[engine]
    scene.render.use_persistent_data = True
    scene.render.film_transparent = False
    if threads > 0:
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.view_settings.view_transform = "Khronos PBR Neutral"
    scene.view_settings.look = "None"
    scene.view_settings.exposure = -0.12
    if engine == "cycles":
        cycles = scene.cycles
        cycles.device = "CPU"
        cycles.use_adaptive_sampling = False
        cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 2, 1, 1
        cycles.use_light_tree = False
        cycles.caustics_reflective = cycles.caustics_refractive = False
        cycles.sample_clamp_indirect = 4.0
        cycles.use_denoising, cycles.denoiser = True, "OPENIMAGEDENOISE"
        cycles.denoising_input_passes, cycles.denoising_prefilter = "RGB_ALBEDO_NORMAL", "FAST"
        # Of a picture's time the denoiser at its best would take most; its fast network leaves nothing to see here.
        cycles.denoising_quality = "FAST"
        cycles.use_auto_tile = False
    else:
        shading = scene.display.shading
        shading.light, shading.color_type = "STUDIO", "TEXTURE" if textured else "MATERIAL"
        shading.show_shadows, shading.show_cavity = False, True
        scene.world.color = (0.86, 0.87, 0.88)
        scene.view_settings.view_transform, scene.view_settings.exposure = "Standard", 0.6
        for sheet in scene.objects:
            sheet.hide_render = sheet.hide_render or sheet.name == "Backdrop"


def set_size(size: tuple[int, int], samples: int, scene: bpy.types.Scene | None = None) -> None:
    """Picture size in pixels and Cycles samples a pixel, of the context's scene if none is given."""
    scene = scene or bpy.context.scene
    scene.cycles.samples = samples
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = size[0], size[1], 100


def render_png(path: Path, mode: str = "RGB") -> None:
    """Render the scene as it stands to a PNG; the file appears whole or not at all. mode: RGB or RGBA."""
    scene = bpy.context.scene
    draft = path.with_name(f".{path.stem}.part.png")
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", mode, "8"
    settings.compression = 40
    scene.render.filepath = str(draft)
    scene.render.use_file_extension = False
    bpy.ops.render.render(write_still=True)
    publish_png(draft, path)
