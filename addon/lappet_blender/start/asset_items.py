"""What the asset library offers: models, materials, threads, instruments and plates, as values with a picture each.

Flaps are in it too; they are plans to scale, which `events.flap_assets` makes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.models.new_model import MODELS
from lappet.plates.plate_templates import TEMPLATES
from lappet.procedure import Material
from lappet.procedure.threads import THREADS, Thread
from lappet.tissue.presets import PRESETS
from lappet.tissue.uniaxial import nominal_stresses, stretches_under

SIZE = 128  # pixels of a picture
KINDS = ("model", "material", "thread", "instrument", "plate")
CATALOGS = {
    "model": "Lappet/Models",
    "material": "Lappet/Materials",
    "thread": "Lappet/Threads",
    "instrument": "Lappet/Instruments",
    "plate": "Lappet/Plates",
}
INSTRUMENTS = {
    "hook": "A skin hook: pulls the point of the skin where it is dropped",
    "landmark": "A landmark: follows the point of the skin where it is dropped, and is measured",
}
PLATES = {
    "steps": "A page of the operation's steps",
    "atlas": "A page as in an atlas: fewer, larger drawings",
    "comparison": "Before and after",
    "section": "The wound in section",
    "cover": "One large drawing",
}
_MOST_STRETCH, _MOST_STRESS = 1.4, 10_000.0  # of the axes: kPa
_PAPER = np.array([0.93, 0.90, 0.86])
_SKIN = np.array([0.83, 0.62, 0.51])
_INK = np.array([0.16, 0.13, 0.12])
_STEEL = np.array([0.45, 0.48, 0.52])
_PEN = np.array([0.36, 0.20, 0.60])


@dataclass(frozen=True)
class AssetItem:
    """An asset. kind: of `KINDS`. name: what the product calls it. title, description: for the asset browser."""

    kind: str
    name: str
    title: str
    description: str

    @property
    def tag(self) -> str:
        """What an object says that stands for it."""
        return f"{self.kind}:{self.name}"


def asset_items() -> list[AssetItem]:
    """Every asset but the flaps."""
    found = [AssetItem("model", name, _title(name), each.title) for name, each in MODELS.items()]
    found += [AssetItem("material", name, _title(name), each.source) for name, each in PRESETS.items()]
    found += [AssetItem("thread", name, _title(name), _of_thread(each)) for name, each in THREADS.items()]
    found += [AssetItem("instrument", name, _title(name), text) for name, text in INSTRUMENTS.items()]
    found += [AssetItem("plate", name, f"Plate: {name}", PLATES.get(name, "")) for name in TEMPLATES]
    return found


def item_of(tag: str) -> AssetItem | None:
    """The asset that an object stands for, None for none that is known."""
    return next((each for each in asset_items() if each.tag == tag), None)


def picture(item: AssetItem) -> NDArray[np.float32]:
    """A small picture of an asset, shape (SIZE, SIZE, 4), from below."""
    canvas = _Canvas()
    _DRAWN[item.kind](canvas, item)
    return canvas.pixels()


class _Canvas:
    """Pixels on paper; places run from 0 to 1, y up."""

    def __init__(self) -> None:
        line = (np.arange(SIZE) + 0.5) / SIZE
        self.x, self.y = np.meshgrid(line, line)
        self._color = np.broadcast_to(_PAPER, (SIZE, SIZE, 3)).copy()

    def fill(self, share: NDArray[np.float64], color: NDArray[np.float64]) -> None:
        """Lay a color over pixels by their shares."""
        part = np.clip(share, 0.0, 1.0)[..., None]
        self._color = part * color + (1.0 - part) * self._color

    def box(self, x0: float, x1: float, y0: float, y1: float, color: NDArray[np.float64]) -> None:
        """A rectangle."""
        inside = (self.x >= x0) & (self.x <= x1) & (self.y >= y0) & (self.y <= y1)
        self.fill(inside.astype(np.float64), color)

    def line(self, points: NDArray[np.float64], width: float, color: NDArray[np.float64]) -> None:
        """A polyline of a width."""
        away = np.full(self.x.shape, np.inf)
        for a, b in pairwise(points):
            along = b - a
            t = ((self.x - a[0]) * along[0] + (self.y - a[1]) * along[1]) / max(float(along @ along), 1e-12)
            t = np.clip(t, 0.0, 1.0)
            away = np.minimum(away, np.hypot(self.x - a[0] - t * along[0], self.y - a[1] - t * along[1]))
        self.fill((0.5 * width - away) * SIZE + 0.5, color)

    def pixels(self) -> NDArray[np.float32]:
        """The picture."""
        return np.concatenate([self._color, np.ones((SIZE, SIZE, 1))], axis=-1).astype(np.float32)


def _model(canvas: _Canvas, item: AssetItem) -> None:
    """A piece of skin with its grid: flat, or domed as bodies are."""
    bend = 0.0 if item.name == "patch" else 0.14
    x, y = canvas.x, canvas.y
    rise = bend * (1.0 - ((x - 0.5) / 0.4) ** 2)
    inside = (np.abs(x - 0.5) < 0.4) & (y > 0.22 + rise) & (y < 0.72 + rise)
    canvas.fill(inside.astype(np.float64), _SKIN)
    edge = (np.abs(x - 0.5) < 0.4) & (y > 0.14 + rise) & (y <= 0.22 + rise)
    canvas.fill(edge.astype(np.float64), np.array([0.86, 0.70, 0.36]))
    for k in range(9):
        at = 0.1 + 0.1 * k
        canvas.fill(inside * ((0.006 - np.abs(x - at)) * SIZE + 0.5) * 0.8, _SKIN * 0.6)
        canvas.fill(inside * ((0.006 - np.abs(y - rise - at)) * SIZE + 0.5) * 0.8, _SKIN * 0.6)
    if bend:
        shade = inside * np.clip(0.9 * (x - 0.5), 0.0, 0.35)
        canvas.fill(shade, _INK)


def _material(canvas: _Canvas, item: AssetItem) -> None:
    """What it takes to stretch it along its fibers, on a logarithmic axis, and a dot at how it is stretched in vivo."""
    material = PRESETS[item.name].material
    canvas.line(np.array([[0.14, 0.92], [0.14, 0.1], [0.92, 0.1]]), 0.012, _INK)
    stretch = np.linspace(1.0, _MOST_STRETCH, 24)
    curve = np.array([_on_paper(each, _stress(material, each)) for each in stretch])
    canvas.line(curve, 0.028, np.array([0.75, 0.25, 0.2]))
    now = min(max(float(material.prestretch[0]), 1.0), _MOST_STRETCH)
    at = np.array(_on_paper(now, _stress(material, now)))
    canvas.line(np.array([at, at + 1e-6]), 0.09, _INK)


def _stress(material: Material, stretch: float) -> float:
    """Nominal stress in kPa at a stretch along the fibers, free across."""
    found = stretches_under(material, {0: stretch}, {1: 0.0, 2: 0.0})
    return float(nominal_stresses(material, found)[0])


def _on_paper(stretch: float, stress: float) -> tuple[float, float]:
    """The place of a stretch and a stress in kPa in a picture."""
    high = np.log10(1.0 + max(stress, 0.0)) / np.log10(1.0 + _MOST_STRESS)
    return 0.14 + 0.74 * (stretch - 1.0) / (_MOST_STRETCH - 1.0), 0.1 + 0.78 * min(float(high), 1.0)


def _thread(canvas: _Canvas, item: AssetItem) -> None:
    """A thread as thick as it is, enlarged, on a needle."""
    thread = THREADS[item.name]
    angle = np.linspace(np.pi, 1.9 * np.pi, 40)
    needle = np.stack([0.62 + 0.26 * np.cos(angle), 0.58 + 0.26 * np.sin(angle)], axis=1)
    x = np.linspace(0.0, 1.0, 60)
    tail = np.stack([0.36 - 0.28 * x, 0.58 + 0.22 * np.sin(2.5 * np.pi * x) * x], axis=1)
    colors = {"nylon": (0.10, 0.16, 0.42), "silk": (0.08, 0.08, 0.08), "polypropylene": (0.12, 0.30, 0.65)}
    color = np.array(colors.get(item.name.split()[0], (0.45, 0.20, 0.50)))
    canvas.line(tail, max(0.25 * thread.diameter, 0.012), color)
    canvas.line(needle, 0.03, _STEEL)


def _instrument(canvas: _Canvas, item: AssetItem) -> None:
    """A hook, or a cross of a pen in a circle."""
    if item.name == "hook":
        angle = np.linspace(0.0, 1.15 * np.pi, 40)
        bow = np.stack([0.42 + 0.12 * np.cos(angle), 0.32 - 0.14 * np.sin(angle)], axis=1)
        canvas.line(np.vstack([[0.62, 0.92], [0.54, 0.32], bow]), 0.045, _STEEL)
        return
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    canvas.line(np.stack([0.5 + 0.24 * np.cos(angle), 0.5 + 0.24 * np.sin(angle)], axis=1), 0.03, _PEN)
    canvas.line(np.array([[0.5, 0.16], [0.5, 0.84]]), 0.02, _PEN)
    canvas.line(np.array([[0.16, 0.5], [0.84, 0.5]]), 0.02, _PEN)


def _plate(canvas: _Canvas, item: AssetItem) -> None:
    """A page with its panels."""
    columns, rows = {"steps": (2, 3), "atlas": (2, 2), "comparison": (2, 1), "section": (1, 2)}.get(item.name, (1, 1))
    canvas.box(0.18, 0.82, 0.06, 0.94, np.array([1.0, 1.0, 1.0]))
    wide, high = 0.56 / columns, 0.8 / rows
    for column in range(columns):
        for row in range(rows):
            x0, y0 = 0.22 + column * wide, 0.1 + row * high
            canvas.box(x0 + 0.01, x0 + wide - 0.01, y0 + 0.03, y0 + high - 0.01, _SKIN)
            middle = y0 + 0.55 * high
            zigzag = [
                [x0 + 0.2 * wide, middle + 0.2 * high],
                [x0 + 0.75 * wide, middle],
                [x0 + 0.3 * wide, middle - 0.1 * high],
            ]
            canvas.line(np.array(zigzag), 0.012, _INK)
            canvas.box(x0 + 0.01, x0 + 0.6 * wide, y0 + 0.008, y0 + 0.018, _INK)


_DRAWN: dict[str, Any] = {
    "model": _model,
    "material": _material,
    "thread": _thread,
    "instrument": _instrument,
    "plate": _plate,
}


def _title(name: str) -> str:
    return name.replace("_", " ").replace("-", " ").capitalize() if "-0" not in name else name.capitalize()


def _of_thread(thread: Thread) -> str:
    return f"{thread.diameter:g} mm, {thread.modulus:g} MPa, cuts through at {thread.pull_through / 1000:g} N"
