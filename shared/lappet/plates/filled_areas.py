"""What is seen where, as areas on the paper: skin, the layers of wound walls, the undersides of flaps, the bed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise
from typing import cast

import contourpy
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, distance_transform_edt, gaussian_filter
from shapely import LineString

from lappet.anatomy.tissue_kind import KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.drawn_surface import BED, SCENERY, SCENERY_KINDS, DrawnSurface
from lappet.plates.projection import Projection
from lappet.plates.screen_triangles import ScreenTriangles

PIXEL = 0.12  # mm on paper
_CELL = 0.5  # mm on paper
_BLUR = 0.8  # pixels: what the border of an area is smoothed by
_LEAST = 0.3  # mm²: smaller areas are left out


class AreaKind(StrEnum):
    """What an area of a drawing is; its fill follows from that."""

    SKIN = "skin"
    FLAP_UNDERSIDE = "underside"
    BED = "bed"
    WALL_SKIN = "wall-skin"
    WALL_FAT = "wall-fat"
    WALL_FASCIA = "wall-fascia"
    WALL_MUSCLE = "wall-muscle"
    WALL_CARTILAGE = "wall-cartilage"
    WALL_DEEP = "wall-deep"  # of which nobody says what it is
    BONE = "bone"
    EYE = "eye"
    IRIS = "iris"
    PUPIL = "pupil"
    TEETH = "teeth"
    HOLLOW = "hollow"


@dataclass(frozen=True, eq=False)
class Area:
    """An area on the paper.

    Parameters
    ----------
    kind
        What it is.
    rings
        Its outline and those of its holes in mm, each closed, of shape (k, 2).
    """

    kind: AreaKind
    rings: tuple[NDArray[np.float64], ...]


@dataclass(frozen=True, eq=False)
class SeenPixels:
    """What is seen at the middles of the pixels of a panel.

    Parameters
    ----------
    triangle
        The triangle, -1 for none, shape (h, w).
    depth
        Its depth in mm, infinite for none, shape (h, w).
    kind
        Index of the kind of area in `AreaKind`, -1 for none, shape (h, w).
    x, y
        Middles of the columns and rows in mm on paper, shapes (w,) and (h,).
    quantity
        The quantity that is mapped, NaN where there is no skin of the tissue, shape (h, w); None for no map.
    """

    triangle: NDArray[np.int64]
    depth: NDArray[np.float64]
    kind: NDArray[np.int64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    quantity: NDArray[np.float64] | None = None


# What each kind of tissue is on a wound wall.
WALL_AREAS = {
    "skin": AreaKind.WALL_SKIN,
    "scar": AreaKind.WALL_SKIN,
    "mucosa": AreaKind.WALL_SKIN,
    "fat": AreaKind.WALL_FAT,
    "fascia": AreaKind.WALL_FASCIA,
    "muscle": AreaKind.WALL_MUSCLE,
    "cartilage": AreaKind.WALL_CARTILAGE,
    "other": AreaKind.WALL_DEEP,
}
_ORDER = tuple(AreaKind)
_WALLS = np.array([_ORDER.index(WALL_AREAS[name]) for name in KINDS])
_SCENERY = np.array([_ORDER.index(AreaKind(kind)) for kind in SCENERY_KINDS])


def seen_pixels(
    surface: DrawnSurface,
    projection: Projection,
    screen: ScreenTriangles,
    layers: TissueLayers,
    mapped: NDArray[np.floating] | None = None,
) -> SeenPixels:
    """Look at every pixel of a panel.

    Parameters
    ----------
    surface
        The surface.
    projection
        How it comes onto the paper.
    screen
        The surface on that paper.
    layers
        The layers of the tissue.
    mapped
        A quantity at the vertices of the tissue, shape (n,), or None.

    Returns
    -------
    SeenPixels
        What is seen.
    """
    half = 0.5 * np.asarray(projection.size)
    x = np.arange(-half[0] + 0.5 * PIXEL, half[0], PIXEL)
    y = np.arange(-half[1] + 0.5 * PIXEL, half[1], PIXEL)
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    triangle, depth = screen.nearest(places)
    kind = np.full(len(places), -1, np.int64)
    hit = triangle >= 0
    origin = surface.origin[triangle[hit]]
    kinds = np.select(
        [origin == FaceOrigin.SKIN, origin == FaceOrigin.UNDERSIDE, origin == BED, origin >= SCENERY],
        [
            *(_ORDER.index(each) for each in (AreaKind.SKIN, AreaKind.FLAP_UNDERSIDE, AreaKind.BED)),
            _SCENERY[np.maximum(origin - SCENERY, 0)],
        ],
        -1,
    )
    wall = origin == FaceOrigin.WOUND_WALL
    below = _at_places(surface, surface.depth, projection, triangle[hit][wall], places[hit][wall])
    kinds[wall] = wall_kinds(below, surface.column[triangle[hit][wall]], layers)
    kind[hit] = kinds
    if (surface.origin >= SCENERY).any():  # through a nostril or between lips the inside of what is shown is seen
        inside = surface.triangles[(surface.origin >= SCENERY) | (surface.origin == FaceOrigin.RIM)]
        empty = np.flatnonzero(kind < 0)
        paper, away = projection.paper(surface.points)
        back = ScreenTriangles(paper, away, inside, _CELL, behind=True).nearest(places[empty])[0] >= 0
        kind[empty[back]] = _ORDER.index(AreaKind.HOLLOW)
    shape = (len(y), len(x))
    pixels = SeenPixels(triangle.reshape(shape), depth.reshape(shape), kind.reshape(shape), x, y)
    if mapped is None:
        return without_cracks(pixels)
    quantity = np.full(len(places), np.nan)
    skin = np.flatnonzero(hit)[origin == FaceOrigin.SKIN]
    values = np.concatenate([mapped, np.full(len(surface.points) - len(mapped), np.nan)])
    quantity[skin] = _at_places(surface, values, projection, triangle[skin], places[skin])
    return without_cracks(replace(pixels, quantity=quantity.reshape(shape)))


def without_cracks(pixels: SeenPixels) -> SeenPixels:
    """Close what lets one look between two meshes that meet at different vertices.

    Parameters
    ----------
    pixels
        What is seen.

    Returns
    -------
    SeenPixels
        The same, but what is empty or hollow and narrower than three pixels shows what is seen beside it.
    """
    gap = (pixels.kind < 0) | (pixels.kind == _ORDER.index(AreaKind.HOLLOW))
    wide = binary_opening(np.pad(gap, 3, mode="edge"), np.ones((3, 3)))[3:-3, 3:-3]
    crack = gap & ~wide
    if not crack.any() or gap.all():
        return pixels
    row, column = distance_transform_edt(gap, return_distances=False, return_indices=True)[:, crack]
    closed = replace(pixels, triangle=pixels.triangle.copy(), depth=pixels.depth.copy(), kind=pixels.kind.copy())
    if pixels.quantity is not None:
        closed = replace(closed, quantity=pixels.quantity.copy())
    for each in (closed.triangle, closed.depth, closed.kind, closed.quantity):
        if each is not None:
            each[crack] = each[row, column]
    return closed


def wall_kinds(below: NDArray[np.float64], column: NDArray[np.int64], layers: TissueLayers) -> NDArray[np.int64]:
    """Tell the kind of area of places on wound walls.

    Parameters
    ----------
    below
        How deep below the skin they lie at rest in mm, shape (k,).
    column
        The column of layers that they lie in, shape (k,).
    layers
        The layers of the tissue.

    Returns
    -------
    NDArray[np.int64]
        Indices in `AreaKind`, shape (k,).
    """
    found: NDArray[np.int64] = _WALLS[layers.kind[layers.layers_at(column, below)]]
    return found


def _at_places(
    surface: DrawnSurface,
    values: NDArray[np.floating],
    projection: Projection,
    triangle: NDArray[np.int64],
    places: NDArray[np.float64],
) -> NDArray[np.float64]:
    """What values at the vertices (n,) are at places on the paper (k, 2) that show some triangles (k,)."""
    weights = corner_weights(surface, projection, triangle, places)
    found: NDArray[np.float64] = (weights * values[surface.triangles[triangle]]).sum(axis=1)
    return found


def corner_weights(
    surface: DrawnSurface, projection: Projection, triangle: NDArray[np.int64], places: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Find how much each corner of a triangle counts at a place on the paper.

    Parameters
    ----------
    surface
        The surface.
    projection
        How it comes onto the paper.
    triangle
        The triangle that is seen at each place, shape (k,).
    places
        The places in mm on paper, shape (k, 2).

    Returns
    -------
    NDArray[np.float64]
        The weights of the triangle's corners, shape (k, 3); they sum to one.
    """
    paper, depth = projection.paper(surface.points)
    corners = paper[surface.triangles[triangle]]
    first, second, away = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], places - corners[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    u = (away[:, 0] * second[:, 1] - away[:, 1] * second[:, 0]) / area
    v = (first[:, 0] * away[:, 1] - first[:, 1] * away[:, 0]) / area
    # Weights on the paper are those on the tissue over the depths of the corners.
    weights: NDArray[np.float64] = np.stack([1.0 - u - v, u, v], axis=1) / depth[surface.triangles[triangle]]
    weights /= weights.sum(axis=1, keepdims=True)
    return weights


def filled_areas(pixels: SeenPixels) -> list[Area]:
    """Trace the areas of a panel.

    Parameters
    ----------
    pixels
        What is seen.

    Returns
    -------
    list[Area]
        All tissue as skin first, then what is no skin upon it.
    """
    areas = []
    for kind in AreaKind:
        index = _ORDER.index(kind)
        mask = pixels.kind >= 0 if kind is AreaKind.SKIN else pixels.kind == index
        if mask.any():
            areas += [Area(kind, rings) for rings in _traced(mask, pixels.x, pixels.y)]
    return areas


def _traced(
    mask: NDArray[np.bool_], x: NDArray[np.float64], y: NDArray[np.float64]
) -> list[tuple[NDArray[np.float64], ...]]:
    # A panel's border is no border of an area: beyond it, what is seen goes on.
    soft = np.pad(gaussian_filter(np.pad(mask, 2, mode="edge").astype(np.float64), _BLUR), 1)
    step = PIXEL
    wide_x = np.concatenate([x[0] - step * np.arange(3, 0, -1), x, x[-1] + step * np.arange(1, 4)])
    wide_y = np.concatenate([y[0] - step * np.arange(3, 0, -1), y, y[-1] + step * np.arange(1, 4)])
    lines = contourpy.contour_generator(wide_x, wide_y, soft, fill_type=contourpy.FillType.OuterOffset)
    found_areas = cast("tuple[list[NDArray[np.float64]], list[NDArray[np.uint32]]]", lines.filled(0.5, 2.0))
    found = []
    for points, starts in zip(*found_areas, strict=True):
        rings = [points[a:b] for a, b in pairwise(starts)]
        if _ring_area(rings[0]) >= _LEAST:
            found.append(tuple(_simplified(ring) for ring in rings if _ring_area(ring) >= _LEAST))
    return found


def _ring_area(ring: NDArray[np.float64]) -> float:
    x, y = ring.T
    return 0.5 * abs(float(x[:-1] @ y[1:] - x[1:] @ y[:-1]))


def _simplified(ring: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array(LineString(ring).simplify(0.25 * PIXEL).coords)
