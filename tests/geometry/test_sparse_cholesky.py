"""Sparse systems on surfaces, against scipy's solver."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray

from face_meshes import nose
from lappet.geometry.sparse_cholesky import Elimination
from lappet.geometry.surface_check import directed_edges, unique_edges


def matrix_on(size: int, edges: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The pairs and blocks of a random positive definite matrix on a graph: a small block for each edge, and 1."""
    squares = np.random.default_rng(2).standard_normal((len(edges), 4, 4))
    squares = squares @ squares.swapaxes(1, 2)
    one, two = edges.T
    each = np.arange(size)
    pairs = np.concatenate([np.stack([each, each], 1), edges, edges[:, ::-1]])
    diagonal = np.tile(0.01 * np.eye(2), (size, 1, 1))
    np.add.at(diagonal, one, squares[:, :2, :2])
    np.add.at(diagonal, two, squares[:, 2:, 2:])
    return pairs, np.concatenate([diagonal, squares[:, :2, 2:], squares[:, 2:, :2]])


def as_sparse(size: int, pairs: NDArray[np.int64], blocks: NDArray[np.float64]) -> scipy.sparse.csc_matrix:
    rows = (2 * pairs[:, 0, None, None] + np.arange(2)[:, None] + 0 * np.arange(2)).ravel()
    columns = (2 * pairs[:, 1, None, None] + 0 * np.arange(2)[:, None] + np.arange(2)).ravel()
    return scipy.sparse.csc_matrix((blocks.ravel(), (rows, columns)), shape=(2 * size, 2 * size))


def test_systems_are_solved_as_by_scipy() -> None:
    mesh = nose(spacing=3.0)
    size = len(mesh.points)
    pairs, blocks = matrix_on(size, unique_edges(directed_edges(mesh.triangles))[0])
    right = np.random.default_rng(4).standard_normal((size, 2))
    factor = Elimination.of(mesh.points, pairs).factor(blocks)
    assert factor is not None
    expected = scipy.sparse.linalg.spsolve(as_sparse(size, pairs, blocks), right.reshape(-1)).reshape(-1, 2)
    assert factor.solve(right) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_parts_that_do_not_touch_and_points_in_one_place_are_solved_too() -> None:
    at = np.zeros((200, 3))
    edges = np.array([[k, k + 1] for k in range(199) if k != 99])
    pairs, blocks = matrix_on(200, edges)
    right = np.random.default_rng(4).standard_normal((200, 2))
    factor = Elimination.of(at, pairs).factor(blocks)
    assert factor is not None
    assert as_sparse(200, pairs, blocks) @ factor.solve(right).reshape(-1) == pytest.approx(right.reshape(-1), abs=1e-9)


def test_what_is_not_positive_definite_has_no_factor() -> None:
    mesh = nose(spacing=6.0)
    pairs, blocks = matrix_on(len(mesh.points), unique_edges(directed_edges(mesh.triangles))[0])
    blocks[57] -= 100.0 * np.eye(2)
    assert Elimination.of(mesh.points, pairs).factor(blocks) is None
