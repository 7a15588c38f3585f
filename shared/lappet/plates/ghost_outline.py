"""The outlines of another state, drawn through the one that is shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from shapely import LineString, Polygon, unary_union

from lappet.plates.drawn_surface import drawn_surface
from lappet.plates.feature_lines import LineKind, surface_lines
from lappet.plates.filled_areas import WALL_AREAS, Area, AreaKind, filled_areas, seen_pixels
from lappet.plates.panel_drawing import clipped
from lappet.plates.plate_request import PlateRow
from lappet.plates.plate_scene import PlateScene
from lappet.plates.plate_steps import PlateStep
from lappet.plates.screen_triangles import ScreenTriangles
from lappet.plates.strokes import Stroke, visible_strokes

_CELL = 0.5  # mm on paper
_JOIN = 0.2  # mm on paper: ends of planned cuts that come so near close an area
# Lines of operations that are drawn over a panel, in their order.
VARIANTS = (LineKind.VARIANT, LineKind.VARIANT_2, LineKind.VARIANT_3)
_OPEN = (AreaKind.BED, AreaKind.FLAP_UNDERSIDE, *WALL_AREAS.values())


def ghost_outline(scene: PlateScene, time: float, size: tuple[float, float]) -> list[Stroke]:
    """Draw the wound edges and the planned cuts of a state.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the state.
    size
        Width and height of the panel in mm.

    Returns
    -------
    list[Stroke]
        What the state itself does not hide of them, as lines of the kind `LineKind.GHOST`.
    """
    projection = scene.projection(size)
    surface = drawn_surface(scene.source, scene.bed, scene.scenery, time)
    paper, depth = projection.paper(surface.points)
    screen = ScreenTriangles(paper, depth, surface.triangles, _CELL, frame=size)
    edges = [line for line in surface_lines(surface, scene.view.position) if line.kind is LineKind.WOUND_EDGE]
    plans = [line for line in scene.strands(time) if line.kind is LineKind.PLAN]
    strokes = visible_strokes(edges, projection, screen) + visible_strokes(plans, projection, screen, smooth=False)
    return [replace(stroke, kind=LineKind.GHOST) for stroke in strokes]


def ghost_areas(scene: PlateScene, time: float, size: tuple[float, float]) -> tuple[Area, ...]:
    """Find what the cuts of a state lay open, or what its plan encloses where nothing is cut.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the state.
    size
        Width and height of the panel in mm.

    Returns
    -------
    tuple[Area, ...]
        The areas.
    """
    projection = scene.projection(size)
    surface = drawn_surface(scene.source, scene.bed, scene.scenery, time)
    paper, depth = projection.paper(surface.points)
    screen = ScreenTriangles(paper, depth, surface.triangles, _CELL, frame=size)
    areas = filled_areas(seen_pixels(surface, projection, screen, scene.source.layers))
    opened = tuple(area for area in areas if area.kind in _OPEN)
    if opened:
        return opened
    plans = [line for line in scene.strands(time) if line.kind is LineKind.PLAN]
    courses = [LineString(projection.paper(line.points)[0]).buffer(_JOIN) for line in plans]
    whole = unary_union(courses) if courses else Polygon()
    holes = [hole for part in getattr(whole, "geoms", [whole]) for hole in part.interiors]
    return tuple(Area(AreaKind.SKIN, (np.array(hole.coords),)) for hole in holes)


def variant_outlines(
    scene: PlateScene,
    variants: Sequence[PlateScene],
    rows: Sequence[PlateRow],
    step: PlateStep,
    size: tuple[float, float],
) -> list[Stroke]:
    """Draw the outlines of other operations on the same tissue over a panel.

    Parameters
    ----------
    scene
        The panel's procedure before its camera.
    variants, rows
        The other operations and their steps.
    step
        What the panel shows; the others show the same step, or their last where they do not have it.
    size
        Width and height of the panel in mm.

    Returns
    -------
    list[Stroke]
        Their wound edges and planned cuts, those of each operation as lines of a kind of their own.
    """
    found = []
    for other, row, kind in zip(variants, rows, VARIANTS, strict=False):
        time = next((each.time for each in row.steps if each.kind is step.kind), row.steps[-1].time)
        seen = replace(other, view=scene.view, axes=scene.axes, zoom=scene.zoom)
        found += [replace(stroke, kind=kind) for stroke in clipped(ghost_outline(seen, time, size), size)]
    return found
