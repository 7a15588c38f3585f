"""The colour key of a picture that shows strain, stress or tension: a bar with its range and unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..look.skin_material import RAMP
from ..look.skin_source import SkinSource
from .caption import draw_text, load_picture, save_picture, text_width

UNITS = {"strain": "", "stress": " kPa", "tension": " kPa"}
INK = (0.2, 0.19, 0.19)


def full_scale(cache: SkinSource, name: str) -> float:
    """The value at the top of the key: the 99th percentile of all frames, rounded up to 1, 2 or 5 times 10ⁿ."""
    peaks = []
    for epoch in cache.epochs:
        for time in epoch.frames:
            values = cache.scalar(epoch, name, time)
            if values is not None and len(values):
                peaks.append(float(np.percentile(np.abs(values), 99)))
    peak = max(peaks, default=0.0)
    if not np.isfinite(peak) or peak <= 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(peak))
    return float(next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= peak * (1 - 1e-9)))


def ramp_colour(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Display colours (n, 3), sRGB 0 to 1, of shares (n,) of full scale."""
    stops = np.array([position for position, _ in RAMP])
    linear = np.array([colour for _, colour in RAMP])
    mixed = np.stack([np.interp(share, stops, linear[:, k]) for k in range(3)], axis=-1)
    return np.where(mixed <= 0.0031308, 12.92 * mixed, 1.055 * mixed ** (1 / 2.4) - 0.055)


def draw_key(path: Path, name: str, highest: float) -> None:
    """Draw the key into the lower left of a picture file."""
    picture = load_picture(path)
    height, width = picture.shape[:2]
    size = max(9.0, width * 0.018)
    x, y, wide, high = round(width * 0.035), round(height * 0.93), round(width * 0.24), max(4, round(height * 0.018))
    pad = round(size * 0.9)
    card = picture[y - round(2.4 * size) : y + high + round(2.2 * size), x - pad : x + wide + pad]
    card[:] = 0.25 * card + 0.75 * 0.97
    picture[y : y + high, x : x + wide] = ramp_colour(np.linspace(0.0, 1.0, wide))[None]
    draw_text(picture, name.capitalize(), (x, y - 0.6 * size), size, INK)
    draw_text(picture, "0", (x, y + high + 1.2 * size), size * 0.85, INK)
    top = f"{highest:g}{UNITS[name]}"
    draw_text(picture, top, (x + wide - text_width(top, size * 0.85), y + high + 1.2 * size), size * 0.85, INK)
    save_picture(picture, path)
