"""Arrows for the pull of hooks: which way each has drawn the tissue that it holds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.plates.plate_scene import PlateScene
from lappet.plates.projection import Projection

_LENGTH = 7.0  # mm on paper
_AWAY = 1.2  # mm on paper between the hook's point and its arrow
_BORDER = 0.8  # mm on paper between an arrow and the panel's border
_LEAST = 1.5  # mm on paper: what has moved less is held, not pulled
_MOST = 4
_NEAR = 6.0  # mm on paper: of arrows that begin nearer to each other and point the same way one is drawn
_SAME_WAY = 0.8  # cosine of the angle between such arrows


def pull_arrows(scene: PlateScene, time: float, projection: Projection) -> list[NDArray[np.float64]]:
    """Draw the pull of the hooks that hold the tissue at a frame.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the frame.
    projection
        How it comes onto the paper.

    Returns
    -------
    list[NDArray[np.float64]]
        Straight arrows in mm, each of shape (2, 2): from the point that a hook holds on in the direction in which it
        has come since the hook took hold, or up to it where there is no room beyond. Those that have come farthest are
        first; all are as long.
    """
    source = scene.source
    now = source.hooks(time)
    room = 0.5 * np.asarray(projection.size) - _BORDER
    found: list[tuple[float, NDArray[np.float64]]] = []
    for k in np.flatnonzero(now.active):
        first = next(frame for frame in source.frames if source.hooks(frame).active[k])
        ends = np.stack([source.hooks(first).ends[k, 0], now.ends[k, 0]]).astype(np.float64)
        paper, _ = projection.paper(ends)
        way = paper[1] - paper[0]
        moved = float(np.linalg.norm(way))
        if moved >= _LEAST:
            ahead = np.array([[_AWAY], [_AWAY + _LENGTH]]) * way / moved
            # Where the panel ends before the arrow, it runs up to the hook instead of on from it.
            arrows = [paper[1] + ahead, paper[1] - ahead[::-1]]
            found += [(moved, each) for each in arrows if (np.abs(each) <= room).all()][:1]
    found.sort(key=lambda each: -each[0])
    kept: list[NDArray[np.float64]] = []
    for _, way in found:
        if len(kept) < _MOST and not any(_beside(way, other) for other in kept):
            kept.append(way)
    return kept


def _beside(way: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether an arrow says what one beside it says already."""
    along = (way[1] - way[0]) @ (other[1] - other[0]) / _LENGTH**2
    return bool(np.linalg.norm(way[0] - other[0]) < _NEAR and along > _SAME_WAY)
