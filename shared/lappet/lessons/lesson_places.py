"""The places of a procedure that a lesson marks and asks for: corners of cuts, landmarks, sutures and hooks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_read import SkinCache
from lappet.drawing.suture_bites import bites_at, carried
from lappet.export.lesson_labels import followed_places, lesson_labels, place_value
from lappet.export.lesson_procedure import LessonScene
from lappet.geometry.labeled_surface import FaceOrigin

KINDS = ("corner", "landmark", "suture", "hook")
_ANCHORS = {"Suture": "lappet:anchors", "Hook": "lappet:anchor"}


@dataclass(frozen=True, eq=False)
class LessonPlace:
    """A place on the tissue.

    Parameters
    ----------
    kind
        One of `KINDS`.
    name
        Its letter, label or name.
    points
        Where it is in mm in each of the f frames: shape (f, p, 3), a suture with its p = 2 ends, any other with one
        point; NaN where it is not.
    """

    kind: str
    name: str
    points: NDArray[np.float64]

    def __str__(self) -> str:
        return f"{self.kind} {self.name}"

    def at(self, frame: int) -> NDArray[np.float64] | None:
        """Find where it is.

        Parameters
        ----------
        frame
            Index of the frame.

        Returns
        -------
        NDArray[np.float64] | None
            The middle of its points in mm, shape (3,), or None where it is not on the tissue.
        """
        points: NDArray[np.float64] = self.points[frame]
        return points.mean(axis=0) if np.isfinite(points).all() else None

    def told(self) -> list[list[list[float]] | None]:
        """Write its points for JSON.

        Returns
        -------
        list[list[list[float]] | None]
            Its points in mm for each frame, None where it is not on the tissue.
        """
        return [
            [place_value(point) or [] for point in points] if np.isfinite(points).all() else None
            for points in self.points
        ]


class LessonPlaces:
    """All places of a procedure by their names.

    Parameters
    ----------
    shown
        The procedure and its frames.
    """

    def __init__(self, shown: LessonScene) -> None:
        self._shown = shown
        self._known = {str(place): place for place in _places(shown)}

    def __iter__(self) -> Iterator[LessonPlace]:
        return iter(self._known.values())

    def find(self, name: str) -> LessonPlace | None:
        """Find a place.

        Parameters
        ----------
        name
            Its kind and its name, such as "corner a".

        Returns
        -------
        LessonPlace | None
            The place, or None where there is none of that name.
        """
        kind, _, rest = name.partition(" ")
        return self._known.get(f"{kind.lower()} {rest.strip()}")

    def at_step(self, step: int) -> list[LessonPlace]:
        """List the places that are on the tissue at a step.

        Parameters
        ----------
        step
            Number of the step, from 1 on.

        Returns
        -------
        list[LessonPlace]
            The places.
        """
        frame = self.frame(step)
        return [place for place in self if place.at(frame) is not None]

    def frame(self, step: int) -> int:
        """Find the frame of a step.

        Parameters
        ----------
        step
            Number of the step, from 1 on.

        Returns
        -------
        int
            Index of its frame; of the first where the procedure has no steps.
        """
        steps = self._shown.steps
        return self._shown.frames.index(steps[step - 1].time) if steps else 0


def _places(shown: LessonScene) -> Iterator[LessonPlace]:
    missing = [np.nan] * 3
    for label in lesson_labels(shown.scene, shown.frames):
        points = np.array([place or missing for place in label["places"]], np.float64)
        yield LessonPlace(label["kind"], label["text"], points[:, None])
    yield from _held(shown)
    yield from _stitches(shown)


def _held(shown: LessonScene) -> Iterator[LessonPlace]:
    """Sutures and hooks that have a prim of their own, followed from where they are planned on the whole skin."""
    source = shown.source
    found: list[tuple[str, str, NDArray[np.float64]]] = []
    for event in source.events:
        attribute = _ANCHORS.get(event.kind)
        prim = source.stage.GetPrimAtPath(f"/Procedure/Timeline/{event.name}")
        value = prim.GetAttribute(attribute).Get() if attribute and prim else None
        if value is not None and len(value):
            anchors = np.asarray(value, np.float64).reshape(-1, 3) * source.millimeters
            found.append((event.kind.lower(), event.name, anchors))
    if not found:
        return
    anchors = _on_skin(source, np.concatenate([each for _, _, each in found]))
    courses = followed_places(source, anchors, shown.frames)
    begin = 0
    for kind, name, each in found:
        yield LessonPlace(kind, name, courses[:, begin : begin + len(each)])
        begin += len(each)


def _on_skin(source: SkinCache, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest places on the skin before it is cut; sutures hold deep tissue, too."""
    first = source.epochs[0]
    rest = source.rest(first)
    return carried(bites_at(rest, first.triangles[first.origin == FaceOrigin.SKIN], points), rest)


def _stitches(shown: LessonScene) -> Iterator[LessonPlace]:
    """The stitches of runs, while they hold."""
    prim: Any = shown.source.stage.GetPrimAtPath("/Procedure/Skin/Sutures")
    labels = [str(each) for each in prim.GetAttribute("primvars:label").Get() or ()] if prim else []
    strands = [shown.source.sutures(time) for time in shown.frames] if any("/" in each for each in labels) else []
    for row, label in enumerate(labels if strands else ()):
        if "/" in label:
            ends = [each.ends[row] if each.active[row] else np.full((2, 3), np.nan) for each in strands]
            yield LessonPlace("suture", label, np.array(ends, np.float64))
