"""The field of a procedure's skin lines: a direction and a prestretch at every point of the skin.

A line has no sense: t and -t are one direction. So tangents are averaged as tensors t t^T, not as vectors. At a point
of the skin with the unit normal n the samples of all lines, at most `STEP` apart, weigh by Shepard's

    w = 1 / (d^2 + STEP^2)^2,    d: distance to the sample,

and the direction is the eigenvector of the largest eigenvalue of sum w P t t^T P in the tangent plane, P = I - n n^T.
Where the lines cancel (equal parts of two directions at right angles) it is that of the closest sample. Distances are
straight, not along the skin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.curve import sample_curve
from lappet.procedure import Material, SkinLine
from lappet.procedure.prim_paths import SKIN_LINES
from lappet.tissue.uniaxial import prestretch_for

STEP = 1.0  # mm
_CLEAR = 0.05  # least difference of the eigenvalues, relative to their sum, for a direction that is not a tie
_ROWS = 512  # points of the skin at a time
_BLOCK = 4  # so many times as many have their tensors added up at a time


@dataclass(frozen=True, eq=False)
class SkinField:
    """Direction and prestretch at the points of a skin.

    Parameters
    ----------
    directions
        Unit vectors in the tangent planes, shape (s, 3).
    stretch
        Prestretch along and across them, shape (s, 2).
    """

    directions: NDArray[np.float64]
    stretch: NDArray[np.float64]


def line_stretch(line: SkinLine, material: Material) -> tuple[float, float]:
    """Find the prestretch at a line.

    Parameters
    ----------
    line
        The line.
    material
        Material of the skin.

    Returns
    -------
    tuple[float, float]
        Prestretch along and across the line: what gives its tension, or the material's where it has none.
    """
    return material.prestretch if line.tension is None else prestretch_for(material, *line.tension)


def skin_field(
    lines: Sequence[SkinLine], points: NDArray[np.float64], normals: NDArray[np.float64], material: Material
) -> SkinField:
    """Lay the field of lines over a skin.

    Parameters
    ----------
    lines
        The lines; at least one.
    points
        Points of the skin in mm, shape (s, 3).
    normals
        Unit normals there, shape (s, 3).
    material
        Material of the skin, whose law turns tension into stretch.

    Returns
    -------
    SkinField
        The field.

    Raises
    ------
    RefusedError
        If a line is no curve.
    """
    places, tangents, stretches = _samples(lines, material)
    directions, stretch = np.empty_like(points), np.empty((len(points), 2))
    for start in range(0, len(points), _BLOCK * _ROWS):
        block = slice(start, min(start + _BLOCK * _ROWS, len(points)))
        weights, closest = np.empty((len(places), block.stop - start)), np.empty(block.stop - start, np.intp)
        for first in range(start, block.stop, _ROWS):
            rows = slice(first, min(first + _ROWS, block.stop))
            squared = _squared_distances(points[rows], places)
            share = (squared + STEP**2) ** -2.0
            share /= share.sum(axis=1, keepdims=True)
            stretch[rows] = share @ stretches
            within = slice(first - start, rows.stop - start)
            weights[:, within], closest[within] = share.T, squared.argmin(axis=1)
        directions[block] = _directions(weights, closest, tangents, normals[block])
    return SkinField(directions, stretch)


def _squared_distances(points: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of each point (r, 3) from each place (k, 3), shape (r, k); by coordinates, with no array of all differences."""
    squared = np.zeros((len(points), len(places)))
    for at, to in zip(points.T, places.T, strict=True):
        apart = at[:, None] - to
        squared += apart * apart
    return squared


def _samples(
    lines: Sequence[SkinLine], material: Material
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Places, unit tangents and stretches of the middles between samples of all lines."""
    places, tangents, stretches = [], [], []
    for line in lines:
        at = sample_curve(line.points, line.basis, False, STEP, f"{SKIN_LINES}/{line.name}")
        along = np.diff(at, axis=0)
        places.append(0.5 * (at[1:] + at[:-1]))
        tangents.append(along / np.linalg.norm(along, axis=1, keepdims=True))
        stretches.append(np.tile(line_stretch(line, material), (len(along), 1)))
    return np.concatenate(places), np.concatenate(tangents), np.concatenate(stretches)


def _directions(
    weights: NDArray[np.float64],
    closest: NDArray[np.intp],
    tangents: NDArray[np.float64],
    normals: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The main directions of the tangents, weighted (k, r), in the tangent planes, shape (r, 3)."""
    sums = np.zeros((3, 3, weights.shape[1]))
    for weight, tangent in zip(weights, tangents, strict=True):  # einsum adds up in this order too, five times as long
        sums += (tangent[:, None] * weight)[:, None] * tangent[:, None]
    tensors = np.ascontiguousarray(sums.transpose(2, 0, 1))
    plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    values, vectors = np.linalg.eigh(plane @ tensors @ plane)
    main = vectors[:, :, 2]
    tie = values[:, 2] - values[:, 1] < _CLEAR * values[:, 1:].sum(axis=1)
    main[tie] = tangents[closest[tie]]
    main -= (main * normals).sum(axis=1, keepdims=True) * normals
    length = np.linalg.norm(main, axis=1, keepdims=True)
    return np.where(length > 1e-9, main / np.maximum(length, 1e-9), 0.0)
