"""The color scale as an object: a card with a bar, ticks and numbers.

It is held into the camera's picture, or lies beside the skin where the scene has no camera.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix, Vector
from numpy.typing import NDArray

from lappet.drawing.quantity_scale import UNITS, ramp_linear

from ..look.skin_import import set_attribute
from .display_collection import ROLE, find_object, make_object, remove_object, set_visible
from .look_materials import part_material

_MADE_FOR = "lappet_legend"
_AT = "lappet_at"  # on a text: its place on the card
_STEPS = 48
_TICKS = 5
# The card is 1 wide and this high; the bar's box in it.
HEIGHT = 0.30
_BAR = (0.07, 0.115, 0.93, 0.185)
_CARD, _INK = (0.93, 0.93, 0.925), (0.033, 0.03, 0.03)
SHARE, MARGIN = 0.27, 0.03  # of the picture's width, or of its height and a half where that is less


def show_legend(
    scene: bpy.types.Scene,
    collection: bpy.types.Collection,
    quantity: str | None,
    highest: float,
    beside: NDArray[np.float64],
) -> None:
    """Show the scale of a quantity up to a value, or none.

    beside: (2, 3), Blender units: lowest and highest corner of what is shown, for a scene without a camera.
    """
    card = find_object(collection, "legend")
    if quantity is None:
        if card is not None:
            for each in (card, *_texts(collection)):
                set_visible(each, False)
        return
    card = make_object(collection, "legend", "Legend")
    made_for = f"{quantity} {highest:g}"
    if card.data.get(_MADE_FOR) != made_for or len(_texts(collection)) != _TICKS + 1:
        _build(collection, card, quantity, highest)
        card.data[_MADE_FOR] = made_for
    for each in (card, *_texts(collection)):
        set_visible(each, True)
    _place(scene, card, beside)
    for each in _texts(collection):  # not parented to the card: Blender would draw dashed lines to it
        if each.parent != card.parent:
            each.parent = card.parent
            each.matrix_parent_inverse = Matrix()
        _set_matrix(each, card.matrix_basis @ Matrix.Translation(each[_AT]))


def _texts(collection: bpy.types.Collection) -> list[bpy.types.Object]:
    return [each for each in collection.objects if str(each.get(ROLE, "")).startswith("legend text")]


def _build(collection: bpy.types.Collection, card: bpy.types.Object, quantity: str, highest: float) -> None:
    rectangles: list[tuple[float, float, float, float, float]] = [(0.0, 0.0, 1.0, HEIGHT, 0.0)]
    colors = [_CARD]
    left, low, right, high = _BAR
    width = (right - left) / _STEPS
    ramp = ramp_linear((np.arange(_STEPS) + 0.5) / _STEPS)
    for k in range(_STEPS):
        rectangles.append((left + k * width, low, left + (k + 1) * width, high, 0.001))
        colors.append(tuple(ramp[k]))
    ticks = np.linspace(left, right, _TICKS)
    for x in ticks:
        rectangles.append((x - 0.002, low - 0.018, x + 0.002, low, 0.001))
        colors.append(_INK)
    points = np.array([[(a, b, z), (c, b, z), (c, d, z), (a, d, z)] for a, b, c, d, z in rectangles]).reshape(-1, 3)
    mesh = card.data
    mesh.clear_geometry()
    mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 4).tolist())
    paint = np.ones((len(points), 4), np.float32)
    paint[:, :3] = np.repeat(np.array(colors), 4, axis=0)
    set_attribute(mesh, "Color", "FLOAT_COLOR", "POINT", paint)
    mesh.color_attributes.active_color = mesh.color_attributes["Color"]
    mesh.materials.clear()
    mesh.materials.append(part_material(collection, "legend", 1.0))
    _unlit(card)
    unit = UNITS[quantity].strip()
    _write(
        collection,
        card,
        0,
        f"{quantity.capitalize()}{f', {unit}' if unit else ''}",
        (left, high + 0.032),
        0.068,
        "LEFT",
    )
    for k, x in enumerate(ticks):
        _write(
            collection,
            card,
            k + 1,
            f"{chr(0x2265) + chr(0x2009) if k == _TICKS - 1 else ''}{highest * k / (_TICKS - 1):g}",
            (x, low - 0.072),
            0.05,
            "CENTER",
        )


def _write(
    collection: bpy.types.Collection,
    card: bpy.types.Object,
    number: int,
    words: str,
    at: tuple[float, float],
    size: float,
    align: str,
) -> None:
    remove_object(collection, f"legend text {number}")
    text = make_object(collection, f"legend text {number}", "Legend text", "FONT")
    text.data.body, text.data.size, text.data.align_x = words, size, align
    text.data.materials.append(part_material(collection, "legend ink", 1.0))
    text[_AT] = (*at, 0.002)
    _unlit(text)


def _unlit(each: bpy.types.Object) -> None:
    """Neither casts shadows nor shows in reflections: it is no part of the field."""
    each.hide_select = True
    for name in (
        "visible_shadow",
        "visible_diffuse",
        "visible_glossy",
        "visible_transmission",
        "visible_volume_scatter",
    ):
        if hasattr(each, name):
            setattr(each, name, False)


def _place(scene: bpy.types.Scene, card: bpy.types.Object, beside: NDArray[np.float64]) -> None:
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        low, high = beside
        wide = 0.36 * float(high[0] - low[0])
        card.parent = None
        middle = 0.5 * (low[0] + high[0]) - 0.5 * wide
        _set_matrix(
            card, Matrix.LocRotScale(Vector((middle, low[1] - 1.15 * HEIGHT * wide, high[2])), None, Vector([wide] * 3))
        )
        return
    corners = [Vector(c) for c in camera.data.view_frame(scene=scene)]
    away = 4.0 * camera.data.clip_start
    if camera.data.type != "ORTHO":
        corners = [c * (away / -c.z) for c in corners]
    left, right = min(c.x for c in corners), max(c.x for c in corners)
    bottom = min(c.y for c in corners)
    across = right - left
    share = min(across, 1.5 * (max(c.y for c in corners) - bottom))
    if card.parent != camera:
        card.parent = camera
        card.matrix_parent_inverse = Matrix()
    stretch = camera.matrix_world.to_scale()
    size = Vector([SHARE * share] * 3)
    at = Vector((left + MARGIN * share, bottom + MARGIN * share, -away))
    # A camera that is scaled must not scale the card: it looks as if it were not.
    undo = Vector([1.0 / max(abs(s), 1e-9) for s in stretch])
    _set_matrix(card, Matrix.LocRotScale(at * undo, None, size * undo))


def _set_matrix(card: bpy.types.Object, matrix: Matrix) -> None:
    if any(
        abs(a - b) > 1e-6 for ra, rb in zip(card.matrix_basis, matrix, strict=True) for a, b in zip(ra, rb, strict=True)
    ):
        card.matrix_basis = matrix
