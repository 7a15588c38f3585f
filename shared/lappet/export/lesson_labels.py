"""The labels of a lesson: letters at the corners of cuts and the procedure's landmarks, which ride on the skin."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_read import SkinCache
from lappet.drawing.suture_bites import Bite, bites_at, carried
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.plate_scene import PlateScene

_BESIDE = 2.5  # mm from a corner: where its tissue carries the letter
_GONE = 1.0  # mm: a place at rest that is farther from all skin has been excised


def lesson_labels(scene: PlateScene, frames: Sequence[float]) -> list[dict[str, Any]]:
    """Follow labels through the frames.

    Parameters
    ----------
    scene
        The procedure.
    frames
        Time codes of the frames.

    Returns
    -------
    list[dict[str, Any]]
        For each label its `kind` ("corner" or "landmark"), its `text`, and `places`: in mm for each frame, None where
        its tissue is gone.
    """
    kept = zip(scene.corners, scene.kept, strict=True)
    anchors = np.array([corner.inset(_BESIDE, sector) for corner, sector in kept]).reshape(-1, 3)
    courses = followed_places(scene.source, anchors, frames)
    found = [
        {"kind": "corner", "text": corner.letter, "places": [place_value(place) for place in courses[:, k]]}
        for k, corner in enumerate(scene.corners)
    ]
    named = [scene.source.named_landmarks(time) for time in frames]
    for label in dict.fromkeys(label for places in named for label in places):
        places = [place_value(each[label]) if label in each else None for each in named]
        found.append({"kind": "landmark", "text": label, "places": places})
    return found


def place_value(place: NDArray[np.float64]) -> list[float] | None:
    """Round a place for JSON.

    Parameters
    ----------
    place
        A place in mm, shape (3,).

    Returns
    -------
    list[float] | None
        The place in mm, to a thousandth; None where it is NaN.
    """
    return [round(float(each), 3) for each in place] if np.isfinite(place).all() else None


def followed_places(source: SkinCache, anchors: NDArray[np.float64], frames: Sequence[float]) -> NDArray[np.float64]:
    """Follow places of the skin at rest through the frames.

    Parameters
    ----------
    source
        The solved procedure.
    anchors
        Places on the skin at rest in mm, shape (k, 3).
    frames
        Time codes of the f frames.

    Returns
    -------
    NDArray[np.float64]
        Where they lie in mm, shape (f, k, 3); NaN where the tissue is gone.
    """
    courses = np.full((len(frames), len(anchors), 3), np.nan)
    known: dict[str, tuple[list[Bite], NDArray[np.bool_]]] = {}
    for index, time in enumerate(frames if len(anchors) else ()):
        epoch = source.epoch_at(time)
        if epoch.name not in known:
            rest = source.rest(epoch)
            bites = bites_at(rest, epoch.triangles[epoch.origin == FaceOrigin.SKIN], anchors)
            known[epoch.name] = bites, np.linalg.norm(carried(bites, rest) - anchors, axis=1) > _GONE
        bites, gone = known[epoch.name]
        courses[index] = carried(bites, source.positions(epoch, time))
        courses[index, gone] = np.nan
    return courses
