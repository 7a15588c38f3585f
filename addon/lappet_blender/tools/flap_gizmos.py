"""The handles of the laid flap that the active event belongs to, as gizmos in the 3D viewport.

A gizmo only shows where a handle is and starts the operator that edits the flap (flap_edit_tool.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import bpy
import numpy as np
from mathutils import Matrix, Vector

from lappet.core.problem import RefusedError
from lappet.designs.flap_handles import PLACE, TURN, FlapHandle, HandledFlap
from lappet.designs.laid_flaps import laid_flap
from lappet.designs.library import DESIGNS
from lappet.procedure import Tissue

from ..model.laid_flaps import active_flap, design_of
from ..model.scene_procedure import read_scene
from ..model.tissue_values import tissue_value
from .flap_edit_tool import edit_operator
from .shown_surface import shown_surface

MOST = 2 + max(sum(not each.whole for each in design.parameters) for design in DESIGNS.values())
_COLORS = {PLACE: (0.95, 0.75, 0.20), TURN: (0.45, 0.68, 0.95)}
_MEASURE = (0.95, 0.95, 0.95)
_BRIGHT = (1.0, 0.45, 0.20)


@dataclass(frozen=True, eq=False)
class _Kept:
    """The handles of the flap that was asked for last."""

    key: tuple[str, str, str]
    tissue: Tissue | None
    handles: tuple[FlapHandle, ...]


_kept: list[_Kept] = []


def shows_handles(context: bpy.types.Context) -> bool:
    """Whether handles are shown: an event of a laid flap is active, and no tool is in hand that draws on the skin."""
    scene = context.scene
    if scene is None or context.mode != "OBJECT" or not active_flap(scene):
        return False
    tool = context.workspace.tools.from_space_view3d_mode("OBJECT", create=False) if context.workspace else None
    return tool is None or not tool.idname.startswith("lappet.") or tool.idname == "lappet.edit"


def handles_of_active(scene: bpy.types.Scene) -> tuple[FlapHandle, ...]:
    """The handles of the flap that the active event belongs to, at rest; kept until it changes. None where it is wrong.

    Reading a scene and drawing a design take a tenth of a second: too long for every redraw.
    """
    name = active_flap(scene)
    if not name:
        return ()
    tissue = tissue_value(scene)[0]
    key = (scene.name, name, str(scene.lappet.flaps[name].value))
    if _kept and _kept[0].key == key and _kept[0].tissue is tissue:
        return _kept[0].handles
    handles: tuple[FlapHandle, ...] = ()
    procedure = read_scene(scene).procedure
    if procedure is not None:
        try:
            handles = HandledFlap(procedure, laid_flap(procedure, name)).handles()
        except RefusedError:
            handles = ()  # the operator says why, if it is asked
    _kept[:] = [_Kept(key, tissue, handles)]
    return handles


def shown_places(scene: bpy.types.Scene, viewport: bpy.types.SpaceView3D | None) -> list[tuple[FlapHandle, Vector]]:
    """The handles and where they are in the world, on the skin as it is shown."""
    handles = handles_of_active(scene)
    surface = shown_surface(scene, viewport) if handles else None
    if surface is None:
        return []
    world = surface.carry(surface.rest.locate(np.array([each.point for each in handles])))
    return [(each, Vector(place.tolist())) for each, place in zip(handles, world, strict=True)]


class LAPPET_GGT_flap(bpy.types.GizmoGroup):
    """Handles of a laid flap."""

    bl_idname = "LAPPET_GGT_flap"
    bl_label = "Flap Handles"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options: ClassVar[set[str]] = {"3D", "PERSISTENT"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return shows_handles(context)

    def setup(self, _context: bpy.types.Context) -> None:
        for _ in range(MOST):
            gizmo = self.gizmos.new("GIZMO_GT_move_3d")
            gizmo.draw_style = "RING_2D"
            gizmo.draw_options = {"ALIGN_VIEW", "FILL"}
            gizmo.color_highlight, gizmo.alpha, gizmo.alpha_highlight = _BRIGHT, 0.85, 1.0
            gizmo.scale_basis = 0.09
            gizmo.hide = True

    def draw_prepare(self, context: bpy.types.Context) -> None:
        scene = context.scene
        places = shown_places(scene, context.space_data)[:MOST]
        flap = active_flap(scene)
        design = design_of(scene, flap)
        for k, gizmo in enumerate(self.gizmos):
            gizmo.hide = k >= len(places)
            if gizmo.hide:
                continue
            handle, place = places[k]
            gizmo.matrix_basis = Matrix.Translation(place)
            gizmo.color = _COLORS.get(handle.name, _MEASURE)
            started: Any = gizmo.target_set_operator(edit_operator(design))
            started.flap, started.handle = flap, handle.name


def forget() -> None:
    """Drop what is kept, after another file was opened."""
    _kept.clear()


CLASSES = (LAPPET_GGT_flap,)
