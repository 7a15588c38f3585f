"""Hatching: lines at even distances across the skin, along walls and over the bed, where the drawing is dark.

The lines are levels of a field on the tissue at rest, so that they ride on it: planes across the light on the skin, the
depth below the skin on walls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.chains import joined_chains
from lappet.plates.drawn_surface import BED, SCENERY, DrawnSurface
from lappet.plates.feature_lines import FeatureLine, LineKind

_LIFT = 0.2  # mm
_DARK = 0.55  # of full light: skin that gets less is hatched
_BED = 0.8  # of the distance on skin: a wound is darker than all around it
_DARKER = 0.3  # skin and bed that get less are hatched twice


def hatching(
    surface: DrawnSurface,
    light: NDArray[np.float64],
    along: NDArray[np.float64],
    distance: float,
    seen: NDArray[np.bool_],
) -> list[FeatureLine]:
    """Hatch what is dark.

    Parameters
    ----------
    surface
        The surface.
    light
        Unit vector towards the light, shape (3,).
    along
        Unit vector along which the hatching runs on the skin, shape (3,).
    distance
        Distance between two lines in mm of tissue.
    seen
        The triangles of skin and bed that may be seen, shape (m,): no others are hatched.

    Returns
    -------
    list[FeatureLine]
        The lines, what is hidden of them too.
    """
    across = np.cross(light, along)
    across /= max(float(np.linalg.norm(across)), 1e-12)
    shade = 1.0 - np.clip(np.einsum("mki,i->mk", surface.normals, light), 0.0, 1.0)
    skin = seen & np.isin(surface.origin, (FaceOrigin.SKIN, FaceOrigin.UNDERSIDE, SCENERY))
    bed, wall = seen & (surface.origin == BED), surface.origin == FaceOrigin.WOUND_WALL
    plain = surface.rest @ across
    crossed = surface.rest @ (0.7 * across + 0.7 * along)
    lines = levels(surface, skin, plain, distance, shade - (1.0 - _DARK))
    lines += levels(surface, skin, crossed, distance, shade - (1.0 - _DARKER))
    lines += levels(surface, bed, crossed, _BED * distance, None)
    lines += levels(surface, bed, plain, _BED * distance, None)
    lines += levels(surface, wall, surface.depth, 0.8 * distance, None)
    return [FeatureLine(LineKind.HATCHING, line, _LIFT) for line in lines]


def levels(
    surface: DrawnSurface,
    which: NDArray[np.bool_],
    field: NDArray[np.float64],
    distance: float,
    dark: NDArray[np.float64] | None,
) -> list[NDArray[np.float64]]:
    """Trace the levels of a field on some of the triangles.

    Parameters
    ----------
    surface
        The surface.
    which
        The triangles, shape (m,).
    field
        The field at the vertices in mm, shape (n,).
    distance
        Between two levels in mm.
    dark
        At the corners of the triangles, positive where lines are drawn, shape (m, 3); None: everywhere.

    Returns
    -------
    list[NDArray[np.float64]]
        The lines in mm, each of shape (k, 3).
    """
    t = surface.triangles[which]
    tone = np.ones((len(t), 3)) if dark is None else dark[which]
    lit = tone.max(axis=1) > 0.0
    t, tone = t[lit], tone[lit]
    if not len(t):
        return []
    value = field[t] / distance + 0.5
    low, high = np.ceil(value.min(axis=1)), np.floor(value.max(axis=1) - 1e-9)
    counts = np.maximum(high - low + 1, 0).astype(np.int64)
    owner = np.repeat(np.arange(len(t)), counts)
    level = low[owner] + np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return _crossings(t[owner], value[owner], level, tone[owner], surface.points)


def _crossings(
    t: NDArray[np.int64],
    value: NDArray[np.float64],
    level: NDArray[np.float64],
    tone: NDArray[np.float64],
    points: NDArray[np.float64],
) -> list[NDArray[np.float64]]:
    """The lines of levels through triangles, joined, where their tone is positive."""
    keys, places, tones = [], [], []
    count = len(points)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        cut = (value[:, a] < level) != (value[:, b] < level)
        share = np.where(cut, (level - value[:, a]) / np.where(cut, value[:, b] - value[:, a], 1.0), 0.0)
        places.append(points[t[:, a]] + share[:, None] * (points[t[:, b]] - points[t[:, a]]))
        tones.append(tone[:, a] + share * (tone[:, b] - tone[:, a]))
        edge = np.minimum(t[:, a], t[:, b]) * count + np.maximum(t[:, a], t[:, b])
        keys.append(np.where(cut, edge, -1))
    edges, where, dark = np.stack(keys, axis=1), np.stack(places, axis=1), np.stack(tones, axis=1)
    own = edges >= 0
    whole = own.sum(axis=1) == 2
    own &= whole[:, None]
    pairs, where, dark = edges[own].reshape(-1, 2), where[own].reshape(-1, 2, 3), dark[own].reshape(-1, 2)
    pairs, where = _where_dark(pairs, where, dark)
    # One edge can be crossed by several levels.
    named = np.stack([pairs, np.repeat(level[whole][dark.max(axis=1) > 0.0][:, None], 2, axis=1)], axis=-1)
    nodes, inverse = np.unique(named.reshape(-1, 2), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1, 2)
    at = np.zeros((len(nodes), 3))
    at[inverse.ravel()] = where.reshape(-1, 3)
    return [at[chain] for chain in joined_chains(inverse)] if len(inverse) else []


def _where_dark(
    pairs: NDArray[np.int64], where: NDArray[np.float64], dark: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The segments that are dark, cut to where they are; their cut ends are nodes of their own."""
    kept = dark.max(axis=1) > 0.0
    names, where, dark = pairs[kept].astype(np.float64), where[kept].copy(), dark[kept]
    for end in (0, 1):
        out = dark[:, end] <= 0.0
        share = (dark[out, 1 - end] / (dark[out, 1 - end] - dark[out, end]))[:, None]
        where[out, end] = where[out, 1 - end] + share * (where[out, end] - where[out, 1 - end])
        names[out, end] = -1.0 - 2.0 * np.flatnonzero(out) - end
    return names, where
