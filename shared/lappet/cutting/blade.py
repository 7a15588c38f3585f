"""A blade with a direction of its own: which part of a curve on the skin it meets, and how it leaves the tissue there.

Square to the skin, the sections of a cut over a rolled rim, such as the border of a lip, turn with the skin until they
cross each other, and the ray that measures the thickness runs along the rim instead of through it. A blade that keeps
its direction cuts where the skin faces it; where the curve rolls out of its sight the cut runs on straight, out of the
tissue.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import place
from lappet.procedure import Point
from lappet.tissue.rest_skin import SkinPoints

PAST_RIM = -1.0  # instead of a distance beyond the border: in the air beside a rim that has no border there
_PROGRESS = 0.2  # of a step: a sample that leads on by less is left out
FACING = 12.0  # degrees between skin and blade at least: flatter skin is out of its sight


def along_blade(
    placed: SkinPoints, drawn: NDArray[np.float64], direction: Point, closed: bool, margin: float, prim: str
) -> SkinPoints:
    """Take the part of a curve that a blade meets, with the blade's direction in place of the normals.

    Parameters
    ----------
    placed
        Samples of the curve on the skin.
    drawn
        The same samples as they were drawn, some of them in the air beside a rim, in mm, shape (k, 3).
    direction
        Direction in which the blade goes into the tissue, of any length.
    closed
        Whether the curve returns to its first sample.
    margin
        How far in mm the cut goes on past the last of the curve that has rolled out of the blade's sight.
    prim
        Path of the prim, for messages.

    Returns
    -------
    SkinPoints
        The samples, in order. Where the curve rolls out of sight, or is drawn in the air beside a rim, samples follow
        beside the skin (`PAST_RIM`); after every stretch comes one at an infinite distance, at which a curve is broken.

    Raises
    ------
    RefusedError
        If the direction is none, or the skin faces the blade nowhere along the curve.
    """
    blade = np.asarray(direction, np.float64)
    size = float(np.linalg.norm(blade))
    if not (np.isfinite(size) and size > 0.0):
        raise refused(ProblemCode.CUT_DIRECTION, prim, place(blade))
    up = -blade / size
    aside = drawn - placed.points
    aside -= np.outer(aside @ up, up)
    in_air = (placed.height > 0.0) & (np.linalg.norm(aside, axis=1) > margin)
    facing = (placed.normals @ up > np.sin(np.radians(FACING))) & ~in_air
    if np.count_nonzero(facing) < 2:
        at = Place.at(placed.points[0], placed.points[-1])
        raise refused(ProblemCode.CUT_FROM_BEHIND, prim, place(blade), place=at, least=FACING)
    count = len(facing)
    facing |= placed.beyond > 0.0  # past the border, in its tangent plane
    if facing.all():
        return SkinPoints(placed.points, np.tile(up, (count, 1)), placed.height, placed.beyond)

    shift = int(np.flatnonzero(~facing)[0]) if closed else 0
    order = np.roll(np.arange(count), -shift)
    points, beyond, seen, drawn = placed.points[order], placed.beyond[order], facing[order], drawn[order]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    chosen: list[NDArray[np.float64]] = []
    off: list[NDArray[np.float64]] = []
    for k, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        before = drawn[(stops[k - 1] if k else 0) : start]
        after = drawn[stop : (starts[k + 1] if k + 1 < len(starts) else count)]
        if closed and k + 1 == len(starts):  # the order begins with what is out of sight: a curve comes round to it
            after = np.vstack([after, drawn[: starts[0]]])
        run = points[start:stop]
        first, last = _beside_rim(run[::-1], before[::-1], up, margin)[::-1], _beside_rim(run, after, up, margin)
        chosen += [first, run, last, run[-1:]]
        off += [np.full(len(first), PAST_RIM), beyond[start:stop], np.full(len(last), PAST_RIM), np.array([np.inf])]
    on_blade = np.vstack(chosen)
    return SkinPoints(on_blade, np.tile(up, (len(on_blade), 1)), np.zeros(len(on_blade)), np.concatenate(off))


def _beside_rim(
    run: NDArray[np.float64], rolled: NDArray[np.float64], up: NDArray[np.float64], margin: float
) -> NDArray[np.float64]:
    """The way of the blade's edge after a run, past all that has rolled out of sight there, shape (k, 3).

    It follows what was drawn as far as that leads onward, no lower than the run's last point, and then straight on.
    """
    nothing = np.zeros((0, 3))
    if not len(rolled) or len(run) < 2:
        return nothing
    way = run[-1] - run[-2]
    step = float(np.linalg.norm(way))
    way = way - (way @ up) * up
    if not np.linalg.norm(way) > 0.0:
        return nothing
    way /= np.linalg.norm(way)
    onward = (rolled - run[-1]) @ way
    leads = onward > np.concatenate([[0.0], np.maximum.accumulate(onward)[:-1]]).clip(0.0) + _PROGRESS * step
    if not leads.any():
        return nothing
    offset = rolled[leads] - run[-1]
    height = offset @ up
    on = run[-1] + offset + np.outer(np.maximum(height, 0.0) - height, up)
    return np.vstack([on, on[-1:] + margin * way])
