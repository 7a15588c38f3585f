"""Solve sparse symmetric positive definite systems with 2 x 2 blocks, whose graph is that of a surface.

Vertices are eliminated by nested dissection (George 1973): a plane halves them, those of one half that touch the other
separate both, and the halves are halved again. The factor is found front by front (Duff and Reid 1983): a front holds
the block rows of the vertices that it eliminates and what their elimination adds to the vertices that follow.
numpy is all that it takes, for Blender brings no other library of linear algebra; and of numpy only what uses no
threads of BLAS, products of small tiles: beside a solve these threads wait for each other many times as long as they
work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_LEAF = 30  # vertices that are not halved again
_TILE = 60  # rows and columns of a tile


@dataclass(frozen=True, eq=False)
class _Front:
    """What is eliminated at once."""

    own: NDArray[np.int64]  # vertices that are eliminated here
    border: NDArray[np.int64]  # vertices eliminated later that these touch, or come to touch
    entries: NDArray[np.int64]  # blocks of the matrix that lie here
    row: NDArray[np.int64]  # their places among own
    column: NDArray[np.int64]  # their places among own and border
    children: tuple[tuple[int, NDArray[np.int64]], ...]  # fronts that pass here what they add, and to which rows


@dataclass(frozen=True, eq=False)
class Elimination:
    """In which order the vertices of a graph are eliminated, and where the blocks of a matrix on it go.

    Parameters
    ----------
    fronts
        What is eliminated at once, in that order.
    """

    fronts: tuple[_Front, ...]

    @staticmethod
    def of(points: NDArray[np.float64], pairs: NDArray[np.int64]) -> Elimination:
        """Order the vertices of a graph.

        Parameters
        ----------
        points
            Where they are, shape (n, d); what is near should be joined.
        pairs
            The blocks that a matrix has, shape (k, 2): two vertices that are joined, in both orders, and each with
            itself.

        Returns
        -------
        Elimination
            The order.
        """
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        rows, columns = pairs[order].T
        start = np.searchsorted(rows, np.arange(len(points) + 1))
        groups = _dissected(points, rows, columns)
        when, at = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
        for k, own in enumerate(groups):
            when[own] = k
        fronts: list[_Front] = []
        waiting: list[list[int]] = [[] for _ in groups]
        for k, own in enumerate(groups):
            entries = np.concatenate([order[start[v] : start[v + 1]] for v in own])
            touched = pairs[entries, 1]
            later = when[touched] >= k
            entries, touched = entries[later], touched[later]
            border = np.unique(np.concatenate([touched, *(fronts[child].border for child in waiting[k])]))
            border = border[when[border] > k]
            place = np.concatenate([own, border])
            at[place] = np.arange(len(place))
            children = tuple(
                (child, (2 * at[fronts[child].border][:, None] + np.arange(2)).reshape(-1)) for child in waiting[k]
            )
            fronts.append(_Front(own, border, entries, at[pairs[entries, 0]], at[touched], children))
            if len(border):
                waiting[int(when[border].min())].append(k)
        return Elimination(tuple(fronts))

    def factor(self, blocks: NDArray[np.float64]) -> Factor | None:
        """Factor a symmetric matrix.

        Parameters
        ----------
        blocks
            A block for each of the pairs, shape (k, 2, 2).

        Returns
        -------
        Factor | None
            The factor; None if the matrix is not positive definite.
        """
        panels: list[_Panel] = []
        updates: dict[int, NDArray[np.float64]] = {}
        for k, front in enumerate(self.fronts):
            own, size = 2 * len(front.own), len(front.own) + len(front.border)
            matrix = np.zeros((size, 2, size, 2))
            matrix[front.row, :, front.column, :] = blocks[front.entries]
            flat = matrix.reshape(-1)
            for child, place in front.children:
                flat[2 * size * place[:, None] + place] += updates.pop(child)
            dense = matrix.reshape(2 * size, 2 * size)
            rows = (2 * np.concatenate([front.own, front.border])[:, None] + np.arange(2)).reshape(-1)
            for start in range(0, own, _TILE):
                stop = min(start + _TILE, own)
                try:
                    inverse = _inverse(np.linalg.cholesky(dense[start:stop, start:stop]))
                except np.linalg.LinAlgError:
                    return None
                across = _take_away(inverse, dense[start:stop, stop:], dense[stop:, stop:])
                panels.append(_Panel(rows[start:stop], rows[stop:], inverse, across))
            updates[k] = dense[own:, own:]
        return Factor(tuple(panels))


def _inverse(lower: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inverse of a lower triangular matrix of at most 64 rows, by blocks that double: numpy's own takes threads."""
    size, most, half = len(lower), 64, 8
    whole = np.eye(most)
    whole[:size, :size] = lower
    diagonal = whole.diagonal().copy()
    whole /= diagonal[:, None]
    each = np.arange(most // half)
    unit = np.eye(half)
    # With ones on the diagonal a block is 1 - N, and N⁸ is 0.
    once = unit - whole.reshape(-1, half, most // half, half)[each, :, each]
    twice = once @ once
    found = (unit + once) @ (unit + twice) @ (unit + twice @ twice)
    while half < most:
        pairs = most // (2 * half)
        each = np.arange(pairs)
        below = whole.reshape(pairs, 2, half, pairs, 2, half)[each, 1, :, each, 0]
        doubled = np.zeros((pairs, 2 * half, 2 * half))
        doubled[:, :half, :half], doubled[:, half:, half:] = found[::2], found[1::2]
        doubled[:, half:, :half] = -found[1::2] @ below @ found[::2]
        found, half = doubled, 2 * half
    return np.asarray(found[0, :size, :size] / diagonal[:size])


def _take_away(
    inverse: NDArray[np.float64], right: NDArray[np.float64], rest: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Take from the rest (k, k) what the elimination of a panel (p, k) takes; return the factor's block (p, k)."""
    across = np.empty_like(right)
    starts = range(0, right.shape[1], _TILE)
    for one in starts:
        left = slice(one, one + _TILE)
        across[:, left] = inverse @ right[:, left]
        for two in range(0, one + 1, _TILE):
            up = slice(two, two + _TILE)
            product = across[:, up].T @ across[:, left]
            rest[up, left] -= product
            if two < one:
                rest[left, up] -= product.T
    return across


@dataclass(frozen=True, eq=False)
class _Panel:
    """Rows of a factor, at most _TILE."""

    own: NDArray[np.int64]  # rows of the matrix
    after: NDArray[np.int64]  # those that follow and have something here
    inverse: NDArray[np.float64]  # of the lower triangular factor's diagonal block
    across: NDArray[np.float64]  # the transposed block below it


@dataclass(frozen=True, eq=False)
class Factor:
    """A matrix in a form in which systems with it are solved.

    Parameters
    ----------
    panels
        Rows of its triangular factor, in the order of elimination.
    """

    panels: tuple[_Panel, ...]

    def solve(self, right: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve one system.

        Parameters
        ----------
        right
            The right-hand side, shape (n, 2).

        Returns
        -------
        NDArray[np.float64]
            The solution, shape (n, 2).
        """
        # einsum takes no threads, as products of matrix and vector do.
        rest = right.reshape(-1).copy()
        found = np.empty_like(rest)
        for panel in self.panels:
            part = np.einsum("ij,j->i", panel.inverse, rest[panel.own])
            found[panel.own] = part
            rest[panel.after] -= np.einsum("ij,i->j", panel.across, part)
        for panel in reversed(self.panels):
            part = found[panel.own] - np.einsum("ij,j->i", panel.across, found[panel.after])
            found[panel.own] = np.einsum("ij,i->j", panel.inverse, part)
        return found.reshape(-1, 2)


def _dissected(
    points: NDArray[np.float64], rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> list[NDArray[np.int64]]:
    """Groups of vertices in the order in which they are eliminated."""
    size = len(points)
    side = np.zeros(size, np.int8)
    groups: list[NDArray[np.int64]] = []

    def halve(vertices: NDArray[np.int64], one: NDArray[np.int64], two: NDArray[np.int64]) -> None:
        if len(vertices) <= _LEAF:
            if len(vertices):
                groups.append(vertices)
            return
        at = points[vertices]
        along = at[:, int(np.ptp(at, axis=0).argmax())]
        order = np.argsort(along, kind="stable")
        side[vertices[order[: len(order) // 2]]] = 0
        side[vertices[order[len(order) // 2 :]]] = 1
        touching = one[(side[one] == 0) & (side[two] == 1)]
        side[touching] = 2
        kinds, first, second = side[vertices], side[one], side[two]  # halving the halves writes over `side`
        for k in (0, 1):
            inside = (first == k) & (second == k)
            halve(vertices[kinds == k], one[inside], two[inside])
        between = vertices[kinds == 2]
        if len(between):
            groups.append(between)

    halve(np.arange(size), rows, columns)
    return groups
