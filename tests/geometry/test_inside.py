"""Which side of a surface points lie on, beside faces, edges and corners."""

from __future__ import annotations

from typing import Any

import manifold3d
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from lappet.geometry.closest_point import closest_points
from lappet.geometry.inside import InsideTest
from lappet.geometry.solid import solid_surface


def contained(points: NDArray[np.float64], triangles: NDArray[Any], queries: NDArray[np.float64]) -> NDArray[np.bool_]:
    triangle, closest, _ = closest_points(queries, points, triangles)
    return InsideTest(points, triangles).contains(queries, triangle, closest)


def test_points_about_a_torus_are_told_by_its_formula() -> None:
    mesh = trimesh.creation.torus(20.0, 6.0, major_sections=96, minor_sections=48)
    queries = np.random.default_rng(3).uniform(-30, 30, (400, 3)) * [1, 1, 0.3]
    outside = np.hypot(np.hypot(queries[:, 0], queries[:, 1]) - 20.0, queries[:, 2]) - 6.0
    clear = np.abs(outside) > 0.05  # the facets are that far from the torus
    assert (contained(np.asarray(mesh.vertices), mesh.faces, queries)[clear] == (outside < 0.0)[clear]).all()


@pytest.mark.parametrize("inwards", [False, True])
def test_points_beside_edges_and_corners_of_a_notched_box(inwards: bool) -> None:
    """What is nearest is an edge or a corner, sharp or reentrant: there one face's normal would not tell."""
    outline = [(0, 0), (10, 0), (10, 10), (5, 1), (0, 10)]  # a deep notch with its tip at (5, 1)
    points, triangles = solid_surface(manifold3d.CrossSection([outline]).extrude(4.0))
    step = -1.0 if inwards else 1.0
    corners = np.array([(0, 0, 0), (10, 0, 4), (0, 10, 4), (10, 10, 0), (0, 0, 2.2), (10, 10, 1.3)], float)
    middle = np.array([(2, 2, 2), (8, 2, 2), (1, 5, 2), (9, 5, 2), (2, 2, 2.2), (9, 5, 1.3)], float)
    away = corners - middle
    queries = corners + step * 1e-3 * away / np.linalg.norm(away, axis=1, keepdims=True)
    notch = np.array([(5.0, 1.0 + step * 1e-3, 2.0), (5.0, 1.0 + step * 1e-3, 3.99)])
    assert contained(points, triangles, queries).tolist() == [inwards] * len(queries)
    assert contained(points, triangles, notch).tolist() == [inwards] * len(notch)
