"""The plan of a flap as a line drawing, to scale, with letters that stay text in SVG and PDF."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.durable import write_whole
from lappet.designs.flap_plan import FlapPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_INCH = 25.4  # mm
_MARGIN = 0.16  # of the larger extent
_WIDTH = 70.0  # mm on paper
_LEAST_HEIGHT = 35.0  # mm on paper
_CUT = "#a5231c"
_EXCISED = "#e8c9bd"
_WAY = "#35618f"
_LINES = "#c9c4bc"
_LETTER = 9.0  # points
_BESIDE = 0.5  # of the margin between a corner and its letter
_BARS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)  # mm


def write_plan_figure(plan: FlapPlan, lines: str, path: Path) -> None:
    """Draw a plan: excised skin filled, cuts red, ways of the flaps as blue arrows, skin lines grey, a scale bar.

    The same plan gives the same bytes.

    Parameters
    ----------
    plan
        The plan.
    lines
        How its direction lies to the lines of the skin, "along" or "across"; "" draws none.
    path
        The picture (.svg, .pdf or .png), as wide as a column of print: 70 mm, or less where the plan is tall.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    low, high = plan.bounds
    margin = _MARGIN * float((high - low).max())
    low, high = low - margin, high + margin
    width, height = high - low
    scale = _WIDTH / max(width, height)
    if height * scale < _LEAST_HEIGHT:
        more = 0.5 * (_LEAST_HEIGHT / scale - height)
        low, high = low - np.array([0.0, more]), high + np.array([0.0, more])
    size = (high - low) * scale / _INCH
    text: dict[Any, Any] = {
        "svg.fonttype": "none",
        "svg.hashsalt": "lappet",
        "pdf.fonttype": 42,
        "font.family": "DejaVu Sans",
    }
    with matplotlib.rc_context(text):
        figure = pyplot.figure(figsize=tuple(size))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.axis("off")
        _draw_lines(axes, lines, low, high)
        _draw_plan(axes, plan, margin)
        _draw_bar(axes, low, high, margin)
        drawn = io.BytesIO()
        figure.savefig(drawn, format=path.suffix[1:].lower(), dpi=300, metadata=_undated(path))
        pyplot.close(figure)
    write_whole(path, drawn.getvalue())


def _undated(path: Path) -> dict[str, None]:
    return {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(path.suffix.lstrip(".").lower(), {})


def _draw_lines(axes: Axes, lines: str, low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
    if not lines:
        return
    axis = 1 if lines == "along" else 0
    step = float((high - low).max()) / 14.0
    for at in np.arange(low[axis] + 0.5 * step, high[axis], step):
        (axes.axhline if axis else axes.axvline)(at, color=_LINES, linewidth=0.5, zorder=0)


def _draw_plan(axes: Axes, plan: FlapPlan, margin: float) -> None:
    for outline in plan.outlines:
        axes.fill(*outline.T, facecolor=_EXCISED, edgecolor=_CUT, linewidth=1.2, joinstyle="round", zorder=2)
    for line in plan.incisions:
        axes.plot(*line.T, color=_CUT, linewidth=1.2, solid_capstyle="round", solid_joinstyle="round", zorder=3)
    for way in plan.ways:
        axes.plot(*way[:-1].T, color=_WAY, linewidth=0.8, linestyle=(0, (4, 2)), zorder=4)
        arrow = {"arrowstyle": "-|>", "color": _WAY, "linewidth": 0.8, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate("", way[-1], way[-2], arrowprops=arrow, zorder=4)
    obstacles = np.vstack([_dense(each) for each in (*plan.outlines, *plan.incisions, *plan.ways)])
    for letter in plan.letters:
        at = _beside(letter.at, _BESIDE * margin, obstacles)
        obstacles = np.vstack([obstacles, at])
        axes.text(at[0], at[1], letter.text, fontsize=_LETTER, ha="center", va="center", zorder=5)


def _dense(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """A line (n, 2) with a point at least every half millimeter or so."""
    count = 2 * np.ceil(np.linalg.norm(np.diff(line, axis=0), axis=1)).astype(int) + 1
    shares = [np.linspace(0.0, 1.0, each, endpoint=False)[:, None] for each in count]
    pieces = [a + share * (b - a) for a, b, share in zip(line[:-1], line[1:], shares, strict=True)]
    return np.vstack([*pieces, line[-1:]])


def _beside(corner: NDArray[np.float64], distance: float, obstacles: NDArray[np.float64]) -> NDArray[np.float64]:
    """The place at a distance from a corner that is farthest from all that is drawn."""
    angles = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    places = corner + distance * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    clear = np.linalg.norm(places[:, None] - obstacles, axis=2).min(axis=1)
    return places[int(np.argmax(clear))]


def _draw_bar(axes: Axes, low: NDArray[np.float64], high: NDArray[np.float64], margin: float) -> None:
    length = max(each for each in _BARS if each <= max(_BARS[0], 0.3 * float(high[0] - low[0])))
    x, y = high[0] - 0.3 * margin, low[1] + 0.3 * margin
    axes.plot([x - length, x], [y, y], color="black", linewidth=1.2, solid_capstyle="butt")
    axes.text(x - 0.5 * length, y + 0.15 * margin, f"{length:g} mm", fontsize=7.0, ha="center", va="bottom")
