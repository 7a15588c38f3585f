"""The color key of a picture that shows strain, stress or tension: a bar with its range and unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lappet.drawing.quantity_scale import UNITS, frame_peak, full_value, ramp_display
from lappet.drawing.skin_source import SkinSource

from .caption import draw_text, load_picture, save_picture, text_width

INK = (0.2, 0.19, 0.19)


def full_scale(cache: SkinSource, name: str) -> float:
    """The value at the top of the key: the 95th percentile of the frame that has most, rounded up."""
    values = (cache.scalar(epoch, name, time) for epoch in cache.epochs for time in epoch.frames)
    return full_value(max((frame_peak(v) for v in values if v is not None), default=0.0))


def draw_key(path: Path, name: str, highest: float) -> None:
    """Draw the key into the lower left of a picture file."""
    picture = load_picture(path)
    height, width = picture.shape[:2]
    size = max(9.0, width * 0.018)
    x, y, wide, high = round(width * 0.035), round(height * 0.93), round(width * 0.24), max(4, round(height * 0.018))
    pad = round(size * 0.9)
    card = picture[y - round(2.4 * size) : y + high + round(2.2 * size), x - pad : x + wide + pad]
    card[:] = 0.25 * card + 0.75 * 0.97
    picture[y : y + high, x : x + wide] = ramp_display(np.linspace(0.0, 1.0, wide))[None]
    draw_text(picture, name.capitalize(), (x, y - 0.6 * size), size, INK)
    draw_text(picture, "0", (x, y + high + 1.2 * size), size * 0.85, INK)
    top = f"≥ {highest:g}{UNITS[name]}"
    draw_text(picture, top, (x + wide - text_width(top, size * 0.85), y + high + 1.2 * size), size * 0.85, INK)
    save_picture(picture, path)
