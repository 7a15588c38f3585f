"""Contours lie where the normal is at right angles to the line of sight: on a sphere and a torus, by formulas."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from lappet.plates.drawn_surface import corner_normals
from lappet.plates.feature_lines import contour_lines

PIXEL = 25.4 / 300.0  # mm on paper
PAPER = 55.0  # mm on paper that the solid is wide


def contours(mesh: trimesh.Trimesh, eye: NDArray[np.float64]) -> NDArray[np.float64]:
    triangles = np.asarray(mesh.faces, np.int64)
    normals = corner_normals(mesh.vertices, triangles, np.zeros(len(triangles), np.int64))
    return np.vstack(contour_lines(np.asarray(mesh.vertices), triangles, normals, eye))


def test_the_contour_of_a_sphere_is_its_circle_to_a_fifth_of_a_pixel() -> None:
    radius, far = 20.0, 300.0
    mesh = trimesh.creation.icosphere(subdivisions=6, radius=radius)
    found = contours(mesh, np.array([0.0, 0.0, far]))
    # Seen from a point the contour is the circle in the plane z = R²/d, of radius R sqrt(1 - R²/d²).
    on_paper = np.linalg.norm(found[:, :2], axis=1) / (far - found[:, 2])
    right = radius * np.sqrt(1.0 - (radius / far) ** 2) / (far - radius**2 / far)
    scale = PAPER / (2.0 * right)
    assert len(found) > 100
    assert np.abs(on_paper - right).max() * scale < 0.2 * PIXEL


def test_the_contour_of_a_torus_from_far_above_its_axis_is_two_circles() -> None:
    ring, tube, far = 15.0, 5.0, 1e6
    mesh = trimesh.creation.torus(ring, tube, major_sections=256, minor_sections=128)
    found = contours(mesh, np.array([0.0, 0.0, far]))
    away = np.linalg.norm(found[:, :2], axis=1)
    scale = PAPER / (2.0 * (ring + tube))
    error = np.minimum(np.abs(away - (ring - tube)), np.abs(away - (ring + tube)))
    assert error.max() * scale < 0.2 * PIXEL
    assert (away < ring).any()
    assert (away > ring).any()


def test_a_flat_sheet_has_no_contour() -> None:
    grid = trimesh.creation.box((40.0, 40.0, 1.0))
    top = grid.submesh([np.flatnonzero(grid.face_normals[:, 2] > 0.5)], append=True)
    triangles = np.asarray(top.faces, np.int64)
    normals = corner_normals(top.vertices, triangles, np.zeros(len(triangles), np.int64))
    assert contour_lines(np.asarray(top.vertices), triangles, normals, np.array([0.0, 0.0, 100.0])) == []
