"""Text and flat color in pictures, drawn by Blender's own font engine into arrays; no other library."""

from __future__ import annotations

import tempfile
from pathlib import Path

import blf
import bpy
import imbuf
import numpy as np
from numpy.typing import NDArray

from .png_file import publish_png

Picture = NDArray[np.float32]


def load_picture(path: Path) -> Picture:
    """A picture file as (height, width, 3) float32 in 0 to 1, first row on top."""
    image = bpy.data.images.load(str(path), check_existing=False)
    try:
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        flat = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(flat)
        return flat.reshape(height, width, image.channels)[::-1, :, :3].copy()
    finally:
        bpy.data.images.remove(image)


def save_picture(picture: Picture, path: Path) -> None:
    """Write (height, width, 3) as PNG; the file appears whole or not at all."""
    height, width = picture.shape[:2]
    image = bpy.data.images.new("Sheet", width, height, alpha=False, float_buffer=False)
    try:
        image.colorspace_settings.name = "Non-Color"
        flat = np.ones((height, width, 4), np.float32)
        flat[..., :3] = np.clip(picture[::-1], 0.0, 1.0)
        image.pixels.foreach_set(flat.ravel())
        draft = path.with_name(f".{path.stem}.part.png")
        image.filepath_raw, image.file_format = str(draft), "PNG"
        image.save()
        publish_png(draft, path)
    finally:
        bpy.data.images.remove(image)


def shrunk(picture: Picture, size: tuple[int, int]) -> Picture:
    """A picture at a smaller size (width, height) in pixels, every pixel the mean of the area that it covers."""
    for axis, count in ((0, size[1]), (1, size[0])):
        total = np.concatenate([np.zeros_like(picture.take([0], axis)), picture.cumsum(axis, dtype=np.float64)], axis)
        borders = np.linspace(0.0, picture.shape[axis], count + 1)
        low = np.floor(borders).astype(int).clip(max=picture.shape[axis] - 1)
        share = (borders - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        at = total.take(low, axis) * (1 - share) + total.take(low + 1, axis) * share
        picture = np.diff(at, axis=axis) * (count / picture.shape[axis])
    return picture.astype(np.float32)


def text_width(text: str, size: float) -> float:
    """Width of a line of text in pixels."""
    blf.size(0, size)
    return float(blf.dimensions(0, text)[0])


def fitted(text: str, size: float, width: float) -> str:
    """The text, cut with an ellipsis where it is wider than a width in pixels."""
    if text_width(text, size) <= width:
        return text
    while text and text_width(text + "…", size) > width:
        text = text[:-1].rstrip(" ,")
    return text + "…"


def draw_text(
    picture: Picture, text: str, at: tuple[float, float], size: float, color: tuple[float, float, float]
) -> None:
    """Set a line of text into a picture. at: left end of the baseline, (x, y) in pixels from the top left."""
    if not text:
        return
    height, width = picture.shape[:2]
    pad = int(size)
    box = (int(text_width(text, size)) + 2 * pad, int(2.4 * size))
    base = int(0.8 * size)
    buffer = imbuf.new(box)
    blf.size(0, size)
    blf.color(0, 1.0, 1.0, 1.0, 1.0)
    blf.position(0, pad, base, 0)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "text.png"
        with blf.bind_imbuf(0, buffer):
            blf.draw_buffer(0, text)
        imbuf.write(buffer, filepath=str(file))
        image = bpy.data.images.load(str(file), check_existing=False)
        image.colorspace_settings.name = "Non-Color"
        image.alpha_mode = "CHANNEL_PACKED"
        flat = np.empty(box[0] * box[1] * 4, np.float32)
        image.pixels.foreach_get(flat)
        bpy.data.images.remove(image)
    ink = flat.reshape(box[1], box[0], 4)[::-1, :, 3]
    left, top = round(at[0]) - pad, round(at[1]) - (box[1] - base)
    x0, y0, x1, y1 = max(left, 0), max(top, 0), min(left + box[0], width), min(top + box[1], height)
    if x0 >= x1 or y0 >= y1:
        return
    cover = ink[y0 - top : y1 - top, x0 - left : x1 - left, None]
    picture[y0:y1, x0:x1] = picture[y0:y1, x0:x1] * (1 - cover) + np.asarray(color, np.float32) * cover
