"""A camera, light and paper for a picture of the solved skin as in a textbook."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.background.manifest import Manifest
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.framing import (
    WHOLE_FILL,
    SurgicalField,
    field_on_body,
    half_angles,
    viewpoint,
    viewpoint_on_skin,
)
from lappet.drawing.skin_fields import SKIN

from ..figure.figure_scene import BACKDROP_REACH, Studio, add_backdrop, add_camera, add_lights, set_render, set_size
from ..look.skin_material import backdrop_material
from ..model.scenery_values import scenery_points
from ..model.units import mm_per_unit
from ..solving import frames
from . import skin_display
from .display_collection import STAGE_OWNER as OWNER
from .display_collection import find_collection
from .solid_shading import shading_for
from .stage_paper import remove_staged, see_far_enough, seen_reach, shorten_in_views

NAME = "Lappet stage"
_BELOW = 1.5  # mm from the lowest tissue to the paper
_FRAMES = 9  # of a procedure, that the camera must hold


def set_stage(scene: bpy.types.Scene, view: str, engine: str, size: tuple[int, int], samples: int) -> None:
    """Frame what the scene shows, at any frame of its procedure, and set the render.

    view: of `framing.VIEWS`. engine: "cycles", "workbench" or "keep". size: pixels; (0, 0) keeps the scene's. A stage
    that was set before is replaced. Raises RefusedError where nothing is solved or known.
    """
    shown = skin_display.shown_of(scene, scene.frame_current)
    if shown is None:
        raise refused(ProblemCode.FIGURE_NOTHING_SHOWN, scene.name)
    units = 1.0 / mm_per_unit(scene)
    field, lowest, skin = _framed(scene, shown.manifest)
    other = scene.lappet.compare_with
    beside = None if other is None or other == scene else frames.shown_at(other, scene.frame_current)
    if other is not None and beside is not None:
        field, lowest = _both(scene, field, lowest, other, beside.manifest, shown.manifest)
    studio = Studio(scene, _empty_stage(scene), units)
    if size != (0, 0):
        set_size(size, samples, scene)
    render = scene.render
    pixels = (max(render.resolution_x, 1), max(render.resolution_y, 1))
    if beside is not None:
        seen = viewpoint(field, view, half_angles(pixels), turned=0.0)
    else:
        seen = viewpoint_on_skin(field, view, half_angles(pixels), skin)  # as a plate is seen, without the patch's rim
    paper = lowest - _BELOW
    sheet = add_backdrop(field, paper, backdrop_material(), studio)
    shorten_in_views(sheet, seen_reach(field, seen, half_angles(pixels), paper) / (BACKDROP_REACH * field.extent))
    add_lights(field, studio)
    add_camera(seen, studio)
    if engine != "keep":
        set_render(scene, engine)
        scene.display.shading.color_type = shading_for(scene.lappet.look)
    collection = find_collection(scene)
    if collection is not None:
        collection["lappet_pixel"] = float(2 * seen.distance * half_angles(pixels)[0] / pixels[0])
    skin_display.refresh(scene)
    bpy.context.view_layer.update()
    see_far_enough([*studio.collection.objects, *(collection.objects if collection is not None else ())])


def clear_stage(scene: bpy.types.Scene) -> bool:
    """Remove the stage; False where there is none."""
    found = [c for c in scene.collection.children if OWNER in c and c[OWNER] == scene]
    for stage in found:
        for each in list(stage.objects):
            remove_staged(each)
        bpy.data.collections.remove(stage)
    return bool(found)


def _empty_stage(scene: bpy.types.Scene) -> bpy.types.Collection:
    clear_stage(scene)
    for child in list(scene.collection.children):
        if OWNER in child:  # of the scene that this one is a copy of
            scene.collection.children.unlink(child)
    stage = bpy.data.collections.new(NAME)
    stage[OWNER] = scene
    scene.collection.children.link(stage)
    return stage


def _framed(scene: bpy.types.Scene, manifest: Manifest) -> tuple[SurgicalField, float, NDArray[np.float64]]:
    """The field of a manifest over some of its frames, the lowest point along its normal and the first skin, in mm.

    Where the body around the tissue is shown, the field has enough of it to know the place, as plates have.
    """
    shown = frames.shown_at(scene, scene.frame_current)
    assert shown is not None
    source = skin_display.decorations_of(scene, shown).source
    times = [float(f.time) for f in manifest.frames]
    spread = tuple(dict.fromkeys(times[round(k)] for k in np.linspace(0, len(times) - 1, _FRAMES)))
    body = scenery_points(scene)
    field = field_on_body(source, spread, bool(body))
    solved = [source.positions(source.epoch_at(t), t).astype(np.float64) for t in spread]
    lowest = min(float((points @ field.normal).min()) for points in (*solved, *body))
    first = source.epoch_at(times[0])
    skin = source.positions(first, times[0])[np.unique(first.triangles[first.origin == SKIN])]
    return field, lowest, skin


def _both(
    scene: bpy.types.Scene,
    field: SurgicalField,
    lowest: float,
    other: bpy.types.Scene,
    beside: Manifest,
    manifest: Manifest,
) -> tuple[SurgicalField, float]:
    """The field of two skins side by side, whole, with their labels."""
    own, theirs = skin_display.rest_box(manifest), skin_display.rest_box(beside)
    gap = skin_display.offset_of(scene, own, theirs)
    _, other_lowest, _ = _framed(other, beside)
    own[1][1] += skin_display.LABEL_GAP + skin_display.LABEL_SIZE
    boxes = [own, theirs + np.array([gap, 0.0, 0.0])]
    points = np.array([(x, y, z) for b in boxes for x in b[:, 0] for y in b[:, 1] for z in b[:, 2]])
    axes = np.stack([field.right, field.up, field.normal])
    local = points @ axes.T
    center = (local.min(axis=0) + local.max(axis=0)) / 2 @ axes
    low = min(lowest, other_lowest + gap * float(field.normal[0]))
    return replace(field, points=points, center=center, fill=WHOLE_FILL), low
