"""Burow's triangle: skin cut out beside the end of an incision, so that the longer lip becomes as long as the flap's.

Described by K. A. von Burow (1855).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.designs.design_axes import DesignPlane
from lappet.designs.flap_design import Corner, Excised, Seam
from lappet.designs.flat_curves import length as length_of
from lappet.designs.flat_curves import part, segment


@dataclass(frozen=True)
class Burow:
    """A triangle and how it is closed.

    Parameters
    ----------
    excised
        What is cut out.
    seam
        Its two sides.
    corner
        The corner of the lip that comes to the end of the cut.
    """

    excised: Excised
    seam: Seam
    corner: Corner


def burow_triangle(
    plane: DesignPlane,
    name: str,
    lip: NDArray[np.float64],
    base: float,
    side: int,
    tall: float = 1.6,
) -> Burow:
    """Draw a triangle on the last part of a lip.

    Parameters
    ----------
    plane
        The plane of the design.
    name
        Name of the triangle, of its seam and its corner.
    lip
        The lip in the plane in mm, its end where the cut ends, shape (k, 2).
    base
        Length of the triangle's base on the lip in mm.
    side
        1 where the triangle lies to the left of the lip, -1 to the right.
    tall
        Height of the triangle in bases.

    Returns
    -------
    Burow
        The triangle.
    """
    whole = length_of(lip)
    foot = part(lip, whole - base, whole)
    along = foot[-1] - foot[0]
    apex = foot.mean(axis=0) + side * tall * np.array([-along[1], along[0]])
    before, after = segment(foot[0], apex), segment(foot[-1], apex)
    outline = np.vstack([foot[:-1], after[:-1], before[:0:-1]])
    seed = (foot.mean(axis=0) * 2.0 + apex) / 3.0
    up = apex - foot.mean(axis=0)
    ahead, behind = foot[0] - 0.5 * along + 0.3 * up, foot[-1] + 0.5 * along + 0.3 * up
    return Burow(
        plane.excised(name, outline, seed),
        Seam(name, (plane.edge_beside(before, ahead), plane.edge_beside(after, behind))),
        Corner(name, plane.spot(foot[0], ahead), plane.spot(foot[-1], behind)),
    )
