"""How much of a wound is left open: what lies between skin edges that sutures do not bring together."""

from __future__ import annotations

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_source import SkinSource
from lappet.geometry.border_loops import border_loops
from lappet.geometry.labeled_surface import FaceOrigin

_HALF_GAP = 1.5  # mm: a seam that gapes by less than twice this is closed
_SAME = 1e-4  # mm: by no more than that corners of an outline are off those of the skin


def open_area(source: SkinSource, time: float, normal: NDArray[np.float64]) -> float:
    """Measure the wound that gapes at a frame, seen along the skin's normal.

    Parameters
    ----------
    source
        The solved procedure.
    time
        Time code of the frame.
    normal
        Unit normal of the surgical field, shape (3,).

    Returns
    -------
    float
        The area in mm² that is left of the gaps between the edges of the skin when 1.5 mm are taken off all around.
    """
    epoch = source.epoch_at(time)
    skin = epoch.triangles[epoch.origin == FaceOrigin.SKIN].astype(np.int64)
    walls = epoch.triangles[epoch.origin == FaceOrigin.WOUND_WALL].astype(np.int64)
    edges = np.intersect1d(skin, walls)
    if not len(edges):
        return 0.0
    first, second = np.linalg.svd(normal[None])[2][1:]
    across = np.stack([first, second if np.cross(first, second) @ normal > 0.0 else -second])
    flat = source.positions(epoch, time).astype(np.float64) @ across.T
    # Skin that lies on skin counts once: what is seen of the sheet has the winding number of its borders.
    sheet = manifold3d.CrossSection([flat[loop] for loop in border_loops(skin)], manifold3d.FillRule.Positive)
    lips = flat[edges]
    found = 0.0
    for outline in sheet.to_polygons():
        if np.abs(outline[:, None] - lips).max(axis=2).min() < _SAME:
            # Nothing where it is no hole; of one around an island only what this does not fill.
            gap = manifold3d.CrossSection([outline], manifold3d.FillRule.Negative) - sheet
            found += gap.offset(-_HALF_GAP).area()
    return found
