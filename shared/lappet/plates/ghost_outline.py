"""The outlines of another state, drawn through the one that is shown."""

from __future__ import annotations

from dataclasses import replace

from lappet.plates.drawn_surface import drawn_surface
from lappet.plates.feature_lines import LineKind, surface_lines
from lappet.plates.plate_scene import PlateScene
from lappet.plates.screen_triangles import ScreenTriangles
from lappet.plates.strokes import Stroke, visible_strokes

_CELL = 0.5  # mm on paper


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
