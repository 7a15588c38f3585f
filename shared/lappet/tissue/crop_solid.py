"""Crop closed tissue to a sphere or a box: what lies inside stays a closed solid, and is held where it was cut off."""

from __future__ import annotations

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import closest_points
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.solid import Label, LabeledSolid
from lappet.geometry.surface_check import place
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_report import Note, taken
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.surgical_field import Box, Sphere

_EDGE = 5.0  # degrees of a sphere's facets


def crop_solid(mesh: Mesh, region: Sphere | Box, name: str) -> tuple[Mesh, NDArray[np.bool_], list[Note]]:
    """Take what of a closed mesh lies inside a region: the piece nearest to its middle.

    Parameters
    ----------
    mesh
        The mesh, closed and oriented outwards, cavities inwards.
    region
        The region.
    name
        What messages call the mesh.

    Returns
    -------
    tuple[Mesh, NDArray[np.bool_], list[Note]]
        The piece; which of its triangles lie on the region's border, shape (m,); and what was taken.

    Raises
    ------
    RefusedError
        If nothing lies inside, or the mesh is no solid.
    """
    uv = np.zeros((len(mesh.triangles), 3, 2)) if mesh.uv is None else mesh.uv
    nothing = np.zeros(len(mesh.triangles), bool)
    origin = np.full(len(mesh.triangles), FaceOrigin.SKIN, np.uint8)
    whole = Surface(mesh.points, mesh.triangles.astype(np.int32), uv.astype(np.float32), origin, nothing, nothing)
    labeled = LabeledSolid.from_surface(whole)
    cutter, middle = _cutter(region)
    pieces = (labeled.solid ^ cutter).decompose()
    if not pieces:
        low, high = place(mesh.points.min(axis=0)), place(mesh.points.max(axis=0))
        raise refused(ProblemCode.REGION_EMPTY, name, low=low, high=high)
    border = {cutter.original_id(): Label(FaceOrigin.RIM, fixed=True)}
    surfaces = [labeled.with_solid(piece, border).surface() for piece in pieces]
    away = [float(closest_points(middle[None], each.points, each.triangles)[2][0]) for each in surfaces]
    chosen = surfaces[int(np.argmin(away))]
    kind = "sphere" if isinstance(region, Sphere) else "box"
    notes = [taken("region", f"the solid inside a {kind} around {place(middle)}, held where it was cut off")]
    if len(pieces) > 1:
        notes.append(taken("part", f"of {len(pieces)} pieces the one nearest to the region's center"))
    cut_uv = chosen.uv.astype(np.float64)
    cut_uv[chosen.fixed] = chosen.points[chosen.triangles[chosen.fixed]][:, :, :2] * UV_SCALE
    piece = Mesh(chosen.points, chosen.triangles.astype(np.int64), None if mesh.uv is None else cut_uv)
    return piece, chosen.fixed, notes


def _cutter(region: Sphere | Box) -> tuple[manifold3d.Manifold, NDArray[np.float64]]:
    if isinstance(region, Sphere):
        middle = np.asarray(region.center, np.float64)
        sides = 4 * round(90.0 / _EDGE)
        return manifold3d.Manifold.sphere(region.radius, sides).translate(middle.tolist()).as_original(), middle
    low, high = np.asarray(region.low, np.float64), np.asarray(region.high, np.float64)
    box = manifold3d.Manifold.cube((high - low).tolist()).translate(low.tolist())
    return box.as_original(), 0.5 * (low + high)
