"""Threads, knots, hooks and vessels as tubes that move and keep their triangles.

Every line has its place among the others in all frames. Where it is not drawn it lies, without thickness, where it is
drawn next to that time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import surgical_field
from lappet.drawing.hook_steel import HookSteel
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.surface_look import STEEL_LOOK, THREAD_LOOK, SurfaceLook
from lappet.drawing.suture_path import THREAD_RADIUS
from lappet.drawing.suture_thread import SutureThread, buried_sutures
from lappet.drawing.tube_shape import tube_faces, tube_points
from lappet.export.moving_shape import MovingShape
from lappet.procedure.vessel import VESSEL_COLORS, VESSEL_KINDS

_THREAD_SIDES, _STEEL_SIDES, _VESSEL_SIDES = 6, 10, 12

Line = tuple[NDArray[np.float64], NDArray[np.float64] | float]


def instrument_shapes(cache: SkinCache, frames: Sequence[float]) -> list[MovingShape]:
    """Draw threads, knots and skin hooks as pictures have them; what lies in the depth is left out.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes, ascending.

    Returns
    -------
    list[MovingShape]
        The threads and the hooks, as far as there are any.
    """
    field = surgical_field(cache, cache.frames)
    axes = np.stack([field.right, field.up, field.normal])
    scale = field.stitch_scale
    threads = SutureThread(cache, axes[0] + 0.6 * axes[1], scale, buried_sutures(cache))
    hooks = HookSteel(cache, axes, field.center, scale)
    radius = THREAD_RADIUS * scale
    drawn: tuple[tuple[str, SurfaceLook, int, list[dict[Any, Line]]], ...] = (
        ("threads", THREAD_LOOK, _THREAD_SIDES, [_thick(threads.named_lines(time), radius) for time in frames]),
        ("hooks", STEEL_LOOK, _STEEL_SIDES, [dict(hooks.named_tubes(time)) for time in frames]),
    )
    shapes = [tube_shape(name, look, sides, frames, lines) for name, look, sides, lines in drawn]
    return [shape for shape in shapes if shape is not None]


def vessel_shapes(cache: SkinCache, frames: Sequence[float]) -> list[MovingShape]:
    """Draw vessels and nerves: a shape for each epoch, which cuts them anew, and each kind.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes, ascending.

    Returns
    -------
    list[MovingShape]
        The shapes.
    """
    shapes = []
    for epoch in cache.epochs:
        own = [time for time in frames if time in epoch.frames]
        lines = [dict(enumerate(cache.vessels(time))) for time in own]
        for kind in VESSEL_KINDS:
            pieces: list[dict[Any, Line]] = [
                {k: (vessel.points, vessel.radius) for k, vessel in each.items() if vessel.kind == kind}
                for each in lines
            ]
            look = SurfaceLook(kind.capitalize(), kind.capitalize(), VESSEL_COLORS[kind], 0.34)
            shape = tube_shape(f"{kind} {epoch.name}", look, _VESSEL_SIDES, own, pieces)
            shapes += [shape] if shape else []
    return shapes


def _thick(lines: Mapping[tuple[int, int], NDArray[np.float64]], radius: float) -> dict[Any, Line]:
    return {key: (line, radius) for key, line in lines.items()}


def tube_shape(
    name: str,
    look: SurfaceLook,
    sides: int,
    frames: Sequence[float],
    lines: Sequence[Mapping[Any, Line]],
) -> MovingShape | None:
    """Make tubes of lines.

    Parameters
    ----------
    name
        Name of the shape.
    look
        What it looks like.
    sides
        How many points a ring of a tube has.
    frames
        Time codes, ascending.
    lines
        For each of them the lines that are drawn by what they are: points in mm, shape (k, 3), and a radius in mm, or
        one for each point, shape (k,).

    Returns
    -------
    MovingShape | None
        The tubes in the frames from the first to the last in which any is drawn; None where none is.
    """
    drawn = [k for k, own in enumerate(lines) if own]
    if not drawn:
        return None
    span = range(drawn[0], drawn[-1] + 1)
    keys = list(dict.fromkeys(key for own in lines for key in own))
    slots = [_slot([lines[k].get(key) for k in span]) for key in keys]
    lengths = [len(slot[0][0]) for slot in slots]
    positions: list[NDArray[np.float32]] = []
    normals: list[NDArray[np.float32]] = []
    for number in range(len(span)):
        own = [slot[number][0] for slot in slots]
        center = np.repeat(np.concatenate(own), sides, axis=0)
        spoke = tube_points(own, [1.0] * len(own), sides) - center
        if normals:
            spoke = _turned(spoke, normals[-1], lengths, sides)
        radii = np.repeat(np.concatenate([slot[number][1] for slot in slots]), sides)
        positions.append((center + radii[:, None] * spoke).astype(np.float32))
        normals.append(spoke.astype(np.float32))
    times = tuple(frames[k] for k in span)
    parts = ((look, _triangles(lengths, sides)),)
    return MovingShape(name, parts, times, np.stack(positions), np.stack(normals))


def _slot(line: Sequence[Line | None]) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """A line in all frames, with as many points in each; where it is not drawn, without thickness."""
    known = [k for k, each in enumerate(line) if each is not None]
    count = max(len(each[0]) for each in line if each is not None)
    slot = []
    for k in range(len(line)):
        points, radius = line[min(known, key=lambda other: (abs(other - k), other))]  # type: ignore[misc]
        points, radii = _resampled(points, np.broadcast_to(np.asarray(radius, np.float64), len(points)), count)
        slot.append((points, radii if line[k] is not None else np.zeros(count)))
    return slot


def _resampled(
    points: NDArray[np.float64], radii: NDArray[np.float64], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A line with `count` points: its own and, in the longest stretches between them, others."""
    while len(points) < count:
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        longest = np.sort(np.argsort(-lengths, kind="stable")[: count - len(points)])
        points = np.insert(points, longest + 1, 0.5 * (points[longest] + points[longest + 1]), axis=0)
        radii = np.insert(radii, longest + 1, 0.5 * (radii[longest] + radii[longest + 1]))
    return points, radii


def _turned(
    spokes: NDArray[np.float64], before: NDArray[np.float32], lengths: Sequence[int], sides: int
) -> NDArray[np.float64]:
    """The spokes numbered as they lie nearest to those of the frame before: no tube is wrung between two frames."""
    placed, begin = [], 0
    for length in lengths:
        end = begin + length * sides
        own, last = (each[begin:end].reshape(length, sides, 3) for each in (spokes, before))
        shifts = [float((np.roll(own, shift, axis=1) * last).sum()) for shift in range(sides)]
        placed.append(np.roll(own, int(np.argmax(shifts)), axis=1).reshape(-1, 3))
        begin = end
    return np.concatenate(placed)


def _triangles(lengths: Sequence[int], sides: int) -> NDArray[np.int32]:
    corners, starts = tube_faces(lengths, sides)
    found = [(face[0], face[k], face[k + 1]) for face in np.split(corners, starts[1:]) for k in range(1, len(face) - 1)]
    return np.array(found, np.int32).reshape(-1, 3)
