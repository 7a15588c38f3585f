"""A small picture of a chapter's operation, for the page that lists the chapters of a site."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import half_angles, viewpoint
from lappet.drawing.surface_look import SKIN_LOOK
from lappet.export.lesson_procedure import LessonScene
from lappet.export.moving_shape import MovingShape
from lappet.export.moving_skin import bed_shape, skin_shapes
from lappet.export.moving_tubes import instrument_shapes
from lappet.geometry.triangles import directions
from lappet.output.raster import rasterize

SIZE = (480, 300)  # pixels
_FINER = 2  # rows and columns that are averaged to one
_PAPER = np.array([0.96, 0.96, 0.95])
_INK = np.array([0.235, 0.11, 0.085])
_LIGHT = directions(np.array([[-0.5, 0.6, 0.75]]))[0]  # in the axes of the camera: right, up, backwards
_AMBIENT = 0.4
_LINE = 0.05  # of a square of the grid: half the width of its lines


def chapter_picture(shown: LessonScene, time: float) -> NDArray[np.uint8]:
    """Draw a frame, obliquely.

    Parameters
    ----------
    shown
        The solved procedure before the camera.
    time
        Time code of the frame.

    Returns
    -------
    NDArray[np.uint8]
        Red, green and blue of each pixel from the top left on, shape (height, width, 3).
    """
    bed = bed_shape(shown.source, (time,))
    shapes = [*skin_shapes(shown.source, (time,)), *([bed] if bed else [])]
    shapes += instrument_shapes(shown.source, (time,))
    points, normals, grid, triangles, colors = _joined(shapes)
    width, height = (_FINER * side for side in SIZE)
    view = viewpoint(shown.scene.field, "oblique", half_angles(SIZE))
    local = (points - view.position) @ view.axes.T
    depth = np.maximum(-local[:, 2], 1e-6)
    scale = 0.5 * width / half_angles(SIZE)[0]
    place = np.stack(
        [0.5 * width + scale * local[:, 0] / depth, 0.5 * height - scale * local[:, 1] / depth, depth], axis=1
    )
    raster = rasterize(place[triangles], (width, height))
    hit = raster.triangle >= 0
    face = raster.triangle[hit]
    weights = raster.weights[hit][:, :, None]
    corner = triangles[face]
    normal = directions((normals[corner] * weights).sum(axis=1)) @ view.axes.T
    normal *= np.where(normal[:, 2:] < 0.0, -1.0, 1.0)
    shade = _AMBIENT + (1.0 - _AMBIENT) * np.clip(normal @ _LIGHT, 0.0, 1.0)
    square = (grid[corner] * weights).sum(axis=1)
    away = np.abs(square - np.rint(square)).min(axis=1)
    ink = 0.5 * (away < _LINE)  # nothing but skin has places on the grid; NaN is no line
    color = (1.0 - ink)[:, None] * colors[face] + ink[:, None] * _INK
    picture = np.tile(_PAPER, (height, width, 1))
    linear = np.clip(color * shade[:, None], 0.0, 1.0)
    picture[hit] = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    mean = picture.reshape(SIZE[1], _FINER, SIZE[0], _FINER, 3).mean(axis=(1, 3))
    return np.round(255.0 * mean).astype(np.uint8)


def _joined(
    shapes: list[MovingShape],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Points, normals, places on the grid (NaN where there is none), triangles, and the color of each triangle."""
    points, normals, grid, triangles, colors, count = [], [], [], [], [], 0
    for shape in shapes:
        own = shape.positions[-1].astype(np.float64)
        points.append(own)
        normals.append(shape.normals[-1].astype(np.float64))
        squares = np.full((len(own), 2), np.nan)
        for look, faces in shape.parts:
            triangles.append(faces.astype(np.int64) + count)
            colors.append(np.tile(look.color, (len(faces), 1)))
            if look is SKIN_LOOK and shape.grid is not None and len(faces):
                squares[faces.ravel()] = shape.grid[faces.ravel()]
        grid.append(squares)
        count += len(own)
    return tuple(np.concatenate(each) for each in (points, normals, grid, triangles, colors))
