"""`lappet.geometry.vectors` against numpy, to the bit: searches and cuts do not change with the layout of arrays."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.geometry.vectors import bounds, cross, dot, length, triangle_corners, unit

GENERATOR = np.random.default_rng(5)
A, B = (GENERATOR.normal(size=(1000, 3)) * 10.0 ** GENERATOR.integers(-6, 7, (1000, 3)) for _ in range(2))


def test_products_and_lengths_are_those_of_numpy_to_the_bit() -> None:
    assert (np.cross(A, B) == cross(A.T, B.T).T).all()
    assert (dot(A.T, B.T) == np.einsum("ij,ij->i", A, B)).all()
    assert (length(A.T) == np.linalg.norm(A, axis=1)).all()


def test_a_vector_without_length_has_no_direction() -> None:
    assert (unit(np.array([[3.0, 0.0], [4.0, 0.0], [0.0, 0.0]])) == [[0.6, 0.0], [0.8, 0.0], [0.0, 0.0]]).all()


def test_corners_of_triangles_come_coordinate_first() -> None:
    triangles = GENERATOR.integers(0, len(A), (50, 3))
    assert (triangle_corners(A, triangles).transpose(2, 1, 0) == A[triangles]).all()


@pytest.mark.parametrize("count", [1, 63, 64, 65, 1000])
def test_the_box_around_points_reaches_from_the_least_to_the_greatest_coordinates(count: int) -> None:
    assert (bounds(A[:count]) == [A[:count].min(axis=0), A[:count].max(axis=0)]).all()
