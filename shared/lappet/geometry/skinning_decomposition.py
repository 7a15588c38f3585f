"""Bones and weights that move a mesh as it moves: smooth skinning decomposition with rigid bones.

Le & Deng, Smooth Skinning Decomposition with Rigid Bones, ACM Transactions on Graphics 31 (6), 2012. Weights and bones
are found in turn, each as the least squares of the other. Unlike there, bones are added where the error is greatest
until it is small enough, and neighbors are drawn to like weights, so that no crease shows where the share of one bone
ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.skinning_bones import moved, rigid_fit
from lappet.geometry.skinning_weights import CANDIDATES, INFLUENCES, closest_bones, fitted_weights

_ROUNDS = 2  # of weights and bones in turn after bones are added
_LAST_ROUNDS = 4  # and once there are enough
_CLUSTER = 24  # vertices that a new bone starts from
_CHUNK = 2048
_SMOOTHNESS = 0.01  # mm: how far a vertex may be drawn away, in each frame, by neighbors whose weights are all others


@dataclass(frozen=True, eq=False)
class Skinning:
    """Bones and weights.

    Parameters
    ----------
    rotation
        Of each bone in each frame, from the bind pose, shape (f, b, 3, 3).
    shift
        Its translation in mm, shape (f, b, 3).
    bones
        For each vertex the bones that move it, shape (n, 4).
    weights
        Their weights, none negative, which sum to 1, of the same shape.
    """

    rotation: NDArray[np.float64]
    shift: NDArray[np.float64]
    bones: NDArray[np.int64]
    weights: NDArray[np.float64]

    def positions(self, bind: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move vertices.

        Parameters
        ----------
        bind
            Their places in the bind pose in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.float64]
            Their places in each frame, shape (f, n, 3).
        """
        total = np.zeros((len(self.rotation), *bind.shape))
        for k in range(self.bones.shape[1]):
            own = self.bones[:, k]
            placed = np.einsum("fnij,nj->fni", self.rotation[:, own], bind) + self.shift[:, own]
            total += self.weights[:, k, None] * placed
        return total


def skinning_decomposition(
    bind: NDArray[np.floating],
    frames: NDArray[np.floating],
    edges: NDArray[np.integer],
    tolerance: float,
    most_bones: int,
) -> Skinning:
    """Find bones and weights for a mesh that moves.

    Parameters
    ----------
    bind
        Its vertices in the bind pose in mm, shape (n, 3).
    frames
        Its vertices in each frame in mm, shape (f, n, 3).
    edges
        Pairs of neighbors, shape (e, 2).
    tolerance
        How far a vertex may be, in any frame, from where it is, in mm.
    most_bones
        How many bones there may be.

    Returns
    -------
    Skinning
        The bones and weights; where the tolerance is not met, those with the smallest greatest error found.
    """
    center = np.asarray(bind, np.float64).mean(axis=0)
    work = _Decomposition(np.asarray(bind, np.float64) - center, np.asarray(frames, np.float64) - center, edges)
    best, least = None, np.inf
    work.add(1)
    while True:
        enough = work.count >= most_bones
        for _ in range(_LAST_ROUNDS if enough else _ROUNDS):
            work.fit_weights()
            work.fit_bones()
            worst = float(work.errors().max())
            if worst < least:
                best, least = work.result(center), worst
        if least <= tolerance or enough:
            break
        work.add(min(max(work.count // 3, min(len(bind) // 100, 8), 2), most_bones - work.count))
    assert best is not None
    return best


class _Decomposition:
    """A decomposition that is being made; the bind pose's center is at the origin."""

    def __init__(self, bind: NDArray[np.float64], frames: NDArray[np.float64], edges: NDArray[np.integer]) -> None:
        self._bind, self._frames = bind, frames
        self._edges = edges
        self._price = len(frames) * _SMOOTHNESS**2
        self._rotation = np.zeros((len(frames), 0, 3, 3))
        self._shift = np.zeros((len(frames), 0, 3))
        self._bones = np.zeros((len(bind), INFLUENCES), np.int64)
        self._weights = np.zeros((len(bind), INFLUENCES))
        self._left = frames.copy()  # of the positions that bones and weights do not make

    @property
    def count(self) -> int:
        return self._rotation.shape[1]

    def errors(self) -> NDArray[np.float64]:
        """How far each vertex is, at most, from where it is, in mm."""
        return np.linalg.norm(self._left, axis=2).max(axis=0)

    def result(self, center: NDArray[np.float64]) -> Skinning:
        shift = self._shift + center - self._rotation @ center
        return Skinning(self._rotation.copy(), shift, self._bones.copy(), self._weights.copy())

    def add(self, count: int) -> None:
        """Add bones where vertices are farthest from where they are, each of vertices that move alike."""
        errors = self.errors()
        size = min(_CLUSTER if self.count else len(errors), len(errors))
        for _ in range(count):
            seed = int(np.argmax(errors))
            apart = ((self._frames - self._frames[:, seed : seed + 1]) ** 2).sum(axis=2).mean(axis=0)
            near = np.argpartition(apart, size - 1)[:size]
            rotation, shift = rigid_fit(self._bind[near], np.ones(size), self._frames[:, near])
            self._rotation = np.concatenate([self._rotation, rotation[:, None]], axis=1)
            self._shift = np.concatenate([self._shift, shift[:, None]], axis=1)
            errors[near] = 0.0
            if not errors.any():
                break

    def fit_weights(self) -> None:
        alone = self._errors_alone()
        wanted = self._neighbors_mean()
        # The bones of neighbors are candidates too.
        chosen = closest_bones(alone / (1.0 + 20.0 * wanted), CANDIDATES)
        for begin in range(0, len(self._bind), _CHUNK):
            rows = slice(begin, begin + _CHUNK)
            own = chosen[rows]
            placed = np.einsum("fnkij,nj->fnki", self._rotation[:, own], self._bind[rows]) + self._shift[:, own]
            near = np.take_along_axis(wanted[rows], own, 1)
            kept, weights = fitted_weights(self._frames[:, rows], placed, near, self._price)
            self._bones[rows], self._weights[rows] = np.take_along_axis(own, kept, 1), weights
        self._left = self._frames - self.result(np.zeros(3)).positions(self._bind)

    def _errors_alone(self) -> NDArray[np.float64]:
        """Squared error of each vertex, summed over the frames, if one bone moved it alone: shape (n, b)."""
        frames = self._frames.transpose(1, 0, 2).reshape(len(self._bind), -1)
        shift = self._shift.transpose(1, 0, 2).reshape(self.count, -1)
        own = len(self._frames) * (self._bind**2).sum(axis=1) + (frames**2).sum(axis=1)
        total = own[:, None] + (shift**2).sum(axis=1) - 2.0 * frames @ shift.T
        total += 2.0 * self._bind @ np.einsum("fbij,fbi->jb", self._rotation, self._shift)
        for axis in range(3):
            column = self._rotation[..., axis].transpose(1, 0, 2).reshape(self.count, -1)
            total -= 2.0 * self._bind[:, axis, None] * (frames @ column.T)
        return np.maximum(total, 0.0)

    def _neighbors_mean(self) -> NDArray[np.float64]:
        """Weights of all bones at the neighbors of each vertex, shape (n, b)."""
        dense = np.zeros((len(self._bind), self.count))
        np.put_along_axis(dense, self._bones, 0.0, 1)
        np.add.at(dense, (np.arange(len(dense))[:, None], self._bones), self._weights)
        total = np.zeros_like(dense)
        for one, other in ((0, 1), (1, 0)):
            np.add.at(total, self._edges[:, one], dense[self._edges[:, other]])
        count = np.bincount(self._edges.ravel(), minlength=len(dense))[:, None]
        return total / np.maximum(count, 1)

    def fit_bones(self) -> None:
        """Fit the motion of each bone to what the others leave."""
        for b in range(self.count):
            vertex, slot = np.nonzero((self._bones == b) & (self._weights > 1e-6))
            if not len(vertex):
                continue
            weights, points = self._weights[vertex, slot], self._bind[vertex]
            targets = self._left[:, vertex] + weights[:, None] * moved(points, self._rotation[:, b], self._shift[:, b])
            rotation, shift = rigid_fit(points, weights, targets)
            self._rotation[:, b], self._shift[:, b] = rotation, shift
            self._left[:, vertex] = targets - weights[:, None] * moved(points, rotation, shift)
