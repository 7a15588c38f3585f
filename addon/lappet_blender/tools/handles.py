"""The points of events that can be taken hold of, and which of them is under the mouse."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import FaceOrigin

from ..model.event_properties import LappetEvent
from ..model.procedure_properties import LappetSkinLine, LappetVessel
from ..model.units import to_mm
from .rest_line import rest_samples
from .shown_surface import ShownSurface, shown_surface

TARGET = -1  # the index of a handle that is the empty a hook or retractor follows
CLOSED_KINDS = frozenset({"UNDERMINE", "THIN"})
LINE_KINDS = CLOSED_KINDS | {"INCISION"}
SKIN_KINDS = LINE_KINDS | {"SUTURE_RUN"}  # whose points lie on the skin
_GONE = 2.0
_MOST_OF_RUN = 10  # points of a suture run that have handles: of edges that a design drew, nobody moves single ones
Project = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Handle:
    """A point of an event. index: into the event's points, or `TARGET`. rest: mm. world: where it is shown.

    normal: of the skin there; None where it does not lie on the skin.
    """

    event_uid: str
    index: int
    rest: tuple[float, float, float]
    world: Vector
    normal: Vector | None = None

    def faces(self, viewer: Vector, orthographic: bool = False) -> bool:
        """Whether it lies on the near side, seen from a place, or for an orthographic view against a direction."""
        toward = viewer if orthographic else viewer - self.world
        return self.normal is None or self.normal.dot(toward) > -0.2 * toward.length


def handles_of(scene: bpy.types.Scene, time: float, viewport: bpy.types.SpaceView3D | None = None) -> list[Handle]:
    """The handles of all events of a scene as they are shown at a time.

    Points whose tissue is gone from the shown skin have none. Of points at one place (the doubled ends of a smooth
    line) the first stands for all. The targets' places are those of now, whatever the time: Blender has evaluated them.
    """
    surface = shown_surface(scene, viewport)
    found: list[Handle] = []
    for event in scene.lappet.events:
        if surface is not None:
            found += _point_handles(event, surface)
        if event.target is not None and event.target.name in scene.objects:
            place = event.target.matrix_world.translation
            found.append(Handle(event.uid, TARGET, to_mm(scene, place), place.copy()))
    return found


def event_points(event: LappetEvent | LappetSkinLine | LappetVessel) -> NDArray[np.float64]:
    """The points (n, 3) of an event, of a line of the skin or of a vessel at rest, mm."""
    flat = np.empty(3 * len(event.points), np.float32)
    event.points.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(np.float64)


def _point_handles(event: LappetEvent, surface: ShownSurface) -> list[Handle]:
    rest = event_points(event)
    if len(rest) == 0 or (event.kind == "SUTURE_RUN" and len(rest) > _MOST_OF_RUN):
        return []
    located = surface.rest.locate(rest, skin_only=event.kind in SKIN_KINDS)
    off = np.linalg.norm(surface.rest.at(located) - rest, axis=1)
    hovers = event.kind in LINE_KINDS and event.basis in ("BSPLINE", "BEZIER")  # these may lie off the skin
    world = surface.carry(located)
    normals = surface.normals(located.triangle)
    on_skin = surface.rest.origin[located.triangle] == FaceOrigin.SKIN
    handles = []
    for index, place in enumerate(rest):
        first = index == 0 or bool(np.linalg.norm(rest[:index] - place, axis=1).min() > 1e-4)
        if first and (hovers or off[index] <= _GONE):
            x, y, z = (float(v) for v in place)
            normal = Vector(normals[index].tolist()) if on_skin[index] else None
            handles.append(Handle(event.uid, index, (x, y, z), Vector(world[index].tolist()), normal))
    return handles


def indices_at(event: LappetEvent, index: int) -> list[int]:
    """The indices of all points of an event that lie where one of them does: they move together."""
    points = event_points(event)
    return np.flatnonzero(np.linalg.norm(points - points[index], axis=1) <= 1e-4).tolist()


def nearest_handle(
    handles: Sequence[Handle], project: Project, mouse: Sequence[float], radius: float, prefer: str = ""
) -> Handle | None:
    """The handle nearest to the mouse (pixels) within a radius.

    `project` takes places (k, 3) to pixels (k, 2), NaN where they are behind the viewer. Of handles as near to within 2
    pixels one of the event `prefer` is taken, then a target before the anchor that it hides.
    """
    if not handles:
        return None
    pixels = project(np.array([handle.world for handle in handles], np.float64))
    away = np.linalg.norm(pixels - np.asarray(mouse, np.float64)[:2], axis=1)
    away = np.where(np.isfinite(away), away, np.inf)
    favour = np.array([2.0 * (handle.event_uid == prefer) + 1.0 * (handle.index == TARGET) for handle in handles])
    best = int((away - favour).argmin())
    return handles[best] if away[best] <= radius else None


def nearest_line(
    scene: bpy.types.Scene,
    surface: ShownSurface,
    project: Project,
    mouse: Sequence[float],
    radius: float,
    kinds: Sequence[str] = (*LINE_KINDS, "SUTURE", "SUTURE_RUN"),
) -> str | None:
    """The uid of the event, of some kinds, whose line is nearest to the mouse (pixels) within a radius.

    None where there is none.
    """
    best, found = radius, None
    for event in scene.lappet.events:
        if event.kind not in kinds or len(event.points) < 2:
            continue
        samples = event_points(event)
        if event.kind in LINE_KINDS:
            samples = rest_samples(samples, event.basis, is_closed(event))
        pixels = project(surface.carry(surface.rest.locate(samples)))
        a, way = pixels[:-1], np.diff(pixels, axis=0)
        square = np.maximum(np.einsum("ij,ij->i", way, way), 1e-12)
        t = np.clip(np.einsum("ij,ij->i", np.asarray(mouse)[:2] - a, way) / square, 0.0, 1.0)
        away = np.linalg.norm(a + t[:, None] * way - np.asarray(mouse)[:2], axis=1)
        if event.kind == "SUTURE_RUN" and 0 < event.second_from < len(samples):
            away[event.second_from - 1] = np.inf  # from one edge to the other
        nearest = float(np.nanmin(away)) if np.isfinite(away).any() else np.inf
        if nearest < best:
            best, found = nearest, event.uid
    return found


def is_closed(event: LappetEvent) -> bool:
    """Whether an event's line returns to its first point; the outline of an area always does."""
    return event.kind in CLOSED_KINDS or bool(event.closed)
