"""The contact sheet: the steps of an operation side by side, numbered and captioned, in one PNG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lappet.drawing.figure_steps import Step

from .caption import draw_text, fitted, load_picture, save_picture, text_width
from .sheet_layout import sheet_layout

PAPER = (0.985, 0.982, 0.975)
INK = (0.13, 0.12, 0.12)
SOFT_INK = (0.42, 0.40, 0.39)
NUMBER_INK = (0.62, 0.16, 0.14)
HAIRLINE = (0.78, 0.77, 0.755)


def write_filmstrip(pictures: Sequence[Path], steps: Sequence[Step], path: Path) -> None:
    """Lay pictures of one size out on a sheet, the step's number, caption and detail under each."""
    panels = [load_picture(p) for p in pictures]
    high, wide = panels[0].shape[:2]
    (width, height), corners, _ = sheet_layout(len(panels), (wide, high))
    sheet = np.empty((height, width, 3), np.float32)
    sheet[:] = PAPER
    big, small = wide * 0.044, wide * 0.032
    for number, (panel, step, (x, y)) in enumerate(zip(panels, steps, corners, strict=True), start=1):
        sheet[y - 1 : y + high + 1, x - 1 : x + wide + 1] = HAIRLINE
        sheet[y : y + high, x : x + wide] = panel
        label = f"{number}"
        indent = text_width("0", big) + big * 0.75
        first = y + high + big * 1.55
        draw_text(sheet, label, (x, first), big, NUMBER_INK)
        draw_text(sheet, fitted(step.caption, big, wide - indent), (x + indent, first), big, INK)
        draw_text(sheet, fitted(step.detail, small, wide - indent), (x + indent, first + small * 1.6), small, SOFT_INK)
    save_picture(sheet, path)
