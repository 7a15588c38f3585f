"""The tools Hook and Retractor: press on the skin and drag to where it is pulled."""

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from bpy.props import FloatProperty, FloatVectorProperty, IntProperty, StringProperty
from mathutils import Vector
from numpy.typing import NDArray

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Point, Retractor, pose_at

from ..events.add_events import (
    add_hook,
    add_retractor,
    faces_middle,
    straight_motion,
    straight_targets,
)
from ..events.event_check import tissue_of
from ..interface.said import said
from ..model.event_values import free_name
from ..model.mesh_values import GROUP, group_faces, group_names
from ..model.units import to_mm
from ..solving.controller import Live
from ..solving.placed_drag import end_placing, place_live, pull_live
from ..tissue.face_groups import change_group, remove_group
from .face_patch import faces_around, free_group_name
from .preview import Preview, show_preview
from .shown_surface import ShownSurface, shown_surface
from .skin_modal import Result, SkinModal, check_shown, check_tissue
from .skin_pick import SkinHit
from .view_under_mouse import View

_HINTS = (
    ("MOUSE_LMB_DRAG", "Pull from the skin"),
    ("EVENT_SHIFT", "Along the normal"),
    ("EVENT_ESC", "Cancel"),
)
Faces = NDArray[np.integer[Any]]
_LEAST_PULL = 0.5  # mm, from which on the skin follows


@dataclass(frozen=True)
class Placed:
    """What is being placed. at: where its target begins, mm. grip: the faces that a retractor holds."""

    event: Hook | Retractor
    at: Point
    grip: Faces | None = None


class _DragTool(SkinModal):
    """What both share: where it was taken hold of, and where the mouse has pulled it to."""

    hints = _HINTS
    start: Any
    end: Any

    def begin(self, context: bpy.types.Context) -> None:
        self.hit: SkinHit | None = None
        self.pulled_to: Vector | None = None
        self._said = ""
        self._live: Live | None = None
        self._asked = False

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        self.hit = view.pick(context.scene)
        self._said = "" if self.hit else "the mouse is not on the skin; "
        return self.moved(context, view)

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        preview = Preview(context.scene.name)
        if view is None:
            return None
        hover = self.hit or view.pick(context.scene)
        if hover is not None:
            preview.dots = [hover.rest]
            self.show_hold(context, view, hover, preview)
        if self.hit is not None:
            free = view.on_plane_through(self.hit.world)
            self.pulled_to = view.along(self.hit.world, self.hit.normal) if self.shift else free
            preview.arrows = [(self.hit.world, self.pulled_to)]
            self._follow(context, view, self.hit, self.pulled_to)
        show_preview(preview)
        return None

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if self.hit is None:
            return None
        self._let_go()
        self.start, self.end = self._times(context)
        self.take(context, self.hit, self.pulled_to or self.hit.world)
        return self.execute(context)

    def abandoned(self, context: bpy.types.Context) -> None:
        self._let_go()

    def take(self, context: bpy.types.Context, hit: SkinHit, to: Vector) -> None:
        """Fill the operator's properties: it is pulled from the hit to a place of the world."""
        raise NotImplementedError

    def placed(self, context: bpy.types.Context, view: View, hit: SkinHit) -> Placed | None:
        """What is being placed, pulling nowhere yet; None where it holds nothing."""
        raise NotImplementedError

    def _follow(self, context: bpy.types.Context, view: View, hit: SkinHit, to: Vector) -> None:
        """Have the skin follow, from the first millimeters on: a click alone asks nothing of the solver."""
        way = Vector(to_mm(context.scene, to)) - Vector(to_mm(context.scene, hit.world))
        if not self._asked and way.length > _LEAST_PULL:
            self._asked = True
            self._placed = self.placed(context, view, hit)
            if self._placed is not None:
                self._live = place_live(context.scene, self._placed.event, self._placed.grip)
        if self._live is not None and self._placed is not None:
            x, y, z = Vector(self._placed.at) + way
            pull_live(context.scene, self._live, pose_at((x, y, z)))

    def _let_go(self) -> None:
        live, self._live = self._live, None
        scene = bpy.data.scenes.get(self._scene)
        if scene is not None:
            end_placing(scene, live)

    def show_hold(self, context: bpy.types.Context, view: View, hit: SkinHit, preview: Preview) -> None:
        """Show what is taken hold of."""

    def text(self, context: bpy.types.Context) -> str:
        if self.hit is None or self.pulled_to is None:
            return said("{tool}: {note}press on the skin and drag", tool=said(self.title), note=self._said)
        way = Vector(to_mm(context.scene, self.pulled_to - self.hit.world))
        pattern, frame = "{tool} from frame {frame}: {length} mm", context.scene.frame_current
        return said(pattern, tool=said(self.title), frame=frame, length=f"{way.length:.1f}")

    def _times(self, context: bpy.types.Context) -> tuple[float, float]:
        """Start and release, as given or from the current frame to after the scene's end."""
        given = self.properties.is_property_set
        start = self.start if given("start") else float(context.scene.frame_current)
        return start, self.end if given("end") else float(max(context.scene.frame_end, start) + 1)


def _start() -> object:
    return FloatProperty(name="Frame", description="The frame at which it starts", options={"SKIP_SAVE"})


def _end() -> object:
    return FloatProperty(name="Release", description="The frame at which it lets go", options={"SKIP_SAVE"})


def _frames() -> object:
    return IntProperty(
        name="Frames", description="Number of frames that the pull takes", default=12, min=0, soft_max=100, max=100000
    )


def _place(name: str, words: str) -> object:
    return FloatVectorProperty(name=name, description=words, size=3, precision=3, options={"SKIP_SAVE"})


class LAPPET_OT_place_hook(_DragTool, bpy.types.Operator):
    """Place a hook: press on the skin and drag to where it should pull"""

    bl_label = "Place Hook"
    title = "Hook"

    anchor: _place("Anchor", "The point of the skin at rest, in mm")
    begins: _place("From", "Where the target begins, in mm")
    target: _place("Target", "Where the hook pulls to, in mm")
    start: _start()
    end: _end()
    frames: _frames()
    stiffness: FloatProperty(
        name="Stiffness", description="In mN/mm", default=Hook.stiffness, min=0.001, soft_max=5000.0
    )

    def placed(self, context: bpy.types.Context, view: View, hit: SkinHit) -> Placed | None:
        start, end = self._times(context)
        at = to_mm(context.scene, hit.world)
        name = free_name(context.scene, "HOOK")
        return Placed(Hook(name, hit.rest, ((start, at),), start, end, self.stiffness), at)

    def take(self, context: bpy.types.Context, hit: SkinHit, to: Vector) -> None:
        self.anchor = hit.rest
        self.begins, self.target = to_mm(context.scene, hit.world), to_mm(context.scene, to)

    def run(self, context: bpy.types.Context) -> None:
        check_tissue(context)
        start, end = self._times(context)
        begins = self.begins if self.properties.is_property_set("begins") else self.anchor
        targets = straight_targets(begins, self.target, start, min(float(self.frames), max(end - start, 0.0)))
        add_hook(context.scene, self.anchor, targets, start, end, stiffness=self.stiffness)

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        for name in ("start", "end", "frames", "stiffness", "target"):
            self.layout.prop(self, name)


def _grips(tissue: bpy.types.Object | None) -> list[str]:
    """The groups of the tissue's faces that a retractor may hold."""
    if tissue is None or tissue.type != "MESH":
        return []
    return [name for name in group_names(tissue.data) if name not in ("fixed", "bed")]


class LAPPET_OT_place_retractor(_DragTool, bpy.types.Operator):
    """Place a retractor: press on the skin and drag; it grips the faces around the mouse or a group"""

    bl_label = "Place Retractor"
    title = "Retractor"

    grip: StringProperty(
        name="Group",
        description="The group of faces to grip; empty = the faces around the mouse",
        search=lambda _self, context, _text: _grips(context.scene.lappet.tissue.object),
    )
    radius: FloatProperty(
        name="Radius", description="Radius around the mouse within which faces are gripped, in mm", default=3.0, min=0.1
    )
    at: _place("Point", "The point of the skin at rest around which faces are gripped, in mm")
    way: _place("Way", "How far it is pulled, in mm")
    start: _start()
    end: _end()
    frames: _frames()

    def show_hold(self, context: bpy.types.Context, view: View, hit: SkinHit, preview: Preview) -> None:
        surface = shown_surface(context.scene, view.space)
        if surface is not None:
            preview.faces = self._gripped(context, surface, hit)

    def _gripped(self, context: bpy.types.Context, surface: ShownSurface, hit: SkinHit) -> np.ndarray:
        """The triangles (k, 3, 3) of the world that the retractor would hold."""
        shape = surface.rest
        held = shape.skin[np.isin(shape.face[shape.skin], self._faces(context, surface, hit))]
        return surface.positions[shape.triangles[held]]

    def _faces(self, context: bpy.types.Context, surface: ShownSurface, hit: SkinHit) -> np.ndarray:
        """The faces that it would hold: the chosen group's, or those around the mouse."""
        tissue = context.scene.lappet.tissue.object
        if self.grip and GROUP + self.grip in tissue.data.attributes:
            return np.flatnonzero(group_faces(tissue, self.grip))
        return faces_around(surface.rest, hit.rest, self.radius)

    def placed(self, context: bpy.types.Context, view: View, hit: SkinHit) -> Placed | None:
        scene, surface = context.scene, shown_surface(context.scene, view.space)
        if surface is None:
            return None
        grip = self._faces(context, surface, hit)
        grip = grip[grip < len(scene.lappet.tissue.object.data.polygons)]
        if len(grip) == 0:
            return None
        start, end = self._times(context)
        at = faces_middle(tissue_of(scene), grip)
        name = self.grip or free_group_name(scene.lappet.tissue.object)
        event = Retractor(free_name(scene, "RETRACTOR"), name, ((start, pose_at(at)),), start, end)
        return Placed(event, at, grip)

    def take(self, context: bpy.types.Context, hit: SkinHit, to: Vector) -> None:
        self.at = hit.rest
        self.way = to_mm(context.scene, to - hit.world)

    def run(self, context: bpy.types.Context) -> None:
        tissue, surface = check_tissue(context), shown_surface(context.scene)
        if surface is None and not self.grip:
            check_shown(context)
        start, end = self._times(context)
        grip = self.grip
        if not grip and surface is not None:
            grip = self._new_grip(tissue, surface)
        try:
            arrive = min(float(self.frames), max(end - start, 0.0))
            motion = straight_motion(context.scene, grip, self.way, start, arrive)
            add_retractor(context.scene, grip, motion, start, end)
        except RefusedError:
            if not self.grip:  # nothing is left half done
                remove_group(tissue, grip)
            raise

    def _new_grip(self, tissue: bpy.types.Object, surface: ShownSurface) -> str:
        """Make a group of the faces around the point and return its name."""
        faces = faces_around(surface.rest, self.at, self.radius)
        faces = faces[faces < len(tissue.data.polygons)]
        if len(faces) == 0:
            raise refused(ProblemCode.FACES_NONE_NEAR, tissue.name, f"{self.radius:g}")
        chosen = np.zeros(len(tissue.data.polygons), bool)
        chosen[faces] = True
        grip = free_group_name(tissue)
        change_group(tissue, grip, chosen, "SET")
        return grip

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        for name in ("grip", "radius", "start", "end", "frames", "way"):
            self.layout.prop(self, name)


CLASSES = (LAPPET_OT_place_hook, LAPPET_OT_place_retractor)
