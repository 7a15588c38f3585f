"""What a plate's annotations become on a panel: labels, measures, arrows and marks at places of the solved tissue."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.section_plane import SectionPlane
from lappet.plates.boundary_labels import PlacedLabel
from lappet.plates.measures import Measure, beside, dimension, ticked
from lappet.plates.panel_drawing import PanelDrawing, bent
from lappet.plates.plate_scene import PlateScene
from lappet.plates.section_measures import depth_below
from lappet.plates.skin_anchors import SkinAnchors
from lappet.procedure.plate import PlateAnnotation

OFF_SKIN = 1.0  # mm: an anchor that lies farther from the skin is refused
_SEEN = 0.6  # mm: a place that is seen may lie so far behind the surface
_WIDTH = 5.0  # mm on paper between two points and the dimension of their distance
_NEAR = 2.0  # mm: what comes so near a section is drawn on it
_ARC = 4.2  # mm on paper: radius of an angle's arc
_TEXT = 2.4  # mm on paper from the arc or the arrow to its text


@dataclass(eq=False)
class DrawnAnnotations:
    """The annotations of a panel on paper.

    Parameters
    ----------
    named
        Texts to which the program finds a place, each with the places that it may lead to, shape (c, 2).
    placed
        Labels that stand where the user put them.
    measures
        Lengths and angles.
    arrows
        Ways, each of shape (k, 2).
    pivots
        Points about which flaps turn, each of shape (2,).
    notes
        What could not be drawn, and why.
    """

    named: list[tuple[str, NDArray[np.float64]]] = field(default_factory=list)
    placed: list[PlacedLabel] = field(default_factory=list)
    measures: list[Measure] = field(default_factory=list)
    arrows: list[NDArray[np.float64]] = field(default_factory=list)
    pivots: list[NDArray[np.float64]] = field(default_factory=list)
    notes: list[Problem] = field(default_factory=list)


def check_anchors(anchors: SkinAnchors, annotations: Sequence[PlateAnnotation]) -> None:
    """Refuse annotations whose anchors are not on the skin.

    Parameters
    ----------
    anchors
        The skin.
    annotations
        The annotations.

    Raises
    ------
    RefusedError
        If an anchor is too far from the skin at rest.
    """
    for note in annotations:
        places = np.array(note.anchors)
        off = np.linalg.norm(anchors.on_skin(places) - places, axis=1)
        if not np.isfinite(off).all() or off.max() > OFF_SKIN:
            worst = int(np.argmax(np.where(np.isfinite(off), off, np.inf)))
            at = ", ".join(f"{each:g}" for each in note.anchors[worst])
            raise refused(ProblemCode.PLATE_ANCHOR_OFF, note.name, at, distance=f"{off[worst]:.1f}", most=OFF_SKIN)


@dataclass(frozen=True, eq=False)
class AnnotationDrawer:
    """A panel on which annotations are drawn.

    Parameters
    ----------
    scene
        The procedure before the panel's camera.
    drawing
        The panel's drawing.
    panel
        The panel's name.
    later
        Time codes of the frames from the panel's to the next panel's, ascending; arrows run along them.
    section
        The plane in which the panel is cut, or None.
    """

    scene: PlateScene
    drawing: PanelDrawing
    panel: str
    later: tuple[float, ...]
    section: SectionPlane | None = None

    def draw(self, annotations: Sequence[PlateAnnotation]) -> DrawnAnnotations:
        """Draw the annotations that stand on the panel.

        Parameters
        ----------
        annotations
            The plate's annotations.

        Returns
        -------
        DrawnAnnotations
            What is drawn.
        """
        found = DrawnAnnotations()
        for note in annotations:
            if not note.panels or self.panel in note.panels:
                self._draw(note, found)
        return found

    def _draw(self, note: PlateAnnotation, found: DrawnAnnotations) -> None:
        anchors = SkinAnchors(self.scene.source)
        own = np.array(note.anchors)
        places = anchors.line(own) if note.kind == "length" else anchors.on_skin(own)
        last = note.when_excised == "last-place"
        there, gone = anchors.at(places, self.drawing.surface.time, last)
        if gone and (not last or not np.isfinite(there).all()):
            if note.panels:
                found.notes.append(problem(ProblemCode.PLATE_ANCHOR_GONE, note.name, self.panel))
            return
        paper, _ = self.drawing.projection.paper(there)
        ends = paper if note.kind != "length" else paper[[0, -1]]
        depths = self.drawing.projection.paper(there)[1]
        shown = (0, -1) if note.kind == "length" else range(len(paper))
        deep = note.kind == "depth" and self.section is None
        if deep or not all(self._seen(paper[k], depths[k], there[k]) for k in shown):
            if note.panels:
                found.notes.append(problem(ProblemCode.PLATE_ANCHOR_HIDDEN, note.name, self.panel))
            return
        if note.kind == "label":
            self._label(note, ends[0], found)
        elif note.kind in ("length", "distance", "width"):
            self._length(note, there, paper, found)
        elif note.kind == "depth":
            self._depth(note, paper[0], found)
        elif note.kind == "angle":
            self._angle(note, there, found)
        elif note.kind == "arrow":
            self._arrow(note, places, paper, found)
        else:
            found.pivots.append(paper[0])
            if note.text:
                self._label(note, paper[0], found)

    def _seen(self, place: NDArray[np.float64], depth: float, at: NDArray[np.float64]) -> bool:
        inside = (np.abs(place) < 0.5 * np.asarray(self.drawing.projection.size)).all()
        if self.section is not None:
            return bool(inside and abs(self.section.beyond(at)) <= _NEAR)
        return bool(inside and depth <= self.drawing.depth_at(place) + _SEEN)

    def _label(self, note: PlateAnnotation, site: NDArray[np.float64], found: DrawnAnnotations) -> None:
        if note.offset is None:
            found.named.append((note.text or note.name, site[None]))
        else:
            port = site + np.asarray(note.offset)
            found.placed.append(PlacedLabel(note.text or note.name, site, port, note.offset[0] < 0.0))

    def _length(
        self, note: PlateAnnotation, there: NDArray[np.float64], paper: NDArray[np.float64], found: DrawnAnnotations
    ) -> None:
        length = float(np.linalg.norm(np.diff(there, axis=0), axis=1).sum())
        text = note.text or f"{length:.0f} mm"
        if note.kind == "width":
            room = self._wounds(paper)
            sides = [dimension(paper, away) for away in (_WIDTH, -_WIDTH)]
            course, middle = max(sides, key=lambda side: float(np.linalg.norm(room - side[1], axis=1).min()))
            own = middle + _TEXT * _unit(middle - paper.mean(axis=0))
            at = own if note.offset is None else paper[0] + np.asarray(note.offset)
            found.measures.append(Measure(text, at, course))
            return
        if note.offset is None:
            at = beside(paper, self._wounds(paper), [each.at for each in found.measures])
        else:
            at = paper[0] + np.asarray(note.offset)
        found.measures.append(Measure(text, at, ticked(paper)))

    def _depth(self, note: PlateAnnotation, at: NDArray[np.float64], found: DrawnAnnotations) -> None:
        measure = depth_below(self.drawing, at, note.text)
        if measure is not None:
            place = measure.at if note.offset is None else at + np.asarray(note.offset)
            found.measures.append(replace(measure, at=place))

    def _angle(self, note: PlateAnnotation, there: NDArray[np.float64], found: DrawnAnnotations) -> None:
        vertex = there[1]
        first, second = (there[k] - vertex for k in (0, 2))
        first /= max(float(np.linalg.norm(first)), 1e-12)
        second /= max(float(np.linalg.norm(second)), 1e-12)
        angle = float(np.arccos(np.clip(first @ second, -1.0, 1.0)))
        across = second - (second @ first) * first
        across /= max(float(np.linalg.norm(across)), 1e-12)
        radius = _ARC / self.drawing.projection.scale
        turns = np.linspace(0.0, angle, 17)[:, None]
        arc = vertex + radius * (np.cos(turns) * first + np.sin(turns) * across)
        half = np.cos(0.5 * angle) * first + np.sin(0.5 * angle) * across
        middle = vertex + (radius + _TEXT / self.drawing.projection.scale) * half
        at, _ = self.drawing.projection.paper(middle[None])
        first_on_paper, _ = self.drawing.projection.paper(there[:1])
        place = at[0] if note.offset is None else first_on_paper[0] + np.asarray(note.offset)
        arc_on_paper, _ = self.drawing.projection.paper(arc)
        found.measures.append(Measure(note.text or f"{np.degrees(angle):.0f}°", place, arc_on_paper))

    def _arrow(
        self, note: PlateAnnotation, places: NDArray[np.float64], paper: NDArray[np.float64], found: DrawnAnnotations
    ) -> None:
        if len(places) == 2:
            way = paper[0] + np.linspace(0.0, 1.0, 24)[:, None] * (paper[1] - paper[0])
        else:
            frames = (self.drawing.surface.time, *self.later)
            along = [SkinAnchors(self.scene.source).at(places, time)[0][0] for time in frames]
            course, _ = self.drawing.projection.paper(np.array([each for each in along if np.isfinite(each).all()]))
            if len(course) < 2 or np.linalg.norm(course[-1] - course[0]) < _ARC:
                return
            way = bent(course)
        found.arrows.append(way)
        if note.text:
            at = beside(way, way, []) if note.offset is None else paper[0] + np.asarray(note.offset)
            found.measures.append(Measure(note.text, at, np.zeros((0, 2))))

    def _wounds(self, paper: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places that a measure's text should keep away from."""
        strokes = [stroke.points for stroke in self.drawing.strokes]
        return np.vstack([paper, *strokes])


def _unit(way: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = way / max(float(np.linalg.norm(way)), 1e-12)
    return unit
