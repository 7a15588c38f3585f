"""The parts of lines that are seen, as smooth strokes on the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from lappet.plates.feature_lines import FeatureLine, LineKind
from lappet.plates.projection import Projection
from lappet.plates.screen_triangles import ScreenTriangles

STEP = 0.3  # mm on paper between two places at which a line is looked at
_HALVINGS = 5
_GAP = 0.7  # mm on paper: shorter gaps in a line are closed
_CRUMB = 0.9  # mm on paper: shorter strokes of a mesh are left out
_TOLERANCE = 0.02  # mm on paper
_SMOOTHING = 2  # rounds


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line on the paper.

    Parameters
    ----------
    kind
        What it is.
    points
        Its course in mm, shape (k, 2); a closed one repeats its first.
    """

    kind: LineKind
    points: NDArray[np.float64]


def sampled(course: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Choose points along a line at even distances; a line without length is one point.

    Parameters
    ----------
    course
        The line, shape (k, d), k at least 1.
    step
        The greatest distance between two points.

    Returns
    -------
    NDArray[np.float64]
        The points, its ends among them, shape (n, d).
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(course, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / step)) + 1)
    return np.stack([np.interp(at, along, course[:, k]) for k in range(course.shape[1])], axis=1)


def visible_strokes(
    lines: Sequence[FeatureLine], projection: Projection, screen: ScreenTriangles, smooth: bool = True
) -> list[Stroke]:
    """Cut lines where the surface hides them and lay them on the paper.

    Parameters
    ----------
    lines
        The lines.
    projection
        How they come onto the paper.
    screen
        The surface on the same paper.
    smooth
        Whether they are edges of a mesh: its steps are taken out of them, and crumbs left out.

    Returns
    -------
    list[Stroke]
        What is seen of each, in the same order.
    """
    strokes = []
    for line in (part for whole in lines for part in _near(whole, projection)):
        samples = _sampled(line.points, projection)
        if len(samples) < 2:
            continue
        paper, depth = projection.paper(samples)
        seen = _seen(paper, depth, line.lift, screen)
        for begin, end in _runs(seen, paper):
            stroke = _cut(samples, seen, begin, end, line.lift, projection, screen)
            if smooth and np.linalg.norm(np.diff(stroke, axis=0), axis=1).sum() < _CRUMB:
                continue
            stroke = _smoothed(stroke) if smooth else stroke
            strokes.append(Stroke(line.kind, np.array(LineString(stroke).simplify(_TOLERANCE).coords)))
    return strokes


def _near(line: FeatureLine, projection: Projection) -> list[FeatureLine]:
    """The parts of a line whose pieces come near the panel; in a close-up most of a line lies far beside it."""
    paper, _ = projection.paper(line.points)
    reach = np.asarray(projection.size)
    low, high = np.minimum(paper[:-1], paper[1:]), np.maximum(paper[:-1], paper[1:])
    near = ((low < reach) & (high > -reach)).all(axis=1)
    if near.all():
        return [line]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]])))
    return [replace(line, points=line.points[a : b + 1]) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _sampled(points: NDArray[np.float64], projection: Projection) -> NDArray[np.float64]:
    """A line with a point at least every `STEP` on the paper."""
    paper, _ = projection.paper(points)
    lengths = np.linalg.norm(np.diff(paper, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / STEP).astype(np.int64), 1)
    owner = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[owner]
    dense = points[owner] + share[:, None] * (points[owner + 1] - points[owner])
    return np.vstack([dense, points[-1:]])


def _seen(
    paper: NDArray[np.float64], depth: NDArray[np.float64], lift: float, screen: ScreenTriangles
) -> NDArray[np.bool_]:
    return depth <= screen.nearest(paper)[1] + lift


def _runs(seen: NDArray[np.bool_], paper: NDArray[np.float64]) -> list[tuple[int, int]]:
    """First and last sample of each part that is seen, with short gaps closed."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]])))
    runs: list[tuple[int, int]] = []
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(paper, axis=0), axis=1))])
    for begin, end in zip(edges[::2], edges[1::2] - 1, strict=True):
        if runs and along[begin] - along[runs[-1][1]] < _GAP:
            runs[-1] = (runs[-1][0], int(end))
        else:
            runs.append((int(begin), int(end)))
    return runs


def _cut(
    samples: NDArray[np.float64],
    seen: NDArray[np.bool_],
    begin: int,
    end: int,
    lift: float,
    projection: Projection,
    screen: ScreenTriangles,
) -> NDArray[np.float64]:
    """A part on the paper, carried on to where it is hidden."""
    ends = []
    for inside, outside in ((begin, begin - 1), (end, end + 1)):
        if not 0 <= outside < len(samples):
            continue
        near, far = samples[inside], samples[outside]
        for _ in range(_HALVINGS):
            middle = 0.5 * (near + far)
            paper, depth = projection.paper(middle[None])
            near, far = (middle, far) if _seen(paper, depth, lift, screen)[0] else (near, middle)
        ends.append((outside < inside, near))
    course = [samples[begin : end + 1]]
    for first, place in ends:
        course = [place[None], *course] if first else [*course, place[None]]
    return projection.paper(np.vstack(course))[0]


def _smoothed(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """A line whose points move towards the middle of their neighbors, but for its ends and its corners."""
    if len(points) < 4:
        return points
    closed = bool(np.allclose(points[0], points[-1]))
    course = points
    ways = np.diff(course, axis=0)
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    spread = 3
    corner = np.zeros(len(points), bool)
    for k in range(1, len(points) - 1):  # judged over a stretch: the steps of a mesh are no corners
        before = course[k] - course[max(k - spread, 0)]
        after = course[min(k + spread, len(points) - 1)] - course[k]
        size = float(np.linalg.norm(before) * np.linalg.norm(after))
        corner[k] = size > 0.0 and float(before @ after) < 0.64 * size
    for _ in range(_SMOOTHING):
        moved = course.copy()
        moved[1:-1] = 0.25 * course[:-2] + 0.5 * course[1:-1] + 0.25 * course[2:]
        if closed:
            moved[0] = moved[-1] = 0.25 * course[-2] + 0.5 * course[0] + 0.25 * course[1]
        moved[corner] = course[corner]
        course = moved
    return course
