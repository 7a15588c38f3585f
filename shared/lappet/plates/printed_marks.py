"""Marks printed on the skin that deform with it: a grid, squares or dots at equal distances at rest, and skin lines.

They follow the texture coordinates of the skin, so that they are those of the picture's printed grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from shapely import STRtree, points, polygons

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.geometry.skin_shape import uv_scale
from lappet.plates.chains import joined_chains
from lappet.plates.drawn_surface import DrawnSurface
from lappet.plates.feature_lines import FeatureLine, LineKind
from lappet.plates.plate_scene import followed

MARKS = ("grid", "squares", "dots")
LEAST_SPACING, MOST_SPACING = 1.0, 50.0  # mm
_LIFT = 0.25  # mm: marks lie on the surface
_SQUARE = 0.4  # side of a square, of the spacing
_SIDE = 8  # samples along a side of a square
_TORN = 2.0  # times its length at rest: a piece of a mark that is longer spans a cut
_STEP = 0.5  # mm along skin lines


@dataclass(frozen=True)
class SkinPrint:
    """What is printed on the skin.

    Parameters
    ----------
    marks
        One of `MARKS`, or None.
    spacing
        Distance of the marks at rest in mm.
    lines
        Whether the procedure's skin lines are drawn.
    """

    marks: str | None = None
    spacing: float = 5.0
    lines: bool = False

    def on(self, source: SkinCache, surface: DrawnSurface) -> list[FeatureLine]:
        """Find what of it is on a frame.

        Parameters
        ----------
        source
            The solved procedure.
        surface
            The surface of the frame.

        Returns
        -------
        list[FeatureLine]
            Marks and skin lines.
        """
        found = [] if self.marks is None else printed_marks(source, surface, self.marks, self.spacing)
        return found + (skin_lines(source, surface.time) if self.lines else [])


NO_PRINT = SkinPrint()


def check_spacing(spacing: float) -> None:
    """Refuse marks that cannot be told apart, or of which none is on the skin.

    Parameters
    ----------
    spacing
        Their distance in mm.

    Raises
    ------
    RefusedError
        If it is out of range.
    """
    if not LEAST_SPACING <= spacing <= MOST_SPACING:
        known = f"{LEAST_SPACING:g} to {MOST_SPACING:g}"
        raise refused(ProblemCode.PLATE_MARKS, "", f"{spacing:g}", range=known)


def printed_marks(source: SkinCache, surface: DrawnSurface, marks: str, spacing: float) -> list[FeatureLine]:
    """Find the marks of a frame.

    Parameters
    ----------
    source
        The solved procedure.
    surface
        The surface of the frame.
    marks
        One of `MARKS`.
    spacing
        Their distance at rest in mm.

    Returns
    -------
    list[FeatureLine]
        The marks; of a surface without texture coordinates none.
    """
    epoch, first = surface.epoch, source.epochs[0]
    if epoch.st is None or first.st is None:
        return []
    whole = first.origin == FaceOrigin.SKIN
    scale = uv_scale(source.rest(first), first.triangles[whole], first.st[whole]) / spacing
    skin = epoch.origin == FaceOrigin.SKIN
    triangles, flat = epoch.triangles[skin].astype(np.int64), epoch.st[skin].astype(np.float64) * scale
    if marks == "grid":
        return [each for axis in (0, 1) for each in _level_lines(surface.points, triangles, flat[..., axis])]
    middles = _crossings(flat)
    if marks == "dots":
        placed = _placed(surface.points, triangles, flat, middles)
        found = placed[np.isfinite(placed).all(axis=1)]
        # A dot is a piece of a line that is hardly long: the pen makes it round.
        return [FeatureLine(LineKind.MARK_DOT, np.stack([at, at + 1e-3]), 2.0 * _LIFT) for at in found]
    share = np.linspace(-0.5, 0.5, _SIDE, endpoint=False)
    low, high = np.full(_SIDE, -0.5), np.full(_SIDE, 0.5)
    ring = np.stack([[*share, *high, *-share, *low, -0.5], [*low, *share, *high, *-share, -0.5]], axis=1) * _SQUARE
    rings = _placed(surface.points, triangles, flat, (middles[:, None] + ring).reshape(-1, 2)).reshape(-1, len(ring), 3)
    return [part for each in rings for part in whole_parts(each, _TORN * spacing * _SQUARE / _SIDE)]


def skin_lines(source: SkinCache, time: float) -> list[FeatureLine]:
    """Find the skin lines of a frame.

    Parameters
    ----------
    source
        The solved procedure.
    time
        Time code of the frame.

    Returns
    -------
    list[FeatureLine]
        The lines that the procedure has, where their tissue is there.
    """
    lines = []
    for line in source.skin_lines(_STEP):
        parts = whole_parts(followed(source, line, time), 4.0 * _STEP)
        lines += [FeatureLine(LineKind.SKIN_LINE, each.points, 2.0 * _LIFT) for each in parts]
    return lines


def _level_lines(
    places: NDArray[np.float64], triangles: NDArray[np.int64], height: NDArray[np.float64]
) -> list[FeatureLine]:
    """The lines of a surface on which a height at the corners (m, 3) is a whole number."""
    low, high = np.ceil(height.min(axis=1)).astype(np.int64), np.floor(height.max(axis=1)).astype(np.int64)
    lines = []
    for level in range(int(low.min(initial=0)), int(high.max(initial=-1)) + 1):
        own = (low <= level) & (level <= high)
        # A corner on the level counts as above it, so that each triangle is entered and left once.
        g, t, p = height[own] - level, triangles[own], places[triangles[own]]
        above = g >= 0.0
        crossed = above.any(axis=1) & ~above.all(axis=1)
        g, t, p, above = g[crossed], t[crossed], p[crossed], above[crossed]
        keys, where = [], []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            cut = above[:, a] != above[:, b]
            share = np.where(cut, g[:, a] / np.where(cut, g[:, a] - g[:, b], 1.0), 0.0)[:, None]
            where.append(p[:, a] + share * (p[:, b] - p[:, a]))
            ends = np.sort(t[:, [a, b]], axis=1)
            keys.append(np.where(cut, ends[:, 0] * len(places) + ends[:, 1], -1))
        key, at = np.stack(keys, axis=1), np.stack(where, axis=1)
        inner = key >= 0
        nodes, inverse = np.unique(key[inner], return_inverse=True)
        course = np.zeros((len(nodes), 3))
        course[inverse] = at[inner]
        chains = joined_chains(inverse.reshape(-1, 2)) if len(nodes) else []
        lines += [FeatureLine(LineKind.MARK, course[chain], _LIFT) for chain in chains]
    return lines


def _crossings(flat: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points with whole coordinates in the box of all corners, (k, 2)."""
    corners = flat.reshape(-1, 2)
    low, high = np.ceil(corners.min(axis=0)).astype(int), np.floor(corners.max(axis=0)).astype(int)
    u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij")
    return np.stack([u.ravel(), v.ravel()], axis=1).astype(np.float64)


def _placed(
    places: NDArray[np.float64], triangles: NDArray[np.int64], flat: NDArray[np.float64], wanted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where points of the texture's plane (k, 2) lie on the surface in mm, (k, 3); NaN where there is no skin."""
    tree = STRtree(polygons(flat))
    which, owner = tree.query(points(wanted), predicate="intersects")
    found = np.full((len(wanted), 3), np.nan)
    a, b, c = (flat[owner, k] for k in range(3))
    d = wanted[which]
    area = _cross(b - a, c - a)
    good = np.abs(area) > 1e-12
    which, owner, a, b, c, d, area = (each[good] for each in (which, owner, a, b, c, d, area))
    share = np.stack([_cross(b - d, c - d), _cross(c - d, a - d), _cross(a - d, b - d)], axis=1) / area[:, None]
    found[which] = np.einsum("ki,kij->kj", share, places[triangles[owner]])
    return found


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    product: NDArray[np.float64] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def whole_parts(course: NDArray[np.float64], longest: float) -> list[FeatureLine]:
    """Find the parts of a line that are there and not torn, of two points at least.

    Parameters
    ----------
    course
        The line in mm, shape (k, 3); NaN where its tissue is gone.
    longest
        Length in mm of a piece between two points that is not torn.

    Returns
    -------
    list[FeatureLine]
        The parts.
    """
    lengths = np.linalg.norm(np.diff(course, axis=0), axis=1)
    joined = np.concatenate([[False], np.where(np.isfinite(lengths), lengths, np.inf) <= longest, [False]])
    edges = np.flatnonzero(np.diff(joined.astype(np.int8)))
    parts = zip(edges[::2], edges[1::2], strict=True)
    return [FeatureLine(LineKind.MARK, course[begin : end + 1], _LIFT) for begin, end in parts]
