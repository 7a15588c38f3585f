"""The picture that Solid shading and Workbench, which know no shader nodes, lay on the skin: its grid or its scale."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.quantity_scale import ramp_linear
from lappet.output.png_writer import png_bytes

from .skin_material import CHECKER_INK, CHECKER_SHARE, GRID_INK, INK_SHARE, SKIN

TILE = 10.0  # mm of the grid per unit of the map
_MAP = "UVMap"
_PIXELS = 160  # of the tile's sides
_STEPS = 256  # of the scale


def add_tile(material: bpy.types.Material, name: str) -> None:
    """Make a picture of 10 mm of the grid or checker the active texture of a material."""
    color = np.ones((_PIXELS, _PIXELS, 3))
    if name == "grid":
        place = np.arange(_PIXELS) * TILE / _PIXELS % 5.0
        line = (place < 0.14) | (place > 4.86)
        ink = (line[:, None] | line[None, :]).astype(np.float32)
        dark = np.array(GRID_INK[:3])
    else:
        half = np.arange(_PIXELS) * 10 // _PIXELS // 5
        ink = ((half[:, None] + half[None, :]) % 2).astype(np.float32)
        dark = np.array(CHECKER_INK[:3])
    ink = ink[..., None] * (INK_SHARE if name == "grid" else CHECKER_SHARE)
    color = (1.0 - ink) * np.array(SKIN[:3]) + ink * dark
    _activate(material, f"Lappet {name}", color)


def add_scale(material: bpy.types.Material) -> None:
    """Make the colors of a quantity, from 0 to its full scale, the active texture of a material."""
    node = _activate(material, "Lappet scale", ramp_linear(np.linspace(0.0, 1.0, _STEPS))[None])
    node.extension = "EXTEND"


def lay(mesh: bpy.types.Mesh, places: NDArray[np.floating[Any]]) -> None:
    """Lay a mesh out on the picture. places: (corners, 2), in units of the picture."""
    layer = mesh.uv_layers.get(_MAP) or mesh.uv_layers.new(name=_MAP, do_init=False)
    layer.uv.foreach_set("vector", np.ascontiguousarray(places, np.float32).ravel())
    # To Blender the attribute `grid` is such a map too, and the first one.
    layer.active = layer.active_render = True


def _activate(material: bpy.types.Material, name: str, linear: NDArray[np.float64]) -> Any:
    """The node of a picture (rows, columns, 3) of linear colors, which feeds no shader."""
    rows, columns = linear.shape[:2]
    image = bpy.data.images.new(name, columns, rows)
    color = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    # Encoded here: the first picture that Blender encodes in a session keeps its main thread for 16 to 55 ms.
    data = png_bytes(np.rint(255.0 * np.clip(color[::-1], 0.0, 1.0)).astype(np.uint8))
    image.pack(data=data, data_len=len(data))
    image.source = "FILE"
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
    return node
