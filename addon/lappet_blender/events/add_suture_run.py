"""Add a suture run to a scene: between two wound edges, or along both walls of an incision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import ClosestPoint
from lappet.procedure import Incision, SutureLayer, SutureOrder, SutureRun
from lappet.suturing.single_sutures import skin_of
from lappet.tissue.skin_sheet import SkinSheet

from ..model.event_kinds import PATTERN_OF
from ..model.event_values import event_value, free_name
from .add_events import Place, add_events, point_values
from .add_sutures import Spacing, SutureTimes
from .event_check import tissue_of
from .operator_values import named_event
from .stitch_shapes import Shape
from .suture_pairs import BESIDE, along, incision_line, length

NEAR_CUT = 3.0  # mm from an incision within which an edge is taken for one of its walls; chosen
ON_SKIN = 0.5  # mm from the skin within which an edge is drawn on it
_ON_CUT = 0.02  # mm from the middle of an incision within which an edge lies on neither side of it


@dataclass(frozen=True)
class RunEdges:
    """The edges of a run: points (n, 3) of both on the skin at rest, mm, and the sides of their tissue.

    bite: how far the bites lie in it, mm; None = as is usual. depth: how deep below the skin the edges were drawn.
    """

    first: NDArray[np.float64]
    second: NDArray[np.float64]
    sides: tuple[int, int]
    bite: float | None
    depth: float = 0.0


def edges_between(
    scene: bpy.types.Scene, first: Sequence[Place], second: Sequence[Place], flip: bool, shape: Shape
) -> RunEdges:
    """The edges through points at rest, mm. flip: the second runs the other way.

    Stitches hold the points themselves, those of a shape lie as far from them as is usual. The tissue of an edge lies
    away from the incision beside it, else away from the other edge. Edges on the underside are those of a deep layer.
    """
    edges = [np.array(edge, np.float64).reshape(-1, 3) for edge in (first, second)]
    for name, edge in zip(("first", "second"), edges, strict=True):
        if len(edge) < 2 or length(edge) == 0.0:
            raise refused(ProblemCode.SUTURE_EDGE, "", name, count=len(edge))
    if flip:
        edges[1] = edges[1][::-1]
    skin = skin_of(tissue_of(scene))
    depth = _depth_below(skin, np.vstack(edges))
    if depth > 0.0:
        edges = [skin.place(edge) for edge in edges]
    cuts = _incisions(scene)
    sides = tuple(_side(edges[k], edges[1 - k], skin, cuts) for k in (0, 1))
    bite = (shape.bite or None) if shape.is_loop else 0.0
    return RunEdges(edges[0], edges[1], (sides[0], sides[1]), bite, depth)


def edges_along(scene: bpy.types.Scene, incision: str, bite: float, shape: Shape) -> RunEdges:
    """Both walls of the incision of that name. bite: mm from its middle, 0 = at the wound's edge."""
    event = named_event(scene, incision)
    value = event_value(scene, event)
    if not isinstance(value, Incision):
        raise refused(ProblemCode.SUTURE_NOT_INCISION, event.name)
    line = skin_of(tissue_of(scene)).place(incision_line(value))
    if shape.is_loop:
        own = shape.bite + 0.5 * value.kerf + BESIDE if shape.bite > 0.0 else None
    else:
        own = bite if bite > 0.0 else 0.5 * value.kerf + BESIDE
    return RunEdges(line, line, (1, -1), own)


def add_suture_run(
    scene: bpy.types.Scene,
    edges: RunEdges,
    times: SutureTimes,
    shape: Shape,
    spacing: Spacing,
    *,
    order: SutureOrder = "halving",
    name: str = "",
) -> None:
    """Add a run along two edges as one event. name: "" = its kind and a number."""
    first, second, margin = edges.first, edges.second, None
    if spacing.inset_start is not None or spacing.inset_end is not None:
        shares = spacing.shares(0.5 * (length(first) + length(second)))
        first, second = _between(first, shares[0], shares[-1]), _between(second, shares[0], shares[-1])
        margin = 0.0
    size = 0.5 * (length(first) + length(second))
    apart = spacing.mm
    if spacing.count > 0:
        apart = size / max(spacing.count - (margin is not None), 1)
        # As many as asked for, though a scene keeps lengths in single precision.
        apart *= 1.0 - 1e-5
    run = SutureRun(
        free_name(scene, "SUTURE_RUN", name),
        (point_values(first), point_values(second)),
        times.start,
        edges.sides,
        duration=times.duration,
        spacing=min(apart, length(first), length(second)),
        margin=margin,
        bite=edges.bite,
        stiffness=times.stiffness,
        order=order,
    )
    if shape.is_loop:
        run = replace(run, pattern=PATTERN_OF[shape.kind], drawn=shape.drawn)
        run = replace(run, pass_depth=shape.depth) if shape.depth > 0.0 else run
    elif shape.depth > 0.0 or edges.depth > 0.0:
        run = replace(run, layers=(SutureLayer("deep", shape.depth or edges.depth),))
    add_events(scene, [run])


def _depth_below(skin: SkinSheet, points: NDArray[np.float64]) -> float:
    """How deep below the skin places lie that were drawn on the underside; 0 where they were not."""
    closest, normals = skin.at(points)
    depths = np.einsum("ij,ij->i", closest - points, normals)
    straight = np.linalg.norm(closest - points, axis=1) - depths < 0.1 * depths
    return float(np.median(depths)) if (straight & (depths > ON_SKIN)).all() else 0.0


def _incisions(scene: bpy.types.Scene) -> list[ClosestPoint]:
    """The lines of the scene's incisions, to look up the nearest point of each."""
    found = []
    for event in scene.lappet.events:
        if event.kind == "INCISION" and event.enabled and len(event.points) > 1:
            value = event_value(scene, event)
            if isinstance(value, Incision):
                line = incision_line(value)
                number = np.arange(len(line) - 1)
                found.append(ClosestPoint(line, np.stack([number, number + 1, number + 1], axis=1)))
    return found


def _side(edge: NDArray[np.float64], other: NDArray[np.float64], skin: SkinSheet, cuts: Sequence[ClosestPoint]) -> int:
    """The side of an edge on which its tissue lies: 1 to the left of its direction, -1 to the right."""
    shares = (np.arange(16) + 0.5) / 16
    points, ways = along(edge, shares), along(edge, shares + 0.02) - along(edge, shares - 0.02)
    left = np.cross(skin.at(points)[1], ways)
    away = points - along(other, shares)
    for cut in cuts:
        _, nearest, off = cut.query(points)
        if _ON_CUT < np.median(off) <= NEAR_CUT and off.max() <= 2.0 * NEAR_CUT:
            away = points - nearest
    return 1 if float(np.einsum("ij,ij->", away, left)) >= 0.0 else -1


def _between(line: NDArray[np.float64], first: float, last: float) -> NDArray[np.float64]:
    """The part of a polyline between two shares of its length."""
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]) / length(line)
    inside = line[(reached > first + 1e-6) & (reached < last - 1e-6)]
    return np.vstack([along(line, np.array([first])), inside, along(line, np.array([last]))])
