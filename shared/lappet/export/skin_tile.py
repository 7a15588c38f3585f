"""A piece of skin as a picture that repeats: its color, faintly mottled, with or without the grid of 5 mm on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.surface_look import SKIN_LOOK
from lappet.export.grid_tile import grid_ink
from lappet.output.png_writer import write_png

SQUARES = 8  # of the grid, in each direction
_SIZE = 768  # pixels
_BLOTCH, _PORE = 4.0, 0.5  # mm: how large spots are
_SHARE = np.array([0.012, 0.022, 0.022])  # of the color, by which they differ: redness is more even than lightness


def write_skin_tile(path: Path, grid: bool = True) -> None:
    """Write the picture, a PNG in sRGB.

    Parameters
    ----------
    path
        The file.
    grid
        Whether the grid is printed on it.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    noise = 0.6 * _noise(_BLOTCH, 1) + 0.8 * _noise(_PORE, 2)
    linear = np.array(SKIN_LOOK.color) * (1.0 + noise[..., None] * _SHARE)
    linear = grid_ink(linear, SQUARES) if grid else linear
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear.clip(1e-9) ** (1 / 2.4) - 0.055)
    write_png(np.rint(255.0 * encoded.clip(0.0, 1.0)).astype(np.uint8), path)


def _noise(size: float, seed: int) -> NDArray[np.float64]:
    """Random spots of a size in mm, without a seam, of variance 1."""
    pixels = size * _SIZE / (SQUARES * 5.0)
    wave = np.fft.fftfreq(_SIZE)
    damped = np.exp(-0.5 * (np.pi * pixels) ** 2 * (wave[:, None] ** 2 + wave[None] ** 2) / 2.0)
    white = np.random.default_rng(seed).standard_normal((_SIZE, _SIZE))
    spots = np.fft.ifft2(np.fft.fft2(white) * damped).real
    return spots / spots.std()
