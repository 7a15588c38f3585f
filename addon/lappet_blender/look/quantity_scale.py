"""The color scale of strain, stress and tension: its full value, its unit, its colors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .skin_material import RAMP

UNITS = {"strain": "", "stress": " kPa", "tension": " kPa"}
PERCENTILE = 95.0  # what is beyond is at the points that hooks hold, and takes the top color
MANTISSAS = (1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def frame_peak(values: NDArray[np.floating]) -> float:
    """What a frame asks of the scale: the 95th percentile of the magnitudes (n,), 0 where there is none."""
    size = np.abs(values[np.isfinite(values)])
    return float(np.percentile(size, PERCENTILE)) if len(size) else 0.0


def full_value(peak: float) -> float:
    """The value at the top of the scale: a peak rounded up to where quarters are short; 1 where there is none."""
    if not np.isfinite(peak) or peak <= 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(peak))
    return float(next(m * power for m in MANTISSAS if m * power >= peak * (1 - 1e-9)))


def ramp_linear(share: NDArray[np.floating]) -> NDArray[np.float64]:
    """Linear colors (n, 3) of shares (n,) of full scale, held at the ends."""
    stops = np.array([position for position, _ in RAMP])
    colors = np.array([color for _, color in RAMP])
    return np.stack([np.interp(share, stops, colors[:, k]) for k in range(3)], axis=-1)
