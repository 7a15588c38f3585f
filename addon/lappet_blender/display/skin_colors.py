"""Colors of the skin's vertices for Solid shading and Workbench, which know no shader nodes."""

from __future__ import annotations

from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import TissueLayers
from lappet.background.manifest import EpochShape
from lappet.core.digest import digest
from lappet.drawing.quantity_scale import ramp_linear
from lappet.drawing.skin_fields import SKIN

from ..look.skin_import import set_attribute
from ..look.skin_material import SKIN as SKIN_COLOR
from ..model.made_soon import MadeSoon

ATTRIBUTE = "Color"
_STATE = "lappet_color"
_STEPS = 512
_LUMINANCE = np.array((0.2126, 0.7152, 0.0722), np.float32)
_base: dict[str, NDArray[np.float32]] = {}
_inners: dict[str, NDArray[np.int64]] = {}
_soon: dict[str, MadeSoon[NDArray[np.float32]]] = {}
_table: list[NDArray[np.float32]] = []


def color_vertices(
    mesh: bpy.types.Mesh,
    shape: EpochShape,
    layers: TissueLayers,
    quantity: NDArray[np.float32] | None,
    highest: float,
) -> None:
    """Set the color attribute: skin and the layers below it, or the ramp on the skin and gray below it.

    The ramp shows a quantity (n,) where one is given. highest: the value at the top of the ramp.
    """
    if quantity is None:
        state = f"flesh {digest(layers).hex()}"
        if mesh.get(_STATE) != state:
            _set(mesh, flesh(shape, layers))
            mesh[_STATE] = state
        return
    if not _table:
        ramp = np.ones((_STEPS, 4), np.float32)
        ramp[:, :3] = ramp_linear(np.linspace(0.0, 1.0, _STEPS))
        _table.append(ramp)
    share = np.nan_to_num(quantity * np.float32(_STEPS / max(highest, 1e-9)))
    colors = _table[0][np.clip(share, 0, _STEPS - 1).astype(np.int32)]
    inner = _inner(shape)
    inside = flesh(shape, layers)[inner]
    colors[inner, :3] = (inside[:, :3] @ _LUMINANCE)[:, None]  # in its own colors it would read as high values
    _set(mesh, colors)
    mesh[_STATE] = "quantity"


def _set(mesh: bpy.types.Mesh, colors: NDArray[np.float32]) -> None:
    fresh = ATTRIBUTE not in mesh.attributes
    set_attribute(mesh, ATTRIBUTE, "FLOAT_COLOR", "POINT", colors)
    if fresh:
        mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]


def _inner(shape: EpochShape) -> NDArray[np.int64]:
    """The vertices that no skin touches."""
    if shape.key not in _inners:
        if len(_inners) > 32:
            _inners.clear()
        inner = np.ones(len(shape.rest), bool)
        inner[shape.triangles[shape.origin == SKIN].ravel()] = False
        _inners[shape.key] = np.flatnonzero(inner)
    return _inners[shape.key]


def soon_flesh(shape: EpochShape, layers: TissueLayers) -> MadeSoon[NDArray[np.float32]]:
    """`flesh`, found on a thread."""
    key = f"{shape.key} {digest(layers).hex()}"
    if key not in _soon:
        _soon.clear()
        _soon[key] = MadeSoon(partial(flesh, shape, layers))
    return _soon[key]


def flesh(shape: EpochShape, layers: TissueLayers) -> NDArray[np.float32]:
    """The colors (n, 4) of skin and the layers below it; kept, and from any thread."""
    key = f"{shape.key} {digest(layers).hex()}"
    if key not in _base:
        if len(_base) > 32:
            _base.clear()
        column = np.zeros(len(shape.rest), np.int32)
        if len(shape.column):
            column[shape.triangles] = shape.column[:, None]
        colors = np.ones((len(shape.rest), 4), np.float32)
        colors[:] = SKIN_COLOR
        inner = _inner(shape)
        colors[inner, :3] = layers.colors_at(column[inner], shape.depth[inner])
        _base[key] = colors
    return _base[key]
