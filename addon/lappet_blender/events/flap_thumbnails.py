"""Small pictures of the plans of the flap library, drawn when they are first shown."""

from __future__ import annotations

import bpy.utils.previews
import numpy as np
from numpy.typing import NDArray

from lappet.designs.flap_plan import FlapPlan, flap_plan
from lappet.designs.library import DESIGNS

SIZE = 96  # pixels
_MARGIN = 9.0  # pixels
_REACH = 2  # pixels that a line is wide at most to either side
_CUT = (0.93, 0.36, 0.30)
_WAY = (0.45, 0.68, 0.95)
_EXCISED = (0.91, 0.79, 0.74, 0.85)
_pictures: bpy.utils.previews.ImagePreviewCollection | None = None


def thumbnail(name: str) -> int:
    """The icon of a design's plan, for `icon_value`."""
    global _pictures
    if _pictures is None:
        _pictures = bpy.utils.previews.new()
    if name not in _pictures:
        picture = _pictures.new(name)
        picture.image_size = picture.icon_size = (SIZE, SIZE)
        pixels = drawn(flap_plan(DESIGNS[name])).ravel()
        picture.image_pixels_float = picture.icon_pixels_float = pixels
    return int(_pictures[name].icon_id)


def drawn(plan: FlapPlan) -> NDArray[np.float32]:
    """The plan as pixels, shape (SIZE, SIZE, 4), from below, on nothing."""
    low, high = plan.bounds
    scale = (SIZE - 2.0 * _MARGIN) / float((high - low).max())
    shift = 0.5 * SIZE - 0.5 * scale * (low + high)
    place = (np.stack(np.meshgrid(np.arange(SIZE), np.arange(SIZE)), axis=-1) + 0.5).reshape(-1, 2)
    pixels = np.zeros((SIZE * SIZE, 4))
    outlines = [scale * each + shift for each in plan.outlines]
    for outline in outlines:
        pixels[_inside(place, outline)] = _EXCISED
    closed = [np.vstack([each, each[:1]]) for each in outlines]
    cuts = [*closed, *(scale * each + shift for each in plan.incisions)]
    for lines, color, half in ((cuts, _CUT, 1.3), ([scale * each + shift for each in plan.ways], _WAY, 0.9)):
        share = np.clip(half + 0.5 - _distance(lines), 0.0, 1.0)[:, None]
        pixels[:, :3] = share * color + (1.0 - share) * pixels[:, :3]
        pixels[:, 3:] = np.maximum(pixels[:, 3:], share)
    return pixels.reshape(SIZE, SIZE, 4).astype(np.float32)


def _distance(lines: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """From each pixel to the nearest line, in pixels, where it is not far."""
    nearest = np.full(SIZE * SIZE, np.inf)
    around = np.stack(np.meshgrid(np.arange(-_REACH, _REACH + 1), np.arange(-_REACH, _REACH + 1)), axis=-1)
    for line in lines:
        points = _dense(line)
        pixel = np.floor(points).astype(np.int64)[:, None] + around.reshape(-1, 2)
        distance = np.linalg.norm(pixel + 0.5 - points[:, None], axis=2)
        seen = ((pixel >= 0) & (pixel < SIZE)).all(axis=2)
        np.minimum.at(nearest, (pixel[..., 1] * SIZE + pixel[..., 0])[seen], distance[seen])
    return nearest


def _dense(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points along a line (n, 2), four in a pixel."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], int(4.0 * along[-1]) + 2)
    return np.stack([np.interp(at, along, line[:, k]) for k in range(2)], axis=1)


def _inside(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points (n, 2) lie in a closed outline (m, 2): a ray from them crosses it an odd number of times."""
    odd = np.zeros(len(points), bool)
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        spans = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        at = a[0] + (points[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1] if a[1] != b[1] else 1.0)
        odd ^= spans & (points[:, 0] < at)
    return odd


def unregister() -> None:
    """Take the pictures away."""
    global _pictures
    if _pictures is not None:
        bpy.utils.previews.remove(_pictures)
        _pictures = None
