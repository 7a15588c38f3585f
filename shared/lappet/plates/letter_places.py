"""Where the letters of corners stand: beside them on the tissue that they ride on, off lines where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lappet.plates.feature_lines import LineKind
from lappet.plates.letter_anchors import Corner
from lappet.plates.plate_scene import PlateScene
from lappet.plates.projection import Projection
from lappet.plates.screen_triangles import ScreenTriangles
from lappet.plates.strokes import Stroke, sampled

# Distances in mm on paper from a corner, and shares of half its angle by which a letter stands beside its middle.
_PLACES = tuple((far, aside) for far in (3.2, 4.2, 5.4) for aside in (0.0, -0.35, 0.35, -0.65, 0.65))
_HALF = (1.25, 1.5)  # mm on paper: half the width and height that a letter covers
_SPACE = 2.4  # mm on paper: of letters that are nearer the first stands
_COVERS = 3.0  # times the length under it that a letter costs which stands over another or over an arrow
_FARTHER = (0.0, 0.5, 1.3)  # mm of covered line that each distance may cost
_ASIDE = 1.0  # mm of covered line that a whole half of its angle may cost
_MOVES = 0.8  # mm of covered line that a letter bears before it leaves its place of before
_LEAST = 2  # a letter alone tells nothing
_SAMPLE = 0.25  # mm
_KEPT_OFF = frozenset(
    {
        *(LineKind.PLAN, LineKind.THREAD, LineKind.WOUND_EDGE, LineKind.INSTRUMENT, LineKind.WALL_FOOT),
        *(LineKind.UNDERMINED, LineKind.THINNED, LineKind.CONTOUR),
    }
)


@dataclass(frozen=True, eq=False)
class Letter:
    """A corner's letter on the paper.

    Parameters
    ----------
    text
        The letter.
    at
        Its middle in mm, shape (2,).
    """

    text: str
    at: NDArray[np.float64]


@dataclass(eq=False)
class LetterPlaces:
    """How the letters of panels before stood beside their corners.

    Parameters
    ----------
    chosen
        For each letter the index of its place.
    """

    chosen: dict[str, int] = field(default_factory=dict)


def place_letters(
    scene: PlateScene,
    time: float,
    projection: Projection,
    screen: ScreenTriangles,
    strokes: Sequence[Stroke],
    arrows: Sequence[NDArray[np.float64]] = (),
    before: LetterPlaces | None = None,
) -> list[Letter]:
    """Place the letters of the corners whose tissue is there and seen.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the frame.
    projection
        How it comes onto the paper.
    screen
        The surface on that paper.
    strokes
        The panel's lines.
    arrows
        Its arrows in mm on paper, each of shape (k, 2).
    before
        How letters stood on the panel before: they stay there where that is nearly as good. Those of this panel are
        written into it.

    Returns
    -------
    list[Letter]
        The letters, none where there would be one alone.
    """
    corners = scene.corners
    if len(corners) < _LEAST:
        return []
    before = before or LetterPlaces()
    # On whole skin a letter stands where there is most room; later on the tissue that keeps the corner.
    whole = scene.source.epoch_at(time).name == scene.source.epochs[0].name
    sectors = [-1 if whole else kept for kept in scene.kept]
    rest = np.concatenate([_beside(each, k, scene, projection) for each, k in zip(corners, sectors, strict=True)])
    places = scene.on_skin(rest, time)
    known = np.isfinite(places).all(axis=1)
    paper, depth = projection.paper(np.where(known[:, None], places, 0.0))
    inside = (np.abs(paper) + np.asarray(_HALF) < 0.5 * np.asarray(projection.size)).all(axis=1)
    seen = (known & inside & (depth <= screen.nearest(paper)[1] + 0.5)).reshape(len(corners), -1)
    paper = paper.reshape(len(corners), -1, 2)
    none = np.zeros((0, 2))
    lines = np.vstack([none, *(sampled(each.points, _SAMPLE) for each in strokes if each.kind in _KEPT_OFF)])
    others = np.vstack([none, *(sampled(each, _SAMPLE) for each in arrows)])
    found: list[Letter] = []
    for corner, own, there in zip(corners, paper, seen, strict=True):
        taken = np.vstack([others, *(_box(each.at) for each in found)])
        cost = _SAMPLE * (_covered(own, lines) + _COVERS * _covered(own, taken))
        cost += [_FARTHER[k // 5] + _ASIDE * abs(aside) for k, (_, aside) in enumerate(_PLACES)]
        near = [np.linalg.norm(own - each.at, axis=1) < _SPACE for each in found]
        cost[~there | np.any([np.zeros(len(own), bool), *near], axis=0)] = np.inf
        best = int(np.argmin(cost))
        last = before.chosen.get(corner.letter, best)
        best = last if cost[last] <= cost[best] + _MOVES else best
        if np.isfinite(cost[best]):
            before.chosen[corner.letter] = best
            found.append(Letter(corner.letter, own[best]))
    return found if len(found) >= _LEAST else []


def _beside(corner: Corner, sector: int, scene: PlateScene, projection: Projection) -> NDArray[np.float64]:
    """Places at rest beside a corner at which its letter may stand, (15, 3)."""
    own = corner.sectors[sector]
    side = np.cross(scene.field.normal, own.middle)
    turns = 0.5 * own.angle * np.array([aside for _, aside in _PLACES])[:, None]
    ways = np.cos(turns) * own.middle + np.sin(turns) * side
    far = np.array([each for each, _ in _PLACES])[:, None] / projection.scale
    places: NDArray[np.float64] = corner.at + far * ways
    return places


def _box(at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points all over a letter, (k, 2)."""
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 5))
    points: NDArray[np.float64] = at + np.stack([_HALF[0] * x.ravel(), _HALF[1] * y.ravel()], axis=1)
    return points


def _covered(places: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """How many points a letter covers at each place, (n,)."""
    under = (np.abs(points[None] - places[:, None]) < np.asarray(_HALF)).all(axis=-1)
    return under.sum(axis=1).astype(np.float64)
