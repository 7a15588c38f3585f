"""Compare the placing of labels with adjustText and textalloc on 50 sets: `compare_labels.py`.

Needs both from PyPI besides the development packages: `pip install adjustText==1.4.0 textalloc==1.2.4`. Writes
docs/label_comparison.json; `documents.py --write` brings it into docs/plates.md.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, Point, Polygon, box

from lappet.plates.boundary_labels import place_labels
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_style import LEAST_TEXT, POINT
from lappet.plates.plate_words import plate_words

ROOT = Path(__file__).resolve().parent.parent
RESULT = ROOT / "docs" / "label_comparison.json"
SIZE = (56.0, 42.0)  # mm: a panel of a page of 174 mm
SETS, MOST = 50, 20
_LINE = 1.2 * LEAST_TEXT * POINT
_GAP = 0.4 * _LINE  # between a text and its leader
_TOUCH = 0.05  # mm: what is nearer to each other than that touches
_WIDEST = 14.0  # mm: of two columns of longer texts nothing is left of a panel


@dataclass(frozen=True)
class LabelSet:
    """Texts and what they name, in mm from the panel's middle, y downwards; shape (n, 2)."""

    texts: tuple[str, ...]
    sites: NDArray[np.float64]


@dataclass(frozen=True)
class Placed:
    """Where one text came to stand, and its leader."""

    text: Polygon
    leader: LineString


def label_set(seed: int) -> LabelSet:
    """Make a set of 2 to `MOST` labels of places in the middle half of a panel, with words of the catalogue."""
    font = PlateFont()
    every = [text for key, text in plate_words("en").texts.items() if key.startswith("label.")]
    words = [text for text in every if font.width(text, LEAST_TEXT * POINT) <= _WIDEST]
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, MOST + 1))
    texts = tuple(str(rng.choice(words)) for _ in range(count))
    return LabelSet(texts, rng.uniform((-14.0, -18.0), (14.0, 18.0), (count, 2)))


def by_lappet(labels: LabelSet) -> list[Placed]:
    """Place labels as plates do."""
    font = PlateFont()
    widths = [font.width(text, LEAST_TEXT * POINT) for text in labels.texts]
    found = place_labels(list(zip(labels.texts, labels.sites, strict=True)), widths, SIZE, _LINE, labels.sites)
    placed = []
    for label, width in zip(found, widths, strict=True):
        near = label.port[0] + (-_GAP if label.left else _GAP)
        far = near + (-width if label.left else width)
        y = label.port[1]
        text = box(min(near, far), y - 0.5 * _LINE, max(near, far), y + 0.5 * _LINE)
        placed.append(Placed(text, LineString([label.site, label.port])))
    return placed


def by_adjust_text(labels: LabelSet) -> list[Placed]:
    """Place labels with adjustText."""
    from adjustText import adjust_text

    figure, axes = _panel()
    x, y = labels.sites.T
    own = [axes.text(*site, text, fontsize=LEAST_TEXT) for site, text in zip(labels.sites, labels.texts, strict=True)]
    adjust_text(own, x, y, ax=axes)
    return _measured(figure, axes, own, labels)


def by_textalloc(labels: LabelSet) -> list[Placed]:
    """Place labels with textalloc, which is told to avoid crossings."""
    import textalloc

    figure, axes = _panel()
    x, y = labels.sites.T
    textalloc.allocate(
        *(axes, x, y, list(labels.texts)),
        x_scatter=x,
        y_scatter=y,
        textsize=LEAST_TEXT,
        max_distance=0.6,
        avoid_label_lines_overlap=True,
        avoid_crossing_label_lines=True,
    )
    return _measured(figure, axes, list(axes.texts), labels)


def _panel() -> tuple[Any, Any]:
    """An empty panel in matplotlib, in mm."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(SIZE[0] / 25.4, SIZE[1] / 25.4), dpi=300)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(-0.5 * SIZE[0], 0.5 * SIZE[0])
    axes.set_ylim(0.5 * SIZE[1], -0.5 * SIZE[1])
    return figure, axes


def _measured(figure: Any, axes: Any, texts: Sequence[Any], labels: LabelSet) -> list[Placed]:
    """Where matplotlib has drawn texts; the leader is the shortest way from the place to its text."""
    figure.canvas.draw()
    back = axes.transData.inverted()
    left = list(range(len(labels.texts)))
    placed: dict[int, Placed] = {}
    for text in texts:
        corners = back.transform(text.get_window_extent(figure.canvas.get_renderer()).get_points())
        own = box(*corners.min(axis=0), *corners.max(axis=0))
        k = min(
            (each for each in left if labels.texts[each] == text.get_text()),
            key=lambda each: own.distance(Point(labels.sites[each])),
        )
        left.remove(k)
        place = Point(labels.sites[k])
        edge = own.exterior.interpolate(own.exterior.project(place))
        placed[k] = Placed(own, LineString([place, edge]))
    return [placed[k] for k in sorted(placed)]


def faults(placed: Sequence[Placed], labels: LabelSet) -> dict[str, int]:
    """Count what a reader stumbles over."""
    panel = box(-0.5 * SIZE[0] - _TOUCH, -0.5 * SIZE[1] - _TOUCH, 0.5 * SIZE[0] + _TOUCH, 0.5 * SIZE[1] + _TOUCH)
    pairs = [(a, b) for k, a in enumerate(placed) for b in placed[:k]]
    inner = [each.text.buffer(-_TOUCH) for each in placed]
    return {
        "overlapping": sum(a.text.buffer(-_TOUCH).intersects(b.text.buffer(-_TOUCH)) for a, b in pairs),
        "crossing": sum(a.leader.crosses(b.leader) for a, b in pairs),
        "leader_over_text": sum(
            each.leader.intersects(text) for k, each in enumerate(placed) for j, text in enumerate(inner) if j != k
        ),
        "over_place": sum(text.contains(Point(site)) for text in inner for site in labels.sites),
        "outside": sum(not panel.contains(each.text) for each in placed),
        "missing": len(labels.texts) - len(placed),
    }


def compared(place: Callable[[LabelSet], list[Placed]], sets: Sequence[LabelSet]) -> dict[str, Any]:
    """Place all sets and add up."""
    total: dict[str, int] = {}
    seconds, lengths = [], 0.0
    for labels in sets:
        begin = perf_counter()
        placed = place(labels)
        seconds.append(perf_counter() - begin)
        lengths += sum(each.leader.length for each in placed)
        for name, count in faults(placed, labels).items():
            total[name] = total.get(name, 0) + count
    return {**total, "leaders_mm": round(lengths, 1), "seconds": round(float(np.median(seconds)), 4)}


def main() -> None:
    """Compare, and write the record."""
    sets = [label_set(seed) for seed in range(SETS)]
    rows = {
        "lappet": {"version": version("lappet"), **compared(by_lappet, sets)},
        "adjustText": {"version": version("adjustText"), **compared(by_adjust_text, sets)},
        "textalloc": {"version": version("textalloc"), **compared(by_textalloc, sets)},
    }
    machine = {"processor": platform.machine(), "python": platform.python_version()}
    record = {"machine": machine, "sets": SETS, "labels": sum(len(each.texts) for each in sets), "rows": rows}
    RESULT.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
