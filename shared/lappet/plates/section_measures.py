"""Depths in a cross-section, which is drawn without perspective: from the skin down to the underside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, MultiLineString, Point
from shapely.ops import nearest_points

from lappet.plates.feature_lines import LineKind
from lappet.plates.measures import Measure, ticked
from lappet.plates.panel_drawing import PanelDrawing

_LEAST = 4.0  # mm on paper: shorter levels of dissection have no depth written beside them
_SHARES = (0.5, 0.25, 0.75)
_BESIDE = 3.4  # mm on paper from the line to its text
_CLEAR = 2.0  # mm on paper from threads and ends
_BELOW = (LineKind.DISSECTION, LineKind.CONTOUR)


def depth_below(drawing: PanelDrawing, at: NDArray[np.float64], text: str = "") -> Measure | None:
    """Measure how far the underside lies below a place of the skin.

    Parameters
    ----------
    drawing
        A section.
    at
        The place in mm on paper, shape (2,).
    text
        What is written; "": the depth in whole millimeters.

    Returns
    -------
    Measure or None
        The shortest way to the underside; None where the section has none.
    """
    return _across(drawing, at, _BELOW, text)


def dissection_depth(drawing: PanelDrawing) -> list[Measure]:
    """Measure how deep the level of dissection lies.

    Parameters
    ----------
    drawing
        A section.

    Returns
    -------
    list[Measure]
        The shortest way to the skin from a place of the longest level, clear of threads; none where nothing is freed.
    """
    levels = [LineString(each.points) for each in drawing.strokes if each.kind is LineKind.DISSECTION]
    level = max(levels, key=lambda line: line.length, default=None)
    if level is None or level.length < _LEAST:
        return []
    threads = [LineString(each.points) for each in drawing.strokes if each.kind is LineKind.THREAD]
    places = [level.interpolate(share, normalized=True) for share in _SHARES]
    clear = [each for each in places if all(each.distance(thread) > _CLEAR for thread in threads)]
    place = (clear or places)[0]
    found = _across(drawing, np.array(place.coords[0]), (LineKind.WOUND_EDGE,), "")
    return [] if found is None else [found]


def _across(drawing: PanelDrawing, at: NDArray[np.float64], kinds: tuple[LineKind, ...], text: str) -> Measure | None:
    """The shortest way from a place to lines of some kinds."""
    lines = [each.points for each in drawing.strokes if each.kind in kinds and len(each.points) > 1]
    if not lines:
        return None
    _, found = nearest_points(Point(at), MultiLineString(lines))
    end = np.array(found.coords[0])
    way = np.stack([at, end])
    length = float(np.linalg.norm(end - at))
    if length < 1e-6:
        return None
    side = np.array([end[1] - at[1], at[0] - end[0]]) / length
    side = side if side[0] > 0.0 else -side
    said = text or f"{length / drawing.projection.scale:.0f} mm"
    return Measure(said, way.mean(axis=0) + _BESIDE * side, ticked(way))
