"""What surfaces look like in viewers that know one color and one roughness for a material: skin, cut tissue, steel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_kind import KIND_COLORS, KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.drawing.skin_fields import RIM, SKIN

_PALE = 0.3  # of the skin's color in the rim of a patch, a quiet section through its layers


@dataclass(frozen=True)
class SurfaceLook:
    """A material of one color.

    Parameters
    ----------
    name
        Its name: letters only.
    title
        What a reader calls it.
    color
        Linear RGB from 0 to 1.
    roughness
        From 0 to 1.
    metallic
        From 0 to 1.
    """

    name: str
    title: str
    color: tuple[float, float, float]
    roughness: float
    metallic: float = 0.0

    @property
    def display_color(self) -> tuple[int, int, int]:
        """The color in sRGB, from 0 to 255."""
        linear = np.array(self.color)
        encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        r, g, b = (round(255.0 * float(each)) for each in encoded)
        return r, g, b


SKIN_LOOK = SurfaceLook("Skin", "Skin", (0.757, 0.478, 0.358), 0.55)
MUCOSA_LOOK = SurfaceLook("FreeBorder", "Free border", (0.62, 0.27, 0.24), 0.3)
BED_LOOK = SurfaceLook("WoundBed", "Wound bed", (0.53, 0.155, 0.125), 0.35)
VESSEL_LOOK = SurfaceLook("Vessel", "Vessels and nerves", (0.55, 0.1, 0.1), 0.34)
THREAD_LOOK = SurfaceLook("Thread", "Thread", (0.008, 0.012, 0.045), 0.32)
STEEL_LOOK = SurfaceLook("Steel", "Steel", (0.62, 0.64, 0.66), 0.36, 1.0)
LANDMARK_LOOK = SurfaceLook("Landmark", "Landmark", (0.02, 0.16, 0.42), 0.4)
BONE_LOOK = SurfaceLook("Bone", "Bone", (0.79, 0.72, 0.58), 0.6)
PLAIN_COLOR = (0.62, 0.62, 0.62)  # of all tissue where only its shape is to be seen


def face_looks(
    layers: TissueLayers,
    origin: NDArray[np.uint8],
    column: NDArray[np.int32],
    depth: NDArray[np.floating],
    free_rim: bool,
) -> tuple[list[SurfaceLook], NDArray[np.int64]]:
    """Choose what the faces of a skin look like: cut ones by the layer that they show.

    Parameters
    ----------
    layers
        The layers of the tissue.
    origin
        An index into `ORIGINS` for each face, shape (m,).
    column
        Its column of layers, shape (m,).
    depth
        Its depth below the skin in mm, shape (m,).
    free_rim
        Whether the rim of the tissue is a free border of the body, such as that of a lid, and no cut.

    Returns
    -------
    tuple[list[SurfaceLook], NDArray[np.int64]]
        The looks, and for each face the index of its own, shape (m,).
    """
    kind = layers.kind[layers.layers_at(column, depth)].astype(np.int64)
    rim = origin == RIM
    code = np.where(rim, len(KINDS) + kind, kind)
    if free_rim:
        code[rim] = 2 * len(KINDS)
    code[origin == SKIN] = -1
    found, index = np.unique(code, return_inverse=True)
    return [_look(int(each)) for each in found], index.reshape(-1)


def _look(code: int) -> SurfaceLook:
    if code < 0:
        return SKIN_LOOK
    if code == 2 * len(KINDS):
        return MUCOSA_LOOK
    kind = KINDS[code % len(KINDS)]
    color = KIND_COLORS[kind]
    if code < len(KINDS):
        return SurfaceLook(f"Cut{kind.capitalize()}", f"Cut {kind}", color, 0.32)
    r, g, b = ((1.0 - _PALE) * own + _PALE * skin for own, skin in zip(color, SKIN_LOOK.color, strict=True))
    return SurfaceLook(f"Rim{kind.capitalize()}", f"Rim, {kind}", (r, g, b), 0.6)
