"""Flaps of several lobes about one pivot: each lobe turns into the place of the one before, the first into the defect.

In the design's plane the pivot P is the origin and the defect's middle lies two radii r away on the x axis: P is
one radius from the defect's edge. From P two lines touch the defect: the skin between them (a standing cone to come) is
cut out with it. From the defect's widest place S (at 26.6° and sqrt(5) r from P) the lobes follow each other about P,
each on the chord of its angle:

- all but the last are half ellipses one radius high: the first turns onto the far half of the defect;
- the last is pointed, so that its donor site closes in a line.

The tip of the skin between two lobes meets the notch on the other side of the next lobe, and that beside the last one
the end of the cut.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.designs.design_axes import DesignPlane
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, bow, length, part, segment

_NAMES = ("first", "second", "third")


def lobed_flap(plane: DesignPlane, r: float, angles: Sequence[float], height: float) -> FlapDesign:
    """Draw a flap of two or three lobes.

    Parameters
    ----------
    plane
        The plane of the design, the pivot its origin.
    r
        Radius of the defect in mm.
    angles
        Angle of each lobe about the pivot in degrees.
    height
        Height of the last lobe over its chord, in radii of the defect.

    Returns
    -------
    FlapDesign
        The design.
    """
    pivot, middle = np.zeros(2), np.array([2.0 * r, 0.0])
    touch = np.sqrt(3.0) * r * np.array([np.cos(np.pi / 6.0), np.sin(np.pi / 6.0)])
    start = np.array([2.0 * r, r])  # S
    feet = [start, *(_turned(start, float(turn)) for turn in np.cumsum(angles))]
    last = len(angles) - 1
    lobes = [bow(feet[k], feet[k + 1], -r, step=0.5) for k in range(last)]
    lobes.append(bow(feet[last], feet[last + 1], -height * r, pointed=True, step=0.5))
    far = arc(middle, r, -90.0, 90.0, step=0.5)
    near = np.vstack([segment(pivot, touch), arc(middle, r, 120.0, 90.0, step=0.5)[1:]])  # from P to S
    across = near * np.array([1.0, -1.0])  # from P to the other side's widest place
    flaps = [0.5 * (feet[k] + feet[k + 1]) * 1.05 for k in range(len(lobes))]
    around = np.vstack([across[:-1], far[:-1], near[:0:-1]])
    into = (start + NICK * _unit(middle - start))[None]
    return FlapDesign(
        (plane.excised("defect", around, middle),),
        (plane.points(np.vstack([into, *(lobe[:-1] for lobe in lobes[:-1]), lobes[-1]])),),
        _seams(plane, near, across, far, lobes),
        _corners(plane, feet, lobes, flaps),
        _carries(plane, r, lobes, flaps),
        tuple(plane.point(flap) for flap in flaps),
    )


def _seams(
    plane: DesignPlane,
    near: NDArray[np.float64],
    across: NDArray[np.float64],
    far: NDArray[np.float64],
    lobes: list[NDArray[np.float64]],
) -> tuple[Seam, ...]:
    """The flap's base, the first lobe in the defect, each next in the place before, and the last one's donor site."""
    *_, before, tall = lobes
    top, tip = _half(before)[1], _half(tall)[1]
    lead, trail = part(before, 0.0, top), part(before, top, length(before))
    up, down = part(tall, 0.0, tip), part(tall, tip, length(tall))
    name = _NAMES[len(lobes) - 1]
    return (
        Seam("donor", (plane.edge(up, -1), plane.edge(down[::-1], 1))),
        Seam("base", (plane.edge(near, 1), plane.edge(across, -1))),
        Seam("defect", (plane.edge(lobes[0], 1), plane.edge(far, -1))),
        *(Seam(_NAMES[k], (plane.edge(lobes[k], 1), plane.edge(lobes[k - 1], -1))) for k in range(1, len(lobes) - 1)),
        Seam(f"{name}_up", (plane.edge(up, 1), plane.edge(lead, -1))),
        Seam(f"{name}_down", (plane.edge(down, 1), plane.edge(trail, -1))),
    )


def _corners(
    plane: DesignPlane,
    feet: list[NDArray[np.float64]],
    lobes: list[NDArray[np.float64]],
    flaps: list[NDArray[np.float64]],
) -> tuple[Corner, ...]:
    """The tips of skin between the lobes, each with its notch, and the last lobe's tip."""
    end, between = feet[-1], feet[-2]
    corners = [Corner("donor", plane.spot(between, 1.4 * between), plane.spot(end, end + 0.3 * (end - flaps[-1])))]
    for k in range(1, len(lobes)):
        inwards = plane.spot(feet[k], 0.6 * feet[k])
        before = feet[k - 1]
        spike = plane.spot(before, before + _spike(lobes[0]) if k == 1 else 1.4 * before)
        corners.append(Corner(_NAMES[k - 1], inwards, spike))
    tip, top = _half(lobes[-1])[0], _half(lobes[-2])[0]
    return (*corners, Corner(_NAMES[len(lobes) - 1], plane.spot(tip, flaps[-1]), plane.spot(top, 1.4 * top)))


def _carries(
    plane: DesignPlane, r: float, lobes: list[NDArray[np.float64]], flaps: list[NDArray[np.float64]]
) -> tuple[Carry, ...]:
    """Each lobe by its tip about the pivot: the first onto the defect's far side, the next onto the one before."""
    pivot = plane.point((0.0, 0.0))
    tips = [_half(lobe)[0] for lobe in lobes]
    lays = [Spot(plane.point((3.0 * r, 0.0)), plane.point((2.0 * r, 0.0)))]
    lays += [Spot(plane.point(tip), plane.point(flap)) for tip, flap in zip(tips[:-1], flaps[:-1], strict=True)]
    return tuple(
        Carry(name, plane.spot(tip, flap), pivot, lay)
        for name, tip, flap, lay in zip(_NAMES, tips, flaps, lays, strict=False)
    )


def _turned(point: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """A point turned counter-clockwise about the origin, degrees."""
    turn = np.radians(angle)
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ point


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


def _half(curve: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The point in the middle of a curve, and its distance along it."""
    half = 0.5 * length(curve)
    return part(curve, 0.0, half)[-1], half


def _spike(lobe: NDArray[np.float64]) -> NDArray[np.float64]:
    """Into the skin between the defect, which runs along x at S, and the first lobe."""
    return _unit(_unit(lobe[1] - lobe[0]) + np.array([1.0, 0.0]))
