"""Add sutures to a scene: one between two points, or a run along two wound edges or an incision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.triangles import area_normals, directions
from lappet.procedure import Incision, Suture
from lappet.tissue.fan_triangles import fan_triangles

from ..model.event_values import event_value, free_name
from .add_events import Place, add_events, point_value
from .event_check import tissue_of
from .operator_values import named_event
from .stitch_shapes import Shape, stations_between
from .suture_pairs import BESIDE, across_incision, along, count_for, incision_line, length, shares_along

Ends = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class SutureTimes:
    """start: frame. duration: frames that the suture takes to close. stiffness: mN/mm."""

    start: float
    duration: float
    stiffness: float


@dataclass(frozen=True)
class Spacing:
    """How the sutures of a run are spaced.

    count: 0 = as many as `mm` between them gives. inset_start, inset_end: shares of the edge before the first and after
    the last; None = half a distance.
    """

    count: int = 0
    mm: float = 4.0
    inset_start: float | None = None
    inset_end: float | None = None

    def shares(self, size: float) -> NDArray[np.float64]:
        """Return the shares (k,) of an edge of `size` mm at which sutures lie."""
        return shares_along(self.count or count_for(size, self.mm), self.inset_start, self.inset_end)


def add_suture(
    scene: bpy.types.Scene, first: Place, second: Place, times: SutureTimes, *, depth: float = 0.0, name: str = ""
) -> None:
    """Add a suture between two points at rest, mm. depth: of both ends below the skin, mm."""
    ends = sunk(scene, np.array([first, second], np.float64), depth)
    _add(scene, (ends[:1], ends[1:]), times, [free_name(scene, "SUTURE", name)])


def add_stitches(
    scene: bpy.types.Scene, ends: Ends, times: SutureTimes, shape: Shape, *, name: str = "", numbered: bool = True
) -> None:
    """Add stitches of a shape between pairs of points (k, 3) of a wound's edges at rest, mm; threads all of them.

    name: of the first. numbered: whether it gets a number, from which the others are counted up.
    """
    skin, normals = _skin(scene)
    outward = normals[skin.query(0.5 * (ends[0] + ends[1]))[0]]
    sutures: list[Suture] = []
    for stitch in shape.stitches(stations_between(*ends, outward)):
        first = f"{name}_1" if name and numbered else name
        own = free_name(scene, "SUTURE", first, [suture.name for suture in sutures])
        values = {"duration": times.duration, "stiffness": times.stiffness}
        sutures.append(stitch.suture(own, times.start, shape.drawn, **values))
    add_events(scene, sutures)


def add_single_sutures(
    scene: bpy.types.Scene, ends: Ends, times: SutureTimes, *, depth: float = 0.0, name: str = ""
) -> None:
    """Add sutures between pairs of points (k, 3) at rest, mm. name: of the first; the others are counted up."""
    ends = (sunk(scene, ends[0], depth), sunk(scene, ends[1], depth))
    names: list[str] = []
    for _ in ends[0]:
        names.append(free_name(scene, "SUTURE", f"{name}_1" if name else "", names))
    _add(scene, ends, times, names)


def _add(scene: bpy.types.Scene, ends: Ends, times: SutureTimes, names: Sequence[str]) -> None:
    pairs = zip(names, *ends, strict=True)
    add_events(
        scene,
        [
            Suture(name, (point_value(a), point_value(b)), times.start, times.duration, times.stiffness)
            for name, a, b in pairs
        ],
    )


def ends_between(first: Sequence[Place], second: Sequence[Place], flip: bool, spacing: Spacing) -> Ends:
    """Return the ends of a run between two edges at rest, mm. flip: the second edge runs the other way."""
    edges = [list(first), list(second)]
    for name, edge in zip(("first", "second"), edges, strict=True):
        if len(edge) < 2 or length(edge) == 0.0:
            raise refused(ProblemCode.SUTURE_EDGE, "", name, count=len(edge))
    if flip:
        edges[1].reverse()
    shares = spacing.shares(0.5 * (length(edges[0]) + length(edges[1])))
    return along(edges[0], shares), along(edges[1], shares)


def ends_across(scene: bpy.types.Scene, incision: str, bite: float, spacing: Spacing) -> Ends:
    """Return the ends of a run across the incision of that name. bite: mm from its middle, 0 = at the wound's edge."""
    event = named_event(scene, incision)
    value = event_value(scene, event)
    if not isinstance(value, Incision):
        raise refused(ProblemCode.SUTURE_NOT_INCISION, event.name)
    skin, normals = _skin(scene)
    bite = bite if bite > 0.0 else 0.5 * value.kerf + BESIDE
    return across_incision(value, spacing.shares(length(incision_line(value))), bite, skin, normals)


def sunk(scene: bpy.types.Scene, points: NDArray[np.float64], depth: float) -> NDArray[np.float64]:
    """Return points (n, 3) on the skin moved into the tissue by `depth` mm."""
    if depth <= 0.0:
        return points
    skin, normals = _skin(scene)
    return np.asarray(points - depth * normals[skin.query(points)[0]], np.float64)


def _skin(scene: bpy.types.Scene) -> tuple[ClosestPoint, NDArray[np.float64]]:
    """The tissue's surface at rest and the normals (m, 3) of its triangles."""
    tissue = tissue_of(scene)
    triangles, _ = fan_triangles(tissue)
    return ClosestPoint(tissue.points, triangles), directions(area_normals(tissue.points[triangles]))
