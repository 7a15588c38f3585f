"""Choose a surgical field on a surface: a sphere, a box, a disc along the skin, or an outline drawn on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import closest_points
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.flatten import flatten
from lappet.geometry.geodesic_distance import geodesic_distance
from lappet.geometry.polygon import crosses_itself, signed_distance
from lappet.geometry.surface_check import place
from lappet.geometry.triangles import areas, barycentric
from lappet.tissue.crop_mesh import box_levels, crop, crop_by_values, near, refine_smoothly, sphere_level
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_repair import separate
from lappet.tissue.mesh_report import Note, taken
from lappet.tissue.outer_part import outer_part

_OFF = 0.1  # of an outline's length: its points lie no further from the surface
_OUTLINE_REACH = 0.65  # of an outline's length: what lies further from its first point is not in it
_BEYOND = 1.5  # of the radius: distances along the skin are measured this far


@dataclass(frozen=True)
class Sphere:
    """The part of a surface inside a sphere.

    Parameters
    ----------
    center
        Center in mm.
    radius
        Radius in mm.
    """

    center: Sequence[float]
    radius: float


@dataclass(frozen=True)
class Box:
    """The part of a surface inside a box along the axes.

    Parameters
    ----------
    low
        Lowest corner in mm.
    high
        Highest corner in mm.
    """

    low: Sequence[float]
    high: Sequence[float]


@dataclass(frozen=True)
class Disc:
    """The part of a surface within a radius of a point, along the skin.

    Parameters
    ----------
    at
        A point in mm; the closest point of the surface is the disc's middle.
    radius
        Radius along the skin in mm.
    """

    at: Sequence[float]
    radius: float


@dataclass(frozen=True)
class Outline:
    """The part of a surface inside a closed curve that was drawn on it.

    Parameters
    ----------
    points
        Points in mm in order, either way round, at least 3; each goes to the closest point of the surface, and between
        them the curve runs straight on the unrolled skin.
    """

    points: Sequence[Sequence[float]]


Region = Sphere | Box | Disc | Outline


def surgical_field(mesh: Mesh, region: Region, edge: float, name: str) -> tuple[Mesh, list[Note]]:
    """Take one connected part of a surface inside a region, refined and cut cleanly.

    Of a sphere and a box it is the part that faces outwards and lies nearest to the middle; of a disc the one that
    holds its middle; of an outline the larger one.

    Parameters
    ----------
    mesh
        The surface, welded and oriented.
    region
        The region.
    edge
        Length in mm to which edges are divided.
    name
        What messages call the surface.

    Returns
    -------
    tuple[Mesh, list[Note]]
        The part, and what was taken.

    Raises
    ------
    RefusedError
        If the region holds nothing of the surface, a disc's point lies further from it than its radius, or an outline
        crosses itself or lies off the surface.
    """
    if isinstance(region, Disc):
        return _disc(mesh, region, edge, name)
    if isinstance(region, Outline):
        return _inside_outline(mesh, region, edge, name)
    levels = sphere_level(region.center, region.radius) if isinstance(region, Sphere) else box_levels(*_corners(region))
    candidates = near(mesh, levels)
    if len(candidates.triangles) == 0:
        raise _empty(mesh, name)
    refined, notes = _refined(candidates, edge)
    inside, _ = separate(crop(refined, levels))
    if len(inside.triangles) == 0:
        raise _empty(mesh, name)
    middle = region.center if isinstance(region, Sphere) else np.mean([region.low, region.high], axis=0)
    part, chosen = outer_part(mesh, inside, np.asarray(middle, np.float64))
    kind = "sphere" if isinstance(region, Sphere) else "box"
    return part, [taken("region", f"inside a {kind} around {place(np.asarray(middle, np.float64))}"), *chosen, *notes]


def _disc(mesh: Mesh, disc: Disc, edge: float, name: str) -> tuple[Mesh, list[Note]]:
    at = np.asarray(disc.at, np.float64)
    _, closest, away = closest_points(at[None], mesh.points, mesh.triangles)
    middle = closest[0]
    if away[0] > disc.radius:
        raise refused(
            ProblemCode.REGION_POINT_OFF_SURFACE, name, place(at), away=f"{away[0]:.3g}", nearest=place(middle)
        )
    candidates = _around(near(mesh, sphere_level(middle, _BEYOND * disc.radius)), middle)
    refined, notes = _refined(candidates, edge)
    distance = geodesic_distance(refined.points, refined.triangles, middle, _BEYOND * disc.radius)
    inside, _ = separate(crop_by_values(refined, np.minimum(distance, _BEYOND * disc.radius) - disc.radius))
    if len(inside.triangles) == 0:
        raise _empty(mesh, name)
    where = f"within {disc.radius:g} mm of {place(middle.round(3))} along the skin"
    if away[0] > 0.1:
        where += f", {away[0]:.3g} mm from the given point"
    return _around(inside, middle), [taken("region", where), *notes]


def _inside_outline(mesh: Mesh, outline: Outline, edge: float, name: str) -> tuple[Mesh, list[Note]]:
    drawn = np.asarray(outline.points, np.float64)
    length = float(np.linalg.norm(np.roll(drawn, -1, axis=0) - drawn, axis=1).sum())
    _, closest, away = closest_points(drawn, mesh.points, mesh.triangles)
    if away.max() > _OFF * length:
        far = int(away.argmax())
        raise refused(
            ProblemCode.REGION_POINT_OFF_SURFACE,
            name,
            place(drawn[far]),
            away=f"{away[far]:.3g}",
            nearest=place(closest[far]),
        )
    # Every point of the outline lies within half its length of the first one.
    reach = _OUTLINE_REACH * length
    candidates = _around(near(mesh, sphere_level(closest[0], reach)), closest[0])
    refined, notes = _refined(candidates, edge)
    distance = geodesic_distance(refined.points, refined.triangles, closest[0], reach)
    patch = _around(separate(refined.part(np.isfinite(distance)[refined.triangles].all(axis=1)))[0], closest[0])
    flat = flatten(patch.points, patch.triangles)
    triangle, on_skin, _ = closest_points(closest, patch.points, patch.triangles)
    weights = barycentric(on_skin, patch.points[patch.triangles[triangle]])
    polygon = np.einsum("kc,kci->ki", weights, flat[patch.triangles[triangle]])
    if crosses_itself(polygon):
        raise refused(ProblemCode.OUTLINE_CROSSES_ITSELF, name)
    inside, _ = separate(crop_by_values(patch, signed_distance(flat, polygon)))
    if len(inside.triangles) == 0:
        raise _empty(mesh, name)
    part = parts_of(inside.triangles, len(inside.points))
    largest = np.bincount(part, areas(inside.points[inside.triangles])).argmax()
    where = f"inside an outline of {len(drawn)} points, {length:.3g} mm long"
    return inside.part(part == largest), [taken("region", where), *notes]


def _around(mesh: Mesh, point: NDArray[np.float64]) -> Mesh:
    """The connected part of a surface that is closest to a point."""
    triangle = closest_points(point[None], mesh.points, mesh.triangles)[0][0]
    part = parts_of(mesh.triangles, len(mesh.points))
    return mesh.part(part == part[triangle])


def _refined(mesh: Mesh, edge: float) -> tuple[Mesh, list[Note]]:
    refined, moved = refine_smoothly(mesh, edge)
    value = f"edges of about {edge:g} mm; new points lie up to {moved:.2g} mm off the old edges"
    return refined, [taken("refinement", value)] if len(refined.points) > len(mesh.points) else []


def _corners(box: Box) -> tuple[Sequence[float], Sequence[float]]:
    return box.low, box.high


def _empty(mesh: Mesh, name: str) -> Exception:
    low, high = place(mesh.points.min(axis=0)), place(mesh.points.max(axis=0))
    return refused(ProblemCode.REGION_EMPTY, name, low=low, high=high)
