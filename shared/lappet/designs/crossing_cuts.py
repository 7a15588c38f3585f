"""Cuts of a design that cross each other, where limbs are too long or too bent: no flap could be lifted there."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from lappet.designs.flap_design import FlapDesign
from lappet.designs.flat_curves import NICK
from lappet.procedure import Point

_APART = 0.01  # mm between two chords that cross in one plane
_SAME = 1e-6  # share of a chord beside its ends: curves may meet in points of theirs


def crossing_cuts(design: FlapDesign) -> Point | None:
    """Find where two cuts of a design cross, or one itself.

    An incision may begin or end in what is excised, and cuts may meet in a point of both. What is cut out late is left
    out: it has a part of the defect's rim.

    Parameters
    ----------
    design
        The design in its plane: on curved skin chords of lines that lie on each other weave about each other.

    Returns
    -------
    Point | None
        A point in mm where they cross; None where none do.
    """
    closed = [np.array([*cut.outline, cut.outline[0]]) for cut in design.excised if not cut.late]
    open_ones = [np.array(curve) for curve in design.incisions]
    curves = [*((curve, False) for curve in closed), *((curve, True) for curve in open_ones)]
    for (one, one_open), (other, other_open) in combinations_with_replacement(curves, 2):
        found = _crossings(one, other)
        if one is not other:
            ends = [
                end for curve, is_open in ((one, one_open), (other, other_open)) if is_open for end in curve[[0, -1]]
            ]
            for end in ends:
                found = found[np.linalg.norm(found - end, axis=1) > 3.0 * NICK]
        if len(found):
            x, y, z = found[0]
            return (float(x), float(y), float(z))
    return None


def _crossings(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where chords of two curves (k, 3) come as near as `_APART` between their ends, points (c, 3)."""
    first, second = np.indices((len(one) - 1, len(other) - 1)).reshape(2, -1)
    if one is other:
        first, second = np.triu_indices(len(one) - 1, 2)
    start, u = one[first], one[first + 1] - one[first]
    between, v = other[second] - start, other[second + 1] - other[second]
    normal = np.cross(u, v)
    area = np.einsum("ij,ij->i", normal, normal)
    slanted = area > 1e-9 * np.einsum("ij,ij->i", u, u) * np.einsum("ij,ij->i", v, v)
    area = np.where(slanted, area, 1.0)
    s = np.einsum("ij,ij->i", np.cross(between, v), normal) / area
    t = np.einsum("ij,ij->i", np.cross(between, u), normal) / area
    apart = np.abs(np.einsum("ij,ij->i", between, normal)) / np.sqrt(area)
    inner = slanted & (apart < _APART)
    for share in (s, t):
        inner &= (share > _SAME) & (share < 1.0 - _SAME)
    return start[inner] + s[inner, None] * u[inner]
