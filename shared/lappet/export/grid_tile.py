"""The grid that is printed on the skin, as a small picture that repeats: one square of 5 mm."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.surface_look import SKIN_LOOK
from lappet.output.png_writer import write_png

SIZE = 256  # pixels
_PITCH, _TICK = 5.0, 1.0  # mm
_HEAVY, _FINE = 0.24, 0.09  # widths of lines in mm
_INK = np.array([0.235, 0.11, 0.085])  # linear
_SHARE, _TICK_SHARE = 0.62, 0.12


def grid_tile() -> bytes:
    """Draw the square; its lines are at its borders.

    Returns
    -------
    bytes
        A PNG. White is the skin's own color, by which viewers multiply it.
    """
    share = grid_ink(np.ones((SIZE, SIZE, 3)), 1, _INK / np.array(SKIN_LOOK.color))
    encoded = np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "grid.png"
        write_png(np.rint(255.0 * encoded.clip(0.0, 1.0)).astype(np.uint8), path)
        return path.read_bytes()


def grid_ink(picture: NDArray[np.float64], squares: int, ink: NDArray[np.float64] = _INK) -> NDArray[np.float64]:
    """Print the grid on a picture.

    Parameters
    ----------
    picture
        Linear colors, shape (k, k, 3).
    squares
        How many squares of the grid it holds in each direction; lines are at its borders.
    ink
        The linear color of the lines.

    Returns
    -------
    NDArray[np.float64]
        The colors with the grid, of the same shape.
    """
    place = (np.arange(len(picture)) + 0.5) / len(picture) * _PITCH * squares
    wide, fine = _lines(place, _PITCH, _HEAVY), _lines(place, _TICK, _FINE)
    share = np.maximum(
        _SHARE * np.maximum(wide[:, None], wide[None]), _TICK_SHARE * np.maximum(fine[:, None], fine[None])
    )[..., None]
    return np.asarray((1.0 - share) * picture + share * ink)


def _lines(place: NDArray[np.float64], pitch: float, width: float) -> NDArray[np.float64]:
    """1 on lines at every multiple of a pitch, softened over a third of their width."""
    away = np.abs((place + pitch / 2) % pitch - pitch / 2)
    step = ((0.67 * width - away) / (0.34 * width)).clip(0.0, 1.0)
    return np.asarray(step * step * (3.0 - 2.0 * step))
