"""All that one panel shows, in mm on paper from its middle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from shapely import LineString, box

from lappet.plates.drawn_surface import DrawnSurface, drawn_surface
from lappet.plates.feature_lines import FeatureLine, LineKind, surface_lines
from lappet.plates.filled_areas import Area, AreaKind, SeenPixels, filled_areas, seen_pixels
from lappet.plates.hatching import hatching
from lappet.plates.letter_places import Letter, LetterPlaces, place_letters
from lappet.plates.plate_scene import PlateScene
from lappet.plates.plate_style import PlateStyle
from lappet.plates.printed_marks import NO_PRINT, SkinPrint
from lappet.plates.projection import Projection
from lappet.plates.screen_triangles import ScreenTriangles
from lappet.plates.strokes import Stroke, visible_strokes

_CELL = 0.5  # mm on paper
_HATCH = 0.9  # mm on paper between two lines of hatching
_TIP_INSET = 1.6  # mm on paper from a corner: there the way of a tip begins
_LEAST_MOVE = 0.12  # of the panel's height: shorter ways have no arrow
_MOST_ARROWS = 4
_TIP = np.radians(120.0)  # corners of less are tips of flaps
_LEAST_AREA = 6.0  # mm² on paper of an area that is named
_SHARES = np.linspace(0.1, 0.9, 7)  # of a stroke, at which a leader may end
_MOST_STROKES = 8  # of a kind that leaders may run to
_LEAST_LENGTH = 4.0  # mm on paper of strokes that are named
# Kinds of areas and of strokes that have labels, in the catalogue's words.
_DEEP_LABELS = {
    AreaKind.WALL_FASCIA: "wall.fascia",
    AreaKind.WALL_MUSCLE: "wall.muscle",
    AreaKind.WALL_CARTILAGE: "wall.cartilage",
    AreaKind.WALL_DEEP: "label.wall-deep",
}
AREA_LABELS = {
    AreaKind.BED: "label.bed",
    AreaKind.FLAP_UNDERSIDE: "label.underside",
    AreaKind.WALL_FAT: "label.wall-fat",
    AreaKind.WALL_SKIN: "label.wall-skin",
    **_DEEP_LABELS,
}
STROKE_LABELS = {
    LineKind.PLAN: "label.plan",
    LineKind.UNDERMINED: "label.undermined",
    LineKind.THINNED: "label.thinned",
    LineKind.DISSECTION: "label.dissection",
    LineKind.INSTRUMENT: "label.instrument",
    LineKind.THREAD: "label.thread",
    LineKind.VESSEL: "label.vessel",
    LineKind.SECTION: "label.section",
}
# In a cross-section.
SECTION_LABELS = {
    AreaKind.WALL_SKIN: "section.skin",
    AreaKind.WALL_FAT: "label.wall-fat",
    **_DEEP_LABELS,
    AreaKind.BONE: "section.bone",
}


@dataclass(frozen=True, eq=False)
class PanelDrawing:
    """What a panel shows.

    Parameters
    ----------
    projection
        How the tissue came onto the paper.
    surface
        The tissue.
    pixels
        What is seen where.
    areas
        Areas, those below first.
    strokes
        Lines, those below first.
    letters
        Letters of corners.
    arrows
        Ways of the tips of flaps to the next panels, and of hooks' pull, each of shape (k, 2).
    ghosts
        Areas of another state that are drawn through, translucent.
    """

    projection: Projection
    surface: DrawnSurface
    pixels: SeenPixels
    areas: tuple[Area, ...]
    strokes: tuple[Stroke, ...]
    letters: tuple[Letter, ...]
    arrows: tuple[NDArray[np.float64], ...]
    ghosts: tuple[Area, ...] = ()

    def depth_at(self, place: NDArray[np.float64]) -> float:
        """Look up the depth of what is seen at a place.

        Parameters
        ----------
        place
            A place in mm on paper, shape (2,).

        Returns
        -------
        float
            The depth of the nearest pixel in mm; infinite where there is nothing.
        """
        column = int(np.argmin(np.abs(self.pixels.x - place[0])))
        row = int(np.argmin(np.abs(self.pixels.y - place[1])))
        return float(self.pixels.depth[row, column])


def panel_drawing(
    scene: PlateScene,
    time: float,
    size: tuple[float, float],
    style: PlateStyle,
    later: Sequence[float] = (),
    letters: LetterPlaces | None = None,
    instruments: bool = True,
    mapped: str | None = None,
    more: Sequence[FeatureLine] = (),
    skin_print: SkinPrint = NO_PRINT,
    pulls: Sequence[NDArray[np.float64]] = (),
) -> PanelDrawing:
    """Draw a panel.

    Parameters
    ----------
    scene
        The procedure before a camera.
    time
        Time code of the frame.
    size
        Width and height of the panel in mm.
    style
        How the plate looks.
    later
        Time codes along which arrows show where the tips of flaps go from here, ascending; none: no arrows.
    letters
        How letters stood on the panel before; None: corners have no letters.
    instruments
        Whether hooks are drawn.
    mapped
        A quantity of the skin that is mapped, one of `lappet.drawing.skin_source.SCALARS`, or None.
    more
        Lines that are drawn besides.
    skin_print
        What is printed on the skin.
    pulls
        Arrows for the pull of hooks in mm on paper, each of shape (k, 2).

    Returns
    -------
    PanelDrawing
        The drawing.
    """
    projection = scene.projection(size)
    surface = drawn_surface(scene.source, scene.bed, scene.scenery, time)
    paper, depth = projection.paper(surface.points)
    screen = ScreenTriangles(paper, depth, surface.triangles, _CELL, frame=size)
    quantity = scene.source.scalar(surface.epoch, mapped, time) if mapped else None
    pixels = seen_pixels(surface, projection, screen, scene.source.layers, quantity)
    lines: list[FeatureLine] = []
    if style.hatched:
        lines = hatching(surface, scene.light, scene.axes[0], _HATCH / projection.scale, _seen(surface, pixels))
    rough = [*lines, *surface_lines(surface, scene.view.position)]
    strokes = visible_strokes(rough, projection, screen)
    strands = [*skin_print.on(scene.source, surface), *more, *scene.strands(time)]
    strands = [each for each in strands if instruments or each.kind is not LineKind.INSTRUMENT]
    strokes += visible_strokes(strands, projection, screen, smooth=False)
    inside, arrows = clipped(strokes, size), [*_arrows(scene, time, later, projection), *pulls]
    return PanelDrawing(
        projection,
        surface,
        pixels,
        tuple(filled_areas(pixels)),
        tuple(inside),
        tuple(place_letters(scene, time, projection, screen, inside, arrows, letters)) if letters is not None else (),
        tuple(arrows),
    )


def _seen(surface: DrawnSurface, pixels: SeenPixels) -> NDArray[np.bool_]:
    """The triangles that pixels show, and those beside them, of which slivers may be seen between pixels, (m,)."""
    corner = np.zeros(len(surface.points), bool)
    corner[surface.triangles[np.unique(pixels.triangle[pixels.triangle >= 0])]] = True
    beside: NDArray[np.bool_] = corner[surface.triangles].any(axis=1)
    return beside


def label_sites(drawing: PanelDrawing, areas: Mapping[AreaKind, str] = AREA_LABELS) -> dict[str, NDArray[np.float64]]:
    """Find places to which labels of what is seen can lead.

    Parameters
    ----------
    drawing
        The panel.
    areas
        The catalogue's words for kinds of areas.

    Returns
    -------
    dict[str, NDArray[np.float64]]
        By the label's key in the catalogue, places in mm, shape (c, 2): deep inside the area, or along the strokes.
    """
    sites: dict[str, NDArray[np.float64]] = {}
    for kind, key in STROKE_LABELS.items():
        own = [stroke.points for stroke in drawing.strokes if stroke.kind is kind]
        lengths = [LineString(points).length for points in own]
        if own and sum(lengths) >= _LEAST_LENGTH:
            sites[key] = along(own)
    for area, key in areas.items():
        place = _inside(drawing, area)
        if place is not None:
            sites[key] = place[None]
    return sites


def along(courses: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Choose places on strokes to which a leader may run.

    Parameters
    ----------
    courses
        The strokes in mm, each of shape (k, 2).

    Returns
    -------
    NDArray[np.float64]
        Places on the longest of them, shape (n, 2).
    """
    lines = [LineString(points) for points in courses]
    longest = sorted(lines, key=lambda line: -line.length)[:_MOST_STROKES]
    return np.array([line.interpolate(share, normalized=True).coords[0] for line in longest for share in _SHARES])


def _inside(drawing: PanelDrawing, kind: AreaKind) -> NDArray[np.float64] | None:
    """The place of an area that is farthest from its border."""
    pixels = drawing.pixels
    mask = pixels.kind == tuple(AreaKind).index(kind)
    step = float(pixels.x[1] - pixels.x[0])
    if mask.sum() * step**2 < _LEAST_AREA:
        return None
    deepest = np.unravel_index(int(np.argmax(distance_transform_edt(mask))), mask.shape)
    return np.array([pixels.x[deepest[1]], pixels.y[deepest[0]]])


def clipped(strokes: Sequence[Stroke], size: tuple[float, float]) -> list[Stroke]:
    """Cut strokes off at the border of a panel.

    Parameters
    ----------
    strokes
        The strokes.
    size
        Width and height of the panel in mm.

    Returns
    -------
    list[Stroke]
        What lies inside.
    """
    frame = box(-0.5 * size[0], -0.5 * size[1], 0.5 * size[0], 0.5 * size[1])
    inside = []
    for stroke in strokes:
        line = LineString(stroke.points)
        if frame.contains(line):
            inside.append(stroke)
            continue
        parts = line.intersection(frame)
        for part in getattr(parts, "geoms", [parts]):
            if part.geom_type == "LineString" and part.length > 0.0:
                inside.append(Stroke(stroke.kind, np.array(part.coords)))
    return inside


def _arrows(
    scene: PlateScene, time: float, later: Sequence[float], projection: Projection
) -> list[NDArray[np.float64]]:
    """The ways of the tips of flaps, the longest first."""
    tips = [
        (corner, kept)
        for corner, kept in zip(scene.corners, scene.kept, strict=True)
        if corner.sectors[kept].angle < _TIP
    ]
    if not tips or not later:
        return []
    inset = _TIP_INSET / projection.scale
    places = np.array([corner.inset(inset, kept) for corner, kept in tips])
    ways = np.stack([projection.paper(scene.on_skin(places, each))[0] for each in (time, *later)])
    found = []
    for k in range(len(tips)):
        way = ways[:, k]
        moved = float(np.linalg.norm(way[-1] - way[0]))
        if np.isfinite(way).all() and moved > _LEAST_MOVE * projection.size[1]:
            found.append((moved, bent(way)))
    found.sort(key=lambda each: -each[0])
    return [way for _, way in found[:_MOST_ARROWS]]


def bent(way: NDArray[np.float64], count: int = 24) -> NDArray[np.float64]:
    """Smooth a way into an arc from its begin to its end that bulges to the side on which the way runs.

    Parameters
    ----------
    way
        The way in mm on paper, shape (k, 2).
    count
        How many points the arc has.

    Returns
    -------
    NDArray[np.float64]
        The arc, shape (count, 2).
    """
    begin, end = way[0], way[-1]
    chord = end - begin
    side = np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)
    bulge = 2.0 * float(((way - begin) @ side).mean())
    length = float(np.linalg.norm(chord))
    bulge = float(np.sign(bulge) or 1.0) * float(np.clip(abs(bulge), 0.12 * length, 0.35 * length))
    control = 0.5 * (begin + end) + bulge * side
    share = np.linspace(0.0, 1.0, count)[:, None]
    bent: NDArray[np.float64] = (1 - share) ** 2 * begin + 2 * share * (1 - share) * control + share**2 * end
    return bent
