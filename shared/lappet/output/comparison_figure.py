"""The figure of `lappet compare`: what is measured of operations as bars."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.output.comparison import SHOWN, Compared, shared_names, value_text

_ROW = 0.16  # inches that a bar of a region or a landmark takes
_FEWEST = 3  # rows that a panel of regions or landmarks has room for, so that its bars are not thicker than the others
_MOST = 14  # regions or landmarks that are drawn: those with the greatest values


def plot_comparison(columns: Sequence[Compared], path: Path) -> None:
    """Draw the measures as bars: nine small panels, then tension by region and what landmarks moved.

    Parameters
    ----------
    columns
        The operations.
    path
        The picture (.png, .svg or .pdf).
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.patches import Patch

    regions = _chosen(columns, [{name: pair[0] for name, pair in each.regions.items()} for each in columns])
    marks = _chosen(columns, [each.moved_mm for each in columns])
    rows = max(len(regions), len(marks))
    room = max(rows, _FEWEST)
    below = 1.1 + _ROW * room * len(columns) if rows else 0.0
    figure = pyplot.figure(figsize=(10.0, 7.5 + below), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(7.5, below)) if rows else (figure, None)
    above, under = parts
    colors = [f"C{k}" for k in range(len(columns))]
    for axis, (name, title, unit) in zip(above.subplots(3, 3).flat, SHOWN, strict=True):
        values = [getattr(each, name) for each in columns]
        _bars(axis, [each.name for each in columns], values, colors)
        axis.set_title(f"{title} ({unit})", fontsize=9)
    if under is not None:
        left, right = under.subplots(1, 2)
        _groups(left, regions, [{n: p[0] for n, p in each.regions.items()} for each in columns], colors, room)
        _ticks(left, [[each.regions.get(name, (0.0, 0.0))[1] for each in columns] for name in regions])
        left.set_title("greatest tension of each region, a tick at its mean (kPa)", fontsize=9)
        _groups(right, marks, [each.moved_mm for each in columns], colors, room)
        right.set_title("how far landmarks moved (mm)", fontsize=9)
        keys = [Patch(color=color, label=each.name) for color, each in zip(colors, columns, strict=True)]
        under.legend(handles=keys, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    drawn = io.BytesIO()
    figure.savefig(drawn, format=path.suffix[1:].lower() or "png", dpi=150)
    pyplot.close(figure)
    write_whole(path, drawn.getvalue())


def _chosen(columns: Sequence[Compared], values: Sequence[dict[str, float]]) -> list[str]:
    """The names that are drawn: shared ones, with the greatest values, in their order."""
    names = shared_names(values)
    greatest = sorted(names, key=lambda name: -max(each.get(name, 0.0) for each in values))[:_MOST]
    return [name for name in names if name in greatest]


def _bars(axis: Any, names: Sequence[str], values: Sequence[float], colors: Sequence[str]) -> None:
    shown = [value if math.isfinite(value) else 0.0 for value in values]
    axis.barh(range(len(names)), shown, color=colors)
    axis.set_yticks(range(len(names)), names)
    axis.invert_yaxis()
    axis.tick_params(labelsize=8)
    axis.margins(x=0.2)
    for k, value in enumerate(values):
        axis.text(shown[k], k, f" {value_text(value) or 'not known'}", va="center", fontsize=8)


def _groups(
    axis: Any, names: Sequence[str], values: Sequence[dict[str, float]], colors: Sequence[str], room: int
) -> None:
    """A group of bars for each name, one for each operation, from the top of a panel with room for so many groups."""
    count = len(values)
    for k, each in enumerate(values):
        places = [row + (k - 0.5 * (count - 1)) * 0.8 / count for row in range(len(names))]
        axis.barh(places, [each.get(name, 0.0) for name in names], height=0.8 / count, color=colors[k])
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(room - 0.5, -0.5)
    axis.tick_params(labelsize=8)


def _ticks(axis: Any, means: Sequence[Sequence[float]]) -> None:
    """A dark tick across each bar of a group."""
    for row, each in enumerate(means):
        for k, value in enumerate(each):
            middle = row + (k - 0.5 * (len(each) - 1)) * 0.8 / len(each)
            half = 0.4 / len(each)
            axis.plot([value, value], [middle - half, middle + half], color="0.1", linewidth=1.2)
