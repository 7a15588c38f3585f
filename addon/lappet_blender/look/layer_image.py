"""The layers of the tissue as a picture that shaders look up: depth to the right, a row for each column of layers."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import TissueLayers

WIDTH = 1024  # steps of depth
_BEYOND = 1.25  # of the deepest border; what is deeper is as what is there
ROW = "layer_row"


def depth_reach(layers: TissueLayers) -> float:
    """The depth in mm at the right edge of the picture."""
    return _BEYOND * layers.deepest_border or 1.0


def layer_rows(layers: TissueLayers, column: NDArray[np.int32]) -> NDArray[np.float32]:
    """How far up in the picture the rows of columns (m,) are, 0 to 1: the attribute `ROW` of faces."""
    return ((column + 0.5) / layers.columns).astype(np.float32)


def layer_pixels(layers: TissueLayers) -> NDArray[np.float32]:
    """The picture, linear RGBA: (columns, WIDTH, 4)."""
    depth = (np.arange(WIDTH) + 0.5) / WIDTH * depth_reach(layers)
    pixels = np.ones((layers.columns, WIDTH, 4), np.float32)
    for column in range(layers.columns):
        pixels[column, :, :3] = layers.colors_at(np.full(WIDTH, column), depth)
    return pixels


def layer_image(layers: TissueLayers) -> bpy.types.Image:
    """The picture in Blender, kept in the file."""
    pixels = layer_pixels(layers)
    image = bpy.data.images.new("Lappet layers", WIDTH, layers.columns, float_buffer=True, is_data=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image
