"""Hatching over areas undermined and thinned, as they are marked on skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, MultiLineString, Polygon, unary_union

from lappet.drawing.skin_marks import HELD
from lappet.plates.feature_lines import FeatureLine, LineKind
from lappet.plates.plate_scene import PlateScene, followed
from lappet.plates.printed_marks import whole_parts

_STEP = 0.8  # mm along a line
_LIFT = 0.5  # mm
_INSIDE = 0.6  # mm from the cut around a flap: beside its sutures
_TRIES = 8  # at the height of a place of the skin
# Of the lines, as the picture is seen.
_WAY = np.array([np.cos(np.radians(60.0)), np.sin(np.radians(60.0))])
_OTHER_WAY = np.array([-_WAY[0], _WAY[1]])


def is_marked(scene: PlateScene, time: float) -> bool:
    """Tell whether a frame shows the area undermined: from undermining until hooks or sutures hold the tissue.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the frame.

    Returns
    -------
    bool
        Whether it does.
    """
    events = scene.source.events
    begun = min((each.start for each in events if each.kind == "Undermine"), default=np.inf)
    held = min((each.start for each in events if each.kind in HELD), default=np.inf)
    return begun <= time < held


def undermined_hatch(scene: PlateScene, time: float, spacing: float) -> list[FeatureLine]:
    """Hatch the area undermined.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the frame.
    spacing
        Distance of the lines at rest in mm.

    Returns
    -------
    list[FeatureLine]
        The lines, where their tissue is there; none at frames that do not show the area.
    """
    outlines = scene.source.undermined_areas(_STEP) if is_marked(scene, time) else []
    return _hatched(scene, outlines, time, spacing, LineKind.UNDERMINED_HATCH, _WAY)


def thinned_marks(scene: PlateScene, time: float, spacing: float) -> list[FeatureLine]:
    """Hatch and outline the areas that are thinned, while the skin is laid back there.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the frame.
    spacing
        Distance of the lines at rest in mm.

    Returns
    -------
    list[FeatureLine]
        The lines, which run across those of `undermined_hatch`; none at frames at which nothing is thinned.
    """
    now = {each.name for each in scene.source.events if each.kind == "Thin" and each.start <= time < each.end}
    outlines = [line for name, line in scene.source.thinned_areas(_STEP).items() if name in now] if now else []
    lines = _hatched(scene, outlines, time, spacing, LineKind.THINNED_HATCH, _OTHER_WAY)
    for outline in outlines:
        inside = outline + _INSIDE * _inwards(outline)
        for part in whole_parts(scene.on_skin(inside, time), 4.0 * _STEP):
            lines.append(FeatureLine(LineKind.THINNED, part.points, _LIFT))
    return lines


def _inwards(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors from the points of an outline (k, 3) to its middle."""
    way = outline[:-1].mean(axis=0) - outline
    unit: NDArray[np.float64] = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-300)
    return unit


def _hatched(
    scene: PlateScene,
    outlines: list[NDArray[np.float64]],
    time: float,
    spacing: float,
    kind: LineKind,
    way: NDArray[np.float64],
) -> list[FeatureLine]:
    """Lines in a direction over the areas inside outlines, where their tissue is there."""
    flat = [Polygon(outline @ scene.axes[:2].T).buffer(0.0) for outline in outlines if len(outline) > 3]
    if not flat:
        return []
    area = unary_union(flat)
    across = np.array([-way[1], way[0]])
    corners = np.array(area.envelope.exterior.coords)
    low, high = (corners @ across).min(), (corners @ across).max()
    near, far = (corners @ way).min(), (corners @ way).max()
    levels = np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1.0) * spacing
    rows = MultiLineString([LineString([level * across + end * way for end in (near, far)]) for level in levels])
    inside = rows.intersection(area)
    height = float(np.mean(np.concatenate(outlines) @ scene.axes[2]))
    found = []
    for row in getattr(inside, "geoms", [inside]):
        if row.geom_type != "LineString" or row.length < _STEP:
            continue
        course = np.array(row.segmentize(_STEP).coords)
        parts = whole_parts(_followed(scene, course, height, time), 4.0 * _STEP)
        found += [FeatureLine(kind, each.points, _LIFT) for each in parts]
    return found


def _followed(scene: PlateScene, course: NDArray[np.float64], height: float, time: float) -> NDArray[np.float64]:
    """Where the skin lies that is at rest over places (k, 2) of the plane along it, mm, (k, 3); NaN where none is."""
    foot = course @ scene.axes[:2]
    places = foot + height * scene.axes[2]
    for _ in range(_TRIES):
        places = scene.whole_skin.query(foot + (places @ scene.axes[2])[:, None] * scene.axes[2])[1]
    over = np.linalg.norm(places @ scene.axes[:2].T - course, axis=1) < _STEP
    result = np.full((len(course), 3), np.nan)
    if over.any():
        result[over] = followed(scene.source, places[over], time)
    return result
