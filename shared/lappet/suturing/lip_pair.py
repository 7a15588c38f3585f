"""Places on the two edges of a wound that meet when it is closed, and the bites of a stitch there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Point
from lappet.procedure.stitches import Bite
from lappet.tissue.skin_sheet import SkinSheet

# How far into the tissue a deep bite lies for each mm of its depth: what the wall of a cut through curved tissue, made
# of chords, drifts from the skin's normal at most, or the bite would be in the other wall. Measured on the examples:
# less than 0.03.
DRIFT = 0.05
_AT_POINT = 1e-9  # mm


class LipPlace(NamedTuple):
    """A place on one edge of a wound.

    Parameters
    ----------
    point
        The place on the edge in mm, shape (3,).
    along
        Direction of the edge, of any length, shape (3,).
    inward
        Direction into its tissue in place of the one square to the edge, of any length, shape (3,), as in a corner; or
        None.
    """

    point: NDArray[np.float64]
    along: NDArray[np.float64]
    inward: NDArray[np.float64] | None = None


def on_edge(points: NDArray[np.float64], share: float) -> LipPlace:
    """Find the place at a share of an edge's length.

    Parameters
    ----------
    points
        Points along the edge in mm, shape (n, 3).
    share
        Share of its length, 0 to 1.

    Returns
    -------
    LipPlace
        The place.
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = share * along[-1]
    # At a point of the edge the piece after it counts, however the sum of lengths was rounded.
    k = min(int(np.searchsorted(along, at + _AT_POINT, side="right")), len(points) - 1)
    spot = points[k - 1] + (at - along[k - 1]) / (along[k] - along[k - 1]) * (points[k] - points[k - 1])
    low, high = max(k - 2, 0), min(k + 1, len(points) - 1)  # the direction of a curved edge, over its neighbors too
    return LipPlace(spot, points[high] - points[low])


def in_corner(points: NDArray[np.float64], index: int, side: int, skin: SkinSheet) -> LipPlace:
    """Find the place in a corner of an edge.

    Parameters
    ----------
    points
        Points along the edge in mm, shape (n, 3).
    index
        Number of the corner among them, neither the first nor the last.
    side
        1 where the tissue lies to the left of the edge's direction, -1 to the right.
    skin
        The skin.

    Returns
    -------
    LipPlace
        The place, and the direction that halves the corner.
    """
    spot = points[index]
    before, after = spot - points[index - 1], points[index + 1] - spot
    before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
    normal = skin.at(spot)[1][0]
    inward = side * np.cross(normal, before + after)
    size = float(np.linalg.norm(inward))
    # An edge that turns back on itself ends in a cut's tip, around which the tissue lies ahead, or behind.
    return LipPlace(spot, before + after if size > 1e-6 else before, inward / size if size > 1e-6 else before)


@dataclass(frozen=True, eq=False)
class LipPair:
    """A place of a stitch on a wound whose edges may lie anywhere at rest: a `StitchPlace`.

    Parameters
    ----------
    lips
        The place on each edge.
    sides
        The side on which the tissue of each lies, 1 to the left of its direction, -1 to the right.
    skin
        The skin.
    reached
        Where the place is along the closed wound in mm.
    """

    lips: tuple[LipPlace, LipPlace]
    sides: tuple[int, int]
    skin: SkinSheet
    reached: float = 0.0

    def bite(self, side: int, distance: float, depth: float = 0.0, along: float = 0.0) -> Bite:
        """Find a point of the tissue beside the wound.

        Parameters
        ----------
        side
            -1 or 1: beside the first or the second edge.
        distance
            Distance from it in mm.
        depth
            Depth below the skin in mm.
        along
            How far along the wound in mm.

        Returns
        -------
        Bite
            The point in mm at rest, and where it is when the lips meet, on a straight wound.
        """
        closed = np.array([side * distance, self.reached + along, -depth])
        return Bite(np.array(self.point(0 if side < 0 else 1, distance, depth, along)), closed)

    def point(self, edge: int, distance: float, depth: float = 0.0, along: float = 0.0) -> Point:
        """Find a point of the tissue beside one of the edges.

        Parameters
        ----------
        edge
            0 or 1.
        distance
            Distance from it in mm.
        depth
            Depth below the skin in mm.
        along
            How far along it in mm.

        Returns
        -------
        Point
            The point in mm, rounded.
        """
        lip, side = self.lips[edge], self.sides[edge]
        spot = lip.point
        if along:
            spot = spot + along * lip.along / np.linalg.norm(lip.along)
        if lip.inward is not None:
            return self.skin.towards(spot, spot + lip.inward, 2.0 * distance, depth)
        return self.skin.beside(spot, lip.along, side * distance, depth)
