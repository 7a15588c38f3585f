"""The color scale of strain, stress and tension: its full value, its unit, its colors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Shares of full scale and linear colors: from blue by pale to red, told apart without seeing red and green.
RAMP = (
    (0.0, (0.13, 0.25, 0.55)),
    (0.25, (0.22, 0.58, 0.68)),
    (0.5, (0.90, 0.86, 0.68)),
    (0.75, (0.90, 0.47, 0.20)),
    (1.0, (0.60, 0.06, 0.07)),
)
UNITS = {"strain": "", "stress": " kPa", "tension": " kPa"}
PERCENTILE = 95.0  # what is beyond is at the points that hooks hold, and takes the top color
MANTISSAS = (1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def frame_peak(values: NDArray[np.floating]) -> float:
    """Find what a frame asks of the scale.

    Parameters
    ----------
    values
        The quantity at the points of a frame, shape (n,).

    Returns
    -------
    float
        The 95th percentile of the magnitudes, 0 where there is none.
    """
    size = np.abs(values[np.isfinite(values)])
    return float(np.percentile(size, PERCENTILE)) if len(size) else 0.0


def full_value(peak: float) -> float:
    """Choose the value at the top of the scale.

    Parameters
    ----------
    peak
        The greatest that any frame asks of it.

    Returns
    -------
    float
        The peak rounded up to where quarters are short; 1 where there is none.
    """
    if not np.isfinite(peak) or peak <= 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(peak))
    return float(next(m * power for m in MANTISSAS if m * power >= peak * (1 - 1e-9)))


def ramp_linear(share: NDArray[np.floating]) -> NDArray[np.float64]:
    """Find the colors of a quantity.

    Parameters
    ----------
    share
        Shares of full scale, shape (n,).

    Returns
    -------
    NDArray[np.float64]
        Linear colors from 0 to 1, held at the ends, shape (n, 3).
    """
    stops = np.array([position for position, _ in RAMP])
    colors = np.array([color for _, color in RAMP])
    return np.stack([np.interp(share, stops, colors[:, k]) for k in range(3)], axis=-1)


def ramp_display(share: NDArray[np.floating]) -> NDArray[np.float64]:
    """Find the colors of a quantity as they are displayed.

    Parameters
    ----------
    share
        Shares of full scale, shape (n,).

    Returns
    -------
    NDArray[np.float64]
        Colors in sRGB from 0 to 1, shape (n, 3).
    """
    mixed = ramp_linear(share)
    return np.where(mixed <= 0.0031308, 12.92 * mixed, 1.055 * mixed ** (1 / 2.4) - 0.055)
