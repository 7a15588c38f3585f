"""Lengths and angles of the planned cuts, as they are written beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.plates.letter_anchors import Corner, legs
from lappet.plates.projection import Projection

_BESIDE = 2.6  # mm on paper between a line and its measure
_ARC = 4.2  # mm on paper: radius of an angle's arc
_WIDE = 5.0  # mm on paper: so wide is an angle where its text fits into it
_WIDEST_ARC = 14.0  # mm on paper: a text so far from its corner is hardly read as its angle
_LEG = 0.8  # of the shorter straight leg of a corner: farther out no arc is drawn
_BEND = np.radians(8.0)  # a leg that turns by more is not straight from there on
_MOST = 3  # lengths, and as many angles
_STRAIGHT_ANGLE = np.radians(150.0)  # what is wider is hardly seen as an angle
_LEAST = 3.0  # mm: shorter legs are not measured
_ROOM = (7.0, 3.0)  # mm on paper: two texts nearer than this in width and in height cover each other
_LETTER_ROOM = (4.0, 3.0)  # mm on paper: the same of a text and a letter
_ON_LINE = (1.9, 1.2)  # mm on paper: an angle whose text comes so near a cut in width and in height is left out
_LENGTH_ON_LINE = (3.0, 1.2)  # the same of a length, which is wider
_HEAD = (1.5, 0.5)  # mm on paper: length and half of the width of a dimension's heads
_TEXT = 2.4  # mm on paper from an arc to the middle of its text
_MEETS = 1.5  # mm: legs that end so near a corner meet there
_STRAIGHT = 1.02  # a leg that is longer than its chord by less is straight


@dataclass(frozen=True, eq=False)
class Measure:
    """A measure on the paper.

    Parameters
    ----------
    text
        What it says.
    at
        The text's middle in mm, shape (2,).
    arc
        The arc of an angle in mm, shape (k, 2); empty for a length.
    """

    text: str
    at: NDArray[np.float64]
    arc: NDArray[np.float64]


def plan_measures(
    lines: Sequence[NDArray[np.float64]],
    corners: Sequence[Corner],
    projection: Projection,
    letters: Sequence[NDArray[np.float64]] = (),
    kept: Sequence[int] = (),
) -> list[Measure]:
    """Measure planned cuts; equal lengths and equal angles are written once.

    Parameters
    ----------
    lines
        The cuts at rest in mm, each of shape (k, 3); a closed one repeats its first point.
    corners
        Their corners.
    projection
        How they come onto the paper.
    letters
        Where letters stand in mm on paper, each of shape (2,); a measure that would cover one is left out.
    kept
        For each corner the index of a sector that is not excised: angles of flaps come before those of defects.

    Returns
    -------
    list[Measure]
        Straight lengths in whole millimetres, then angles in whole degrees.
    """
    paper = np.concatenate([projection.paper(line)[0] for line in lines]) if lines else np.zeros((0, 2))
    found: list[Measure] = []
    taken: list[NDArray[np.float64]] = []
    said: set[str] = set()
    for line in lines:
        for leg in legs(line):
            length = float(np.linalg.norm(np.diff(leg, axis=0), axis=1).sum())
            text = f"{length:.0f} mm"
            if text in said or len(said) == _MOST or length > _STRAIGHT * float(np.linalg.norm(leg[-1] - leg[0])):
                continue
            at = beside(projection.paper(leg)[0], paper, [*letters, *taken])
            hidden = _covers(at, letters, _LETTER_ROOM) or _covers(at, paper, _LENGTH_ON_LINE)
            if length >= _LEAST and not hidden and not _covers(at, taken):
                said.add(text)
                found.append(Measure(text, at, np.zeros((0, 2))))
                taken.append(at)
    angles: set[str] = set()
    straight = [leg for line in lines for leg in legs(line)]
    flaps_first = sorted(range(len(corners)), key=lambda k: k < len(kept) and kept[k] != 0)
    for corner in (corners[k] for k in flaps_first):
        sector = corner.sectors[0]
        text = f"{np.degrees(sector.angle):.0f}°"
        if sector.angle > _STRAIGHT_ANGLE or text in angles or len(angles) == _MOST:
            continue
        measure = _angle(corner, text, projection, straight)
        if measure is None or _covers(measure.at, letters, _LETTER_ROOM) or _covers(measure.at, paper, _ON_LINE):
            continue
        if not _covers(measure.at, taken):
            angles.add(text)
            found.append(measure)
            taken.append(measure.at)
    return found


def beside(
    leg: NDArray[np.float64], paper: NDArray[np.float64], taken: list[NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Find the place beside a line's middle, on the side where there is more room.

    Parameters
    ----------
    leg
        The line in mm on paper, shape (k, 2).
    paper
        What is drawn, places in mm, shape (n, 2).
    taken
        Where other texts stand, each of shape (2,).

    Returns
    -------
    NDArray[np.float64]
        The place in mm, shape (2,).
    """
    middle, way = leg[len(leg) // 2], leg[-1] - leg[0]
    side = np.array([-way[1], way[0]]) / max(float(np.linalg.norm(way)), 1e-12)
    places = [middle + sign * (_BESIDE + 1.6 * abs(side[0])) * side for sign in (1.0, -1.0)]
    obstacles = np.vstack([paper, *[each[None] for each in taken]])
    room = [float(np.linalg.norm(obstacles - place, axis=1).min()) for place in places]
    far = [float(np.linalg.norm(paper.mean(axis=0) - place)) for place in places]
    best = int(np.argmax([r + 0.05 * f for r, f in zip(room, far, strict=True)]))
    return places[best]


def ticked(paper: NDArray[np.float64], half: float = 1.0) -> NDArray[np.float64]:
    """Put a short stroke across a line at both ends.

    Parameters
    ----------
    paper
        The line in mm on paper, shape (k, 2).
    half
        Half the length of a stroke in mm.

    Returns
    -------
    NDArray[np.float64]
        The line with them, shape (k + 4, 2).
    """

    def across(end: NDArray[np.float64], inner: NDArray[np.float64]) -> NDArray[np.float64]:
        way = (inner - end) / max(float(np.linalg.norm(inner - end)), 1e-12)
        return half * np.array([-way[1], way[0]])

    first, last = across(paper[0], paper[1]), across(paper[-1], paper[-2])
    return np.vstack([paper[0] + first, paper[0] - first, paper, paper[-1] + last, paper[-1] - last])


def dimension(paper: NDArray[np.float64], away: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Draw a dimension beside two points: lines out from them, and one between with a head at each end.

    Parameters
    ----------
    paper
        The points in mm on paper, shape (2, 2).
    away
        How far beside them it lies in mm; negative on the other side.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]]
        One line through all of it, shape (k, 2), and the middle of the line between, shape (2,).
    """
    way = paper[1] - paper[0]
    along = way / max(float(np.linalg.norm(way)), 1e-12)
    side = float(np.sign(away)) * np.array([-along[1], along[0]])
    ends = paper + abs(away) * side
    heads = [
        ends[k] + sign * (_HEAD[0] * along + turn * _HEAD[1] * side)
        for k, sign in ((0, 1), (1, -1))
        for turn in (1, -1)
    ]
    course = [paper[0], ends[0] + side, ends[0], heads[0], ends[0], heads[1], ends[0]]
    course += [ends[1], heads[2], ends[1], heads[3], ends[1], ends[1] + side, paper[1]]
    return np.array(course), ends.mean(axis=0)


def _covers(
    at: NDArray[np.float64],
    taken: Sequence[NDArray[np.float64]] | NDArray[np.float64],
    room: tuple[float, float] = _ROOM,
) -> bool:
    return bool(len(taken)) and bool((np.abs(np.asarray(taken) - at) < np.asarray(room)).all(axis=1).any())


def _angle(
    corner: Corner, text: str, projection: Projection, straight: Sequence[NDArray[np.float64]]
) -> Measure | None:
    """The arc of an angle in the skin's plane and its text inside; None where its legs are too short or not straight.

    A narrow angle has its arc farther out, where the text fits between its legs.
    """
    room = _LEG * min(
        _straight_way(corner, way, straight) for way in (corner.sectors[0].first, corner.sectors[0].second)
    )
    fits = _WIDE / max(2.0 * float(np.sin(0.5 * corner.sectors[0].angle)), 1e-6) - _TEXT
    on_paper = max(_ARC, min(fits, _WIDEST_ARC))
    if fits > _WIDEST_ARC or on_paper > room * projection.scale:
        return None
    radius = on_paper / projection.scale
    sector = corner.sectors[0]
    normal = np.cross(sector.first, sector.second)
    normal /= max(float(np.linalg.norm(normal)), 1e-12)
    across = np.cross(normal, sector.first)
    turns = np.linspace(0.0, sector.angle, 17)[:, None]
    arc = corner.at + radius * (np.cos(turns) * sector.first + np.sin(turns) * across)
    middle = corner.inset(radius + _TEXT / projection.scale)
    return Measure(text, projection.paper(middle[None])[0][0], projection.paper(arc)[0])


def _straight_way(corner: Corner, way: NDArray[np.float64], legs_of: Sequence[NDArray[np.float64]]) -> float:
    """How far a leg runs straight from a corner along a unit vector, mm; 0 where there is none."""
    longest = 0.0
    for leg in legs_of:
        near = int(np.argmin(np.linalg.norm(leg - corner.at, axis=1)))
        if np.linalg.norm(leg[near] - corner.at) > _MEETS:
            continue
        for course in (leg[near:], leg[: near + 1][::-1]):
            out = course[1:] - course[0]
            far = np.linalg.norm(out, axis=1)
            turned = np.arccos(np.clip(out @ way / np.maximum(far, 1e-12), -1.0, 1.0))
            bent = np.flatnonzero((turned > _BEND) & (far > _MEETS))
            longest = max(longest, float(far[bent[0]] if len(bent) else far[-1]) if len(far) else 0.0)
    return longest
