"""Tubes along polylines, and spheres."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.drawing.tube_shape import tube_faces, tube_points
from lappet_blender.display.sphere_shape import spheres

HELIX = np.stack([np.cos(t := np.linspace(0.0, 12.0, 200)), np.sin(t), 0.3 * t], axis=-1)


def volume(points: np.ndarray, corners: np.ndarray, starts: np.ndarray) -> tuple[float, dict[tuple[int, int], int]]:
    """The enclosed volume, and how often each directed edge comes."""
    total, edges = 0.0, {}
    for begin, end in zip(starts, [*starts[1:], len(corners)], strict=True):
        face = corners[begin:end]
        for k in range(1, len(face) - 1):
            total += float(np.dot(points[face[0]], np.cross(points[face[k]], points[face[k + 1]]))) / 6.0
        for a, b in zip(face, np.roll(face, -1), strict=True):
            edges[int(a), int(b)] = edges.get((int(a), int(b)), 0) + 1
    return total, edges


@pytest.mark.parametrize("sides", [6, 16])
def test_a_straight_tube_is_closed_outward_and_holds_the_volume_of_its_prism(sides: int) -> None:
    line = np.linspace([1.0, 2.0, 3.0], [4.0, 6.0, 3.0], 7)  # 5 long
    points = tube_points([line], [0.5], sides)
    found, edges = volume(points, *tube_faces([len(line)], sides))
    assert found == pytest.approx(5.0 * 0.5 * sides * 0.25 * np.sin(2.0 * np.pi / sides))
    assert all(count == 1 and edges.get((b, a)) == 1 for (a, b), count in edges.items())


def test_rings_have_the_radius_of_their_point_and_stand_across_the_line() -> None:
    radii = np.linspace(0.05, 0.1, len(HELIX))
    rings = tube_points([HELIX], [radii], 12).reshape(len(HELIX), 12, 3)
    spokes = rings - HELIX[:, None]
    np.testing.assert_allclose(np.linalg.norm(spokes, axis=-1), radii[:, None] * np.ones(12))
    along = np.gradient(HELIX, axis=0)
    np.testing.assert_allclose(np.einsum("kri,ki->kr", spokes, along), 0.0, atol=1e-12)
    # Neighboring rings hardly twist against one another: no tube is wrung out.
    turns = np.einsum("kri,kri->kr", spokes[1:], spokes[:-1]) / (radii[1:] * radii[:-1])[:, None]
    assert turns.min() > 0.95


def test_lines_of_different_lengths_come_in_their_order() -> None:
    lines = [HELIX[:5], HELIX[:9], HELIX[20:25]]
    rings = tube_points(lines, [0.1, 0.1, 0.1], 8).reshape(-1, 8, 3)
    np.testing.assert_allclose(rings.mean(axis=1), np.concatenate(lines), atol=1e-12)
    corners, starts = tube_faces([5, 9, 5], 8)
    assert corners.max() == 8 * 19 - 1
    assert len(starts) == 8 * (4 + 8 + 4) + 6
    assert len(tube_points([], [], 8)) == 0


def test_spheres_are_closed_outward_and_nearly_round() -> None:
    points, triangles = spheres([[0.0, 0.0, 0.0], [5.0, 1.0, 2.0]], 2.0)
    found, edges = volume(points, triangles.ravel(), np.arange(0, triangles.size, 3))
    assert 0.75 < found / (2 * 4 / 3 * np.pi * 8.0) < 1.0
    assert all(count == 1 and edges.get((b, a)) == 1 for (a, b), count in edges.items())
