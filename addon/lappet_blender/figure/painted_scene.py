"""The scene of a painted plate: one solved procedure, seen by the cameras of its panels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import SENSOR, SurgicalField, Viewpoint
from lappet.drawing.hook_steel import HookSteel
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.suture_thread import SutureThread, buried_sutures
from lappet.drawing.wound_edge import WoundEdge
from lappet.procedure import VESSEL_KINDS

from ..look.painted_material import is_dark, painted_bed, painted_skin, painted_underside, painted_wall
from ..look.scenery import add_scenery
from ..look.skin_import import Bed, SkinObject
from ..look.skin_material import (
    edge_material,
    lumen_material,
    mucosa_material,
    rim_material,
    steel_material,
    thread_material,
    vessel_material,
)
from ..look.surround import surround
from ..look.vessel_tubes import VesselTubes
from .drawn_part import DrawnTubes, ScenePart
from .figure_scene import add_camera, add_lights, clear_scene, figure_studio, render_png, set_render, set_size

_LIGHTS = (14.0, 0.22)  # the key stronger and the sky weaker than in a figure: form shows by light and shade
_BEYOND = 12.0  # times the field: how far skin goes on


@dataclass(frozen=True)
class PaintedPanel:
    """A panel.

    time: time code. view: its camera. half_width: tangent of half its horizontal field of view. pixels: its width and
    height. hooks: whether they are drawn. picture: the file to write.
    """

    time: float
    view: Viewpoint
    half_width: float
    pixels: tuple[int, int]
    hooks: bool
    picture: Path


class PaintedScene:
    """The scene of one cache."""

    def __init__(
        self,
        cache: SkinCache,
        field: SurgicalField,
        axes: NDArray[np.float64],
        tone: str,
        goes_on: bool,
    ) -> None:
        """axes: (3, 3), right, up and out of the skin as the plate is seen. goes_on: whether skin is drawn beyond."""
        clear_scene()
        skin = painted_skin(tone)
        materials = [
            skin,
            painted_wall(cache.layers),
            painted_underside(cache.layers),
            mucosa_material() if cache.scenery else rim_material(cache.layers),
        ]
        scale = field.stitch_scale
        thread = SutureThread(cache, axes[0] + 0.6 * axes[1], scale, buried_sutures(cache))
        self._hooks = DrawnTubes("Hooks", HookSteel(cache, axes, field.center, scale), steel_material(), 16)
        self._parts: tuple[ScenePart, ...] = (
            SkinObject(cache, materials),
            Bed(cache, painted_bed()),
            DrawnTubes("Wound edge", WoundEdge(cache), edge_material(), 6),
            DrawnTubes("Sutures", thread, thread_material(is_dark(tone)), 10),
            *(
                DrawnTubes(f"Vessels: {kind}", VesselTubes(cache, kind), vessel_material(kind), 20)
                for kind in VESSEL_KINDS
            ),
            DrawnTubes("Vessels: lumen", VesselTubes(cache, "", lumen=True), lumen_material(), 20),
            self._hooks,
        )
        studio = figure_studio()
        add_scenery(cache.scenery, studio.collection, 0.0, skin)
        if goes_on:
            surround(cache, _BEYOND * field.extent, skin)
        add_lights(replace(field, right=axes[0], up=axes[1], normal=axes[2]), studio, *_LIGHTS)
        self._studio = studio
        set_render(studio.scene, "cycles")
        studio.scene.render.film_transparent = True
        studio.scene.cycles.max_bounces, studio.scene.cycles.diffuse_bounces = 3, 2

    def paint(self, panel: PaintedPanel, samples: int) -> None:
        """Write the picture of a panel. samples: of Cycles, a pixel."""
        for part in self._parts:
            part.show(panel.time)
        self._hooks.object.hide_render = not panel.hooks
        camera = add_camera(panel.view, self._studio)
        camera.data.sensor_fit = "HORIZONTAL"
        camera.data.lens = 0.5 * SENSOR / panel.half_width
        set_size(panel.pixels, samples)
        render_png(panel.picture, "RGBA")
        bpy.data.objects.remove(camera)
