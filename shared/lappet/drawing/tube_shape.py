"""The surface of round tubes along polylines, all at once: a ring of points at every point of a line."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Radius = NDArray[np.floating] | float


def tube_points(lines: Sequence[NDArray[np.float64]], radii: Sequence[Radius], sides: int) -> NDArray[np.float64]:
    """Place the rings of all lines, one after another.

    Every line keeps one direction of reference, the one most nearly across all of it, so that rings do not twist along
    lines that bend in about one plane.

    Parameters
    ----------
    lines
        Their points, shape (k, 3) each.
    radii
        One for a line, or one for each of its points, shape (k,).
    sides
        How many points a ring has.

    Returns
    -------
    NDArray[np.float64]
        The points, shape (sum of k times sides, 3).
    """
    turn = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    rings: list[NDArray[np.float64] | None] = [None] * len(lines)
    by_length: dict[int, list[int]] = {}
    for k, line in enumerate(lines):
        by_length.setdefault(len(line), []).append(k)
    for length, members in by_length.items():
        p = np.stack([lines[k] for k in members])
        radius = np.stack([np.broadcast_to(np.asarray(radii[k], np.float64), length) for k in members])
        along = np.gradient(p, axis=1) if length > 1 else np.broadcast_to([0.0, 0.0, 1.0], p.shape)
        along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-12)
        reference = np.linalg.eigh(np.einsum("lki,lkj->lij", along, along))[1][:, None, :, 0]
        across = reference - (reference * along).sum(-1, keepdims=True) * along
        across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-12)
        beside = np.cross(along, across)
        ring = p[:, :, None] + radius[:, :, None, None] * (
            circle[0][:, None] * across[:, :, None] + circle[1][:, None] * beside[:, :, None]
        )
        for k, one in zip(members, ring.reshape(len(members), -1, 3), strict=True):
            rings[k] = one
    return np.concatenate([r for r in rings if r is not None]) if lines else np.zeros((0, 3))


def tube_faces(lengths: Sequence[int], sides: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Join the rings of tubes and close their ends.

    Parameters
    ----------
    lengths
        How many points each line has.
    sides
        How many points a ring has.

    Returns
    -------
    tuple[NDArray[np.int32], NDArray[np.int32]]
        The corners of the faces, one face after another, as indices of points, and where each face starts among them.
    """
    quads, caps = [], []
    around = np.arange(sides)
    base = 0
    for length in lengths:
        low = base + sides * np.arange(length - 1)[:, None]
        a, b = low + around, low + (around + 1) % sides
        quads.append(np.stack([a, b, b + sides, a + sides], axis=-1).reshape(-1, 4))
        caps += [base + around[::-1], base + sides * (length - 1) + around]
        base += sides * length
    if not quads:
        return np.zeros(0, np.int32), np.zeros(0, np.int32)
    sheet, ends = np.concatenate(quads), np.stack(caps)
    corners = np.concatenate([sheet.ravel(), ends.ravel()])
    starts = np.concatenate([4 * np.arange(len(sheet)), sheet.size + sides * np.arange(len(ends))])
    return corners.astype(np.int32), starts.astype(np.int32)
