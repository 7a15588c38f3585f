"""Which of the parts of a surface inside a region is meant: of a head with inner walls, the skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.axis_rays import AxisRays
from lappet.geometry.closest_point import closest_points
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.triangles import area_normals, areas, directions
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_report import Note, taken

_LINES = 500  # from so many triangles of a part it is seen which way the part faces
_AHEAD = 1e-6  # of the surface's extent: what a line meets nearer than this is the triangle that it starts from


def outer_part(surface: Mesh, inside: Mesh, center: NDArray[np.float64]) -> tuple[Mesh, list[Note]]:
    """Choose the connected part that is nearest to the region's center among those that face outwards.

    Where none faces outwards it is the nearest of all.

    Parameters
    ----------
    surface
        The whole surface, oriented.
    inside
        What of it lies in the region.
    center
        Center of the region in mm, shape (3,).

    Returns
    -------
    tuple[Mesh, list[Note]]
        The part, and what was left out; nothing where there is but one part.
    """
    label = parts_of(inside.triangles, len(inside.points))
    parts = [np.flatnonzero(label == number) for number in np.unique(label)]
    if len(parts) == 1:
        return inside.part(parts[0]), []
    corners = inside.points[inside.triangles]
    out = [part for part in parts if faces_out(surface, corners[part])]
    which = "that faces outwards" if out else "of all, as none faces outwards,"
    away = [float(closest_points(center[None], inside.points, inside.triangles[part])[2][0]) for part in out or parts]
    chosen = (out or parts)[int(np.argmin(away))]
    size, whole = areas(corners[chosen]).sum(), areas(corners).sum()
    value = f"of {len(parts)} the one {which} nearest to the region's center, {size:.4g} of {whole:.4g} mm²"
    return inside.part(chosen), [taken("part", value)]


def faces_out(surface: Mesh, corners: NDArray[np.float64]) -> bool:
    """Tell whether a part of a surface is seen from outside it.

    From its triangles lines run along the part's mean normal; the part faces outwards if at least half of them, by
    area, meet the surface no more. Triangles that face away from the mean normal are not asked.

    Parameters
    ----------
    surface
        The whole surface.
    corners
        Triangles of the part, oriented as the surface is, in its unit, shape (p, 3, 3).

    Returns
    -------
    bool
        Whether it faces outwards.
    """
    normals = area_normals(corners)
    ahead = directions(normals.sum(axis=0, keepdims=True))
    asked = np.flatnonzero(normals @ ahead[0] > 0.0)
    asked = asked[:: max(1, len(asked) // _LINES)]
    # The surface turned so that the lines run along an axis: the last of three directions at right angles.
    turn = np.roll(np.linalg.svd(ahead)[2], -1, axis=0)
    turn[2] = ahead[0]
    lines = AxisRays(surface.points @ turn.T, surface.triangles, 2).crossings(corners[asked].mean(axis=1) @ turn.T)
    near = _AHEAD * float(np.ptp(surface.points, axis=0).max())
    free = np.bincount(lines.line[lines.along > near], minlength=len(asked)) == 0
    weight = areas(corners[asked])
    return bool(weight[free].sum() >= 0.5 * weight.sum() > 0.0)
