"""Add events to a scene, after a check of what would be wrong with them there."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import bpy
import numpy as np
from mathutils import Matrix, Vector

from lappet.procedure import Basis, Event, Excision, Hook, Incision, Landmark, Point, Retractor, Thin, Tissue, Undermine

from ..model.event_list import find_event, remove_event
from ..model.event_values import add_value, free_name
from .event_check import check_events, tissue_of

Place = Sequence[float]


def add_events(scene: bpy.types.Scene, values: Sequence[Event], instead: Collection[str] = ()) -> tuple[str, ...]:
    """Add events to a scene, all or none, and return the names that they got.

    instead: names of events that they replace. Raises RefusedError with what is wrong with them.
    """
    check_events(scene, values, instead)
    for name in instead:
        event = find_event(scene, name)
        if event is not None:
            remove_event(scene, event)
    return tuple(str(add_value(scene, value).name) for value in values)


def add_incision(
    scene: bpy.types.Scene,
    points: Iterable[Place],
    time: float,
    *,
    depth: float | None = None,
    kerf: float = 0.05,
    basis: Basis = "linear",
    closed: bool = False,
    name: str = "",
) -> None:
    """Add an incision along points at rest, mm. depth: mm, None = through the tissue. name: "" = kind and number."""
    name = free_name(scene, "INCISION", name)
    add_events(scene, [Incision(name, time, point_values(points), depth, kerf, basis, closed)])


def add_excision(scene: bpy.types.Scene, point: Place, time: float, *, name: str = "") -> None:
    """Add the excision of the piece of tissue at a point at rest, mm."""
    add_events(scene, [Excision(free_name(scene, "EXCISION", name), time, (point_value(point),))])


def add_undermining(
    scene: bpy.types.Scene, points: Iterable[Place], time: float, *, basis: Basis = "linear", name: str = ""
) -> None:
    """Add the undermining of the area inside a closed line at rest, mm."""
    add_events(scene, [Undermine(free_name(scene, "UNDERMINE", name), time, point_values(points), basis)])


def add_thinning(
    scene: bpy.types.Scene,
    points: Iterable[Place],
    time: float,
    thickness: float,
    *,
    dressing: float = Thin.dressing,
    duration: float = Thin.duration,
    basis: Basis = "linear",
    name: str = "",
) -> None:
    """Add the thinning of the tissue inside a closed line at rest, mm.

    thickness: what stays, mm. dressing: kPa. duration: frames in which it comes to press.
    """
    name = free_name(scene, "THIN", name)
    add_events(scene, [Thin(name, time, point_values(points), thickness, basis, dressing, duration)])


def add_landmark(scene: bpy.types.Scene, points: Iterable[Place], *, label: str = "", name: str = "") -> None:
    """Add a landmark at points at rest, mm. label: "" = its name."""
    name = free_name(scene, "LANDMARK", name)
    add_events(scene, [Landmark(name, point_values(points), label or name)])


def add_hook(
    scene: bpy.types.Scene,
    anchor: Place,
    targets: Sequence[tuple[float, Place]],
    start: float,
    release: float,
    *,
    stiffness: float,
    name: str = "",
) -> None:
    """Add a hook in a point of the skin at rest. targets: (frame, place) of what it pulls to; all places in mm."""
    name = free_name(scene, "HOOK", name)
    samples = tuple((time, point_value(place)) for time, place in targets)
    add_events(scene, [Hook(name, point_value(anchor), samples, start, release, stiffness)])


def straight_targets(begin: Place, target: Place, start: float, arrive: float) -> list[tuple[float, Place]]:
    """Return the targets of a hook that pulls straight from one place to another within `arrive` frames."""
    return [(start, begin), (start + arrive, target)] if arrive > 0.0 else [(start, target)]


def add_retractor(
    scene: bpy.types.Scene,
    grip: str,
    motion: Sequence[tuple[float, Matrix]],
    start: float,
    release: float,
    *,
    name: str = "",
) -> None:
    """Add a retractor that holds a group of the tissue's faces. motion: (frame, place and rotation, mm) samples."""
    name = free_name(scene, "RETRACTOR", name)
    samples = tuple((time, tuple(np.array(matrix.transposed()).ravel().tolist())) for time, matrix in motion)
    add_events(scene, [Retractor(name, grip, samples, start, release)])


def straight_motion(
    scene: bpy.types.Scene, grip: str, shift: Place, start: float, arrive: float
) -> list[tuple[float, Matrix]]:
    """Return the motion of a retractor that moves the middle of its grip by `shift` mm within `arrive` frames."""
    tissue = tissue_of(scene)
    middle = faces_middle(tissue, tissue.subsets.get(grip, ()))
    motion = [(start, Matrix.Translation(middle))]
    if arrive > 0.0 and any(shift):
        motion.append((start + arrive, Matrix.Translation(Vector(middle) + Vector(shift))))
    return motion


def faces_middle(tissue: Tissue, faces: Iterable[int]) -> Point:
    """Return the mean of the vertices of some faces of a tissue, mm; the origin for no face."""
    ends = np.cumsum(tissue.face_vertex_counts)
    corners = [tissue.face_vertex_indices[ends[face] - tissue.face_vertex_counts[face] : ends[face]] for face in faces]
    if not corners:
        return (0.0, 0.0, 0.0)
    return point_value(tissue.points[np.unique(np.concatenate(corners))].mean(axis=0).tolist())


def point_value(place: Place) -> Point:
    """Return a place as a procedure's point."""
    x, y, z = (float(v) for v in place)
    return (x, y, z)


def point_values(places: Iterable[Place]) -> tuple[Point, ...]:
    """Return places as a procedure's points."""
    return tuple(point_value(place) for place in places)
