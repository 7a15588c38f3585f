r"""Blender's geometry icons (`.dat`): triangles in 256 x 256 places, colored per corner.

The format, as Blender's `blender_icons_geom.py` writes it: b"VCO\0", the largest x and y, the start x and y (a byte
each), then x, y per corner, then red, green, blue, alpha per corner, three corners a triangle; y points up.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

MAGIC = b"VCO\x00"


@dataclass(frozen=True, eq=False)
class Icon:
    """An icon. corners: (t, 3, 2) uint8 with y up. colors: (t, 3, 4) uint8."""

    corners: NDArray[np.uint8]
    colors: NDArray[np.uint8]


def write_icon(path: Path, icon: Icon) -> None:
    """Write an icon; triangles are turned counterclockwise, as they are in Blender's own icons."""
    a, b, c = np.moveaxis(icon.corners.astype(np.int64), 1, 0)
    turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    corners = np.where((turn < 0)[:, None, None], icon.corners[:, ::-1], icon.corners)
    path.write_bytes(MAGIC + bytes((255, 255, 0, 0)) + corners.tobytes() + icon.colors.tobytes())
