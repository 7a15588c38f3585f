"""The plan of a design as a drawing in its plane: what is excised, where cuts run, which corner goes where."""

from __future__ import annotations

import string
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.designs.library_design import LibraryDesign
from lappet.procedure import Point

_ARC_STEP = 5.0  # degrees
_SAME = 0.5  # mm between corners that lie on either side of a cut


@dataclass(frozen=True)
class Letter:
    """A letter for a corner of the cut skin.

    Parameters
    ----------
    text
        The letter.
    at
        The corner in mm, shape (2,).
    """

    text: str
    at: NDArray[np.float64]


@dataclass(frozen=True)
class FlapPlan:
    """A design at some measures, drawn on a flat skin. Coordinates are mm, x along its direction, y to the left of it.

    Parameters
    ----------
    outlines
        What is excised, closed, each of shape (n, 2).
    incisions
        The cuts, each of shape (n, 2); those of a second stage are not drawn.
    letters
        The corners, one letter for a place.
    meetings
        The pairs of letters that meet in the end: first the flap's, then the wound's.
    ways
        How the flaps' corners go, from where they are to where they are laid, each of shape (n, 2).
    """

    outlines: tuple[NDArray[np.float64], ...]
    incisions: tuple[NDArray[np.float64], ...]
    letters: tuple[Letter, ...]
    meetings: tuple[tuple[str, str], ...]
    ways: tuple[NDArray[np.float64], ...]

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner of what is drawn, in mm, each of shape (2,)."""
        drawn = np.vstack([*self.outlines, *self.incisions, *self.ways])
        return drawn.min(axis=0), drawn.max(axis=0)


def flap_plan(
    design: LibraryDesign, measures: Mapping[str, float] | None = None, *, mirrored: bool = False
) -> FlapPlan:
    """Draw the plan of a design.

    Parameters
    ----------
    design
        The design.
    measures
        Its measures by name, those that are not the default.
    mirrored
        Whether it is mirrored about its direction.

    Returns
    -------
    FlapPlan
        The plan.

    Raises
    ------
    RefusedError
        If a measure is unknown or out of its range, or they contradict each other.
    """
    drawn = design.draw((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), **design.values(measures or {}), mirrored=mirrored)
    letters, meetings = _letters([(each.flap.point, each.wound.point) for each in drawn.corners])
    return FlapPlan(
        tuple(_flat(each.outline) for each in drawn.excised),
        tuple(_flat(each) for each in (*drawn.incisions, drawn.opening) if each),
        letters,
        meetings,
        tuple(_way(each.corner.point, each.pivot, each.lay.point, each.turn) for each in drawn.carries),
    )


def _flat(points: tuple[Point, ...]) -> NDArray[np.float64]:
    return np.array(points, np.float64)[:, :2]


def _letters(pairs: list[tuple[Point, Point]]) -> tuple[tuple[Letter, ...], tuple[tuple[str, str], ...]]:
    """A letter for each place, and the letters that meet."""
    letters: list[Letter] = []

    def letter_at(point: Point) -> str:
        at = np.array(point[:2])
        for known in letters:
            if np.linalg.norm(known.at - at) < _SAME:
                return known.text
        letters.append(Letter(string.ascii_uppercase[len(letters)], at))
        return letters[-1].text

    meetings = tuple((letter_at(flap), letter_at(wound)) for flap, wound in pairs)
    return tuple(letters), meetings


def _way(start: Point, pivot: Point | None, end: Point, by: float | None) -> NDArray[np.float64]:
    """From start to end: about the pivot by the smaller angle or the one near that in degrees, or straight."""
    first, last = np.array(start[:2]), np.array(end[:2])
    if pivot is None:
        return np.stack([first, last])
    center = np.array(pivot[:2])
    radii = [float(np.linalg.norm(each - center)) for each in (first, last)]
    angles = [float(np.arctan2(*(each - center)[::-1])) for each in (first, last)]
    middle = 0.0 if by is None else np.radians(by)
    turn = (angles[1] - angles[0] - middle + np.pi) % (2.0 * np.pi) - np.pi + middle
    share = np.linspace(0.0, 1.0, 2 + int(abs(np.degrees(turn)) / _ARC_STEP))
    angle, radius = angles[0] + share * turn, radii[0] + share * (radii[1] - radii[0])
    return center + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
