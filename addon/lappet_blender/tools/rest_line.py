"""Lines of events on the skin: sampled at rest, laid on the skin, and carried to where it is shown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import RefusedError
from lappet.geometry.curve import sample_curve

from ..model.event_kinds import BASIS_OF
from .shown_surface import Located, RestShape, ShownSurface

_STEP = 0.6
_MOST = 400
# A sample farther than this (mm) beside the shown skin at rest lies where tissue was taken away.
_GONE = 1.0


def rest_samples(points: ArrayLike, basis: str = "LINEAR", closed: bool = False) -> NDArray[np.float64]:
    """Sample (k, 3) in mm of the line through control points (n, 3), about 0.6 mm apart and at most some hundreds.

    A closed line's first sample is repeated. A line that cannot be followed yet (too few points) is its points.
    """
    control = np.asarray(points, np.float64).reshape(-1, 3)
    length = float(np.linalg.norm(np.diff(control, axis=0), axis=1).sum()) if len(control) else 0.0
    try:
        samples = sample_curve(control, BASIS_OF[basis], closed, max(_STEP, length / _MOST))
    except RefusedError:
        return control
    return np.vstack([samples, samples[:1]]) if closed else samples


def rest_line(shape: RestShape, points: ArrayLike, basis: str = "LINEAR", closed: bool = False) -> Located:
    """The samples of a line, each at the nearest place of the skin."""
    return shape.locate(rest_samples(points, basis, closed))


def line_length(shape: RestShape, points: ArrayLike, basis: str = "LINEAR", closed: bool = False) -> float:
    """How long a line is on the skin at rest, mm."""
    return float(np.linalg.norm(np.diff(shape.at(rest_line(shape, points, basis, closed)), axis=0), axis=1).sum())


def beside(shape: RestShape, points: ArrayLike, basis: str, closed: bool, offset: float) -> NDArray[np.float64]:
    """The samples (k, 3) of a line moved along the skin at rest to its left by `offset` mm (right: negative)."""
    samples = rest_samples(points, basis, closed)
    if len(samples) < 2:
        return samples
    located = shape.locate(samples)
    normal = shape.normals(located.triangle)
    along = np.gradient(samples, axis=0)
    if closed:
        along[[0, -1]] = samples[1] - samples[-2]
    left = np.cross(normal, along)
    return samples + offset * left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)


def world_runs(
    surface: ShownSurface, samples: NDArray[np.float64], located: Located, lift: float = 0.2
) -> list[NDArray[np.float64]]:
    """A sampled line (k, 3) as it is shown: polylines (j, 3) of the world, `lift` mm above the surface.

    It is broken where a wound gapes across it and where its tissue was taken away.
    """
    rest = surface.rest.at(located)
    offset = samples - rest
    normal = surface.rest.normals(located.triangle)
    aside = np.linalg.norm(offset - np.einsum("ki,ki->k", offset, normal)[:, None] * normal, axis=1)
    there = aside <= np.maximum(_GONE, 0.5 * np.linalg.norm(offset, axis=1))  # else it is beside the skin, not over it
    world = surface.carry(located)
    stretch = np.linalg.norm(np.diff(world, axis=0), axis=1) * surface.mm
    joined = stretch <= 4.0 * np.linalg.norm(np.diff(rest, axis=0), axis=1) + 0.5
    world = world + surface.normals(located.triangle) * (lift / surface.mm)
    runs: list[NDArray[np.float64]] = []
    begin = 0
    for k in range(1, len(world) + 1):
        if k == len(world) or not (joined[k - 1] and there[k] and there[k - 1]):
            if k - begin > 1 and there[begin:k].all():
                runs.append(world[begin:k])
            begin = k
    return runs


def segment_at(control: ArrayLike, place: Sequence[float], closed: bool) -> int:
    """The index before which a new point at `place` belongs between control points (n, 3)."""
    points = np.asarray(control, np.float64).reshape(-1, 3)
    following = np.roll(points, -1, axis=0) if closed else points[1:]
    leading = points if closed else points[:-1]
    if len(leading) == 0:
        return len(points)
    way = following - leading
    square = np.einsum("ij,ij->i", way, way)
    t = np.clip(np.einsum("ij,ij->i", np.asarray(place) - leading, way) / np.maximum(square, 1e-300), 0.0, 1.0)
    away = np.linalg.norm(leading + t[:, None] * way - np.asarray(place), axis=1)
    return 1 + int(np.where(square > 0.0, away, np.inf).argmin())  # nothing goes between the doubled ends of a curve
