"""The tools' icons, drawn from strokes and discs: `python -m lappet_blender.tools.icon_shapes` writes them anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .icon_file import Icon, write_icon

FOLDER = Path(__file__).parent / "icons"
Color = tuple[int, int, int, int]
_LIGHT: Color = (229, 229, 229, 255)
_DIM: Color = (150, 150, 150, 255)
_INK: Color = (174, 130, 255, 255)
_WARM: Color = (255, 150, 110, 255)
_ROUND = 20


class _Canvas:
    """Collects triangles; what is drawn later lies above."""

    def __init__(self) -> None:
        self._corners: list[NDArray[np.float64]] = []
        self._colors: list[Color] = []

    def fan(self, outline: ArrayLike, color: Color) -> None:
        """A convex outline (n, 2), filled."""
        points = np.asarray(outline, np.float64)
        for k in range(1, len(points) - 1):
            self._corners.append(points[[0, k, k + 1]])
            self._colors.append(color)

    def disc(self, center: Sequence[float], radius: float, color: Color) -> None:
        self.fan(_ellipse(center, (radius, radius)), color)

    def stroke(self, line: ArrayLike, width: float, color: Color, closed: bool = False) -> None:
        """A line (n, 2) of some width with round joins and ends."""
        points = np.asarray(line, np.float64)
        ends = np.roll(points, -1, axis=0) if closed else points[1:]
        for a, b in zip(points, ends, strict=False):
            along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
            side = 0.5 * width * np.array([-along[1], along[0]])
            self.fan([a + side, b + side, b - side, a - side], color)
        for point in points:
            self.fan(_ellipse(point, (0.5 * width, 0.5 * width), 8), color)

    def icon(self) -> Icon:
        corners = np.clip(np.rint(np.array(self._corners)), 0, 255).astype(np.uint8)
        return Icon(corners, np.repeat(np.array(self._colors, np.uint8)[:, None], 3, axis=1))


def _ellipse(
    center: Sequence[float] | NDArray[np.float64], radii: tuple[float, float], count: int = _ROUND
) -> NDArray[np.float64]:
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.asarray(center, np.float64) + np.stack([np.cos(angle), np.sin(angle)], axis=1) * radii


def _arc(center: Sequence[float], radius: float, start: float, stop: float, count: int = 14) -> NDArray[np.float64]:
    angle = np.radians(np.linspace(start, stop, count))
    return np.asarray(center, np.float64) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _edit(c: _Canvas) -> None:
    c.stroke([(40, 60), (85, 120), (150, 140), (215, 200)], 12, _INK)
    for point in ((40, 60), (215, 200)):
        c.disc(point, 20, _INK)
    # An arrow with its tip at the line.
    c.fan([(112, 178), (112, 52), (146, 84)], _LIGHT)
    c.fan([(112, 178), (146, 84), (204, 86)], _LIGHT)
    c.stroke([(146, 84), (168, 40)], 22, _LIGHT)


def _incision(c: _Canvas) -> None:
    c.stroke([(24, 52), (60, 36), (100, 34)], 14, _INK)
    c.fan([(100, 34), (158, 74), (132, 104)], _LIGHT)
    c.fan([(100, 34), (132, 104), (116, 90)], _LIGHT)
    c.stroke([(150, 96), (212, 190)], 34, _DIM)
    c.stroke([(206, 180), (226, 212)], 22, _DIM)


def _excise(c: _Canvas) -> None:
    c.stroke(_ellipse((128, 128), (100, 58), 24), 16, _INK, closed=True)
    c.stroke([(96, 98), (160, 158)], 20, _WARM)
    c.stroke([(96, 158), (160, 98)], 20, _WARM)


def _undermine(c: _Canvas) -> None:
    loop = _ellipse((128, 150), (98, 54), 40)
    for k in range(0, 40, 5):
        c.stroke(loop[k : k + 4], 14, _INK)
    c.stroke([(34, 60), (200, 60)], 18, _LIGHT)
    c.fan([(190, 94), (236, 60), (190, 26)], _LIGHT)


def _thin(c: _Canvas) -> None:
    c.stroke([(24, 176), (128, 206), (232, 176)], 20, _INK)
    c.stroke([(36, 126), (128, 152), (220, 126)], 12, _LIGHT)
    for k in range(4):
        x = 52 + 50 * k
        c.stroke([(x - 16, 42), (x + 16, 92)], 12, _WARM)


def _hook(c: _Canvas) -> None:
    bend = _arc((112, 88), 54, 0, -220, 18)
    c.stroke(np.vstack([[(166, 232)], bend]), 22, _LIGHT)
    tip = bend[-1]
    c.fan(tip + np.array([(-30, -6), (24, 12), (-8, 52)]), _LIGHT)
    c.stroke([(24, 18), (112, 34), (212, 16)], 12, _INK)


def _retractor(c: _Canvas) -> None:
    c.stroke([(222, 222), (136, 136)], 30, _DIM)
    c.stroke([(84, 188), (188, 84)], 22, _LIGHT)
    for x, y in ((84, 188), (136, 136), (188, 84)):
        c.stroke([(x, y), (x - 50, y - 50), (x - 52, y - 78)], 18, _LIGHT)


def _suture(c: _Canvas) -> None:
    c.stroke([(128, 20), (118, 90), (138, 160), (128, 236)], 14, _INK)
    for y in (62, 128, 194):
        c.stroke([(56, y - 18), (200, y + 18)], 16, _LIGHT)
        c.disc((56, y - 18), 14, _LIGHT)
        c.disc((200, y + 18), 14, _LIGHT)


def _landmark(c: _Canvas) -> None:
    c.stroke(_ellipse((128, 128), (64, 64), 28), 16, _LIGHT, closed=True)
    c.disc((128, 128), 20, _INK)
    for x, y in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        c.stroke([(128 + 84 * x, 128 + 84 * y), (128 + 110 * x, 128 + 110 * y)], 16, _LIGHT)


ICONS: dict[str, Callable[[_Canvas], None]] = {
    "edit": _edit,
    "incision": _incision,
    "excise": _excise,
    "undermine": _undermine,
    "thin": _thin,
    "hook": _hook,
    "retractor": _retractor,
    "suture": _suture,
    "landmark": _landmark,
}


def draw_icon(name: str) -> Icon:
    """The icon of a tool; KeyError for a name that is none of `ICONS`."""
    canvas = _Canvas()
    ICONS[name](canvas)
    return canvas.icon()


def icon_path(name: str) -> str:
    """What a tool's `bl_icon` says: the icon's file without its ending."""
    return str(FOLDER / f"lappet.{name}")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for each in ICONS:
        write_icon(FOLDER / f"lappet.{each}.dat", draw_icon(each))
