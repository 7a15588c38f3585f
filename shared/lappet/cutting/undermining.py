"""Undermining: frees the bed faces below the area inside a closed curve on the skin.

A bed face is freed when it belongs to a part of the tissue inside the curve (`area_parts.py`), so "below" follows the
normals of a curved scalp and not one projection. Bed faces on the line are split along it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.area_parts import LINE_KERF, AreaParts
from lappet.cutting.ribbon import skin_ribbons
from lappet.geometry.labeled_surface import Surface
from lappet.geometry.solid import LabeledSolid
from lappet.geometry.split_edges import split_edges
from lappet.geometry.surface_check import directed_edges, unique_edges
from lappet.procedure import Undermine
from lappet.tissue.rest_skin import RestSkin

_FEW = 40  # vertices inside; more follow the curve well enough
_SHORT, _MANY, _ROUNDS = 0.3, 3000, 40  # edges over the width of an area with few; faces in the box around it


def undermine(
    surface: Surface, rest: LabeledSolid, skin: RestSkin, event: Undermine, spacing: float, timeline: str
) -> Surface:
    """Free the bed faces inside a curve, split along it.

    Parameters
    ----------
    surface
        Surface of the current epoch.
    rest
        The uncut tissue as a solid.
    skin
        The uncut skin.
    event
        The event with the curve.
    spacing
        Lattice spacing in mm.
    timeline
        Path of the prims' parent, for messages.

    Returns
    -------
    Surface
        The surface with `bed` false inside the curve.

    Raises
    ------
    RefusedError
        If the curve cannot be followed, misses the tissue or does not part it, or has no bed below it.
    """
    prim = f"{timeline}/{event.name}"
    kerf = LINE_KERF * min(spacing, 1.0)
    ribbons = skin_ribbons(skin, event.points, prim=prim, basis=event.basis, closed=True, kerf=kerf, spacing=spacing)
    parts = AreaParts(rest, ribbons, kerf, spacing)
    if not parts.is_parted:
        raise refused(ProblemCode.AREA_NOT_PARTED, prim, place=Place.at(*event.points))
    if not parts.inside.any():
        raise refused(ProblemCode.UNDERMINE_NO_AREA, prim)
    below, inside = _inside(surface, parts)
    if np.count_nonzero(inside) < _FEW:  # most of a small or narrow area lies between the vertices
        surface = _refined(surface, *parts.box(), parts.width)
        below, inside = _inside(surface, parts)

    t = surface.triangles[below]
    edges = unique_edges(directed_edges(t))[0]
    crossing = edges[inside[edges[:, 0]] != inside[edges[:, 1]]]
    if len(crossing):
        distance = parts.line.query(surface.points[crossing].reshape(-1, 3))[2].reshape(-1, 2)
        at = distance[:, 0] / np.maximum(distance.sum(axis=1), 1e-300)
        before = len(surface.points)
        surface = split_edges(surface, crossing, np.clip(at, 0.1, 0.9))
        # After the split no triangle has vertices on both sides; the new vertices lie on the line.
        side = np.concatenate([inside, np.zeros(len(surface.points) - before, bool)])
    else:
        side = inside
    freed = surface.bed & side[surface.triangles].any(axis=1)
    if not freed.any():
        raise refused(ProblemCode.UNDERMINE_NO_BED, prim)
    return Surface(
        points=surface.points,
        triangles=surface.triangles,
        uv=surface.uv,
        origin=surface.origin,
        fixed=surface.fixed,
        bed=surface.bed & ~freed,
        grips=surface.grips,
    )


def _inside(surface: Surface, parts: AreaParts) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The bed faces, and which vertices (n,) of theirs lie inside the curve."""
    below = np.flatnonzero(surface.bed)
    inside = np.zeros(len(surface.points), bool)
    vertices = np.unique(surface.triangles[below])
    inside[vertices] = parts.contain(surface.points[vertices])
    return below, inside


def _refined(surface: Surface, low: NDArray[np.float64], high: NDArray[np.float64], width: float) -> Surface:
    """The surface with short edges in the bed faces that reach into a box, for an area so wide (mm)."""
    extent = np.sort(high - low)
    longest = max(_SHORT * width, float(np.sqrt(extent[1] * extent[2] / _MANY)))
    for _ in range(_ROUNDS):
        corners = surface.points[surface.triangles]
        near = surface.bed & ((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1)
        t = surface.triangles[near]
        edges = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2), axis=2)
        length = np.linalg.norm(np.diff(surface.points[edges], axis=2)[:, :, 0], axis=2)
        # Halve edges that are the longest one of every face here that has them: no face is split twice.
        key, which = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
        which = which.reshape(-1, 3)
        order = np.lexsort((which, length), axis=1)[:, -1]
        wanted = np.bincount(np.take_along_axis(which, order[:, None], axis=1)[:, 0], minlength=len(key))
        size = np.linalg.norm(surface.points[key[:, 0]] - surface.points[key[:, 1]], axis=1)
        chosen = key[(wanted == np.bincount(which.ravel(), minlength=len(key))) & (size > longest)]
        if len(chosen) == 0:
            break
        surface = split_edges(surface, chosen, np.full(len(chosen), 0.5))
    return surface
