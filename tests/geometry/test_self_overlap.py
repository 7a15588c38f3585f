"""A closed surface passes through itself where its vertices lie inside it; how deep, against the shapes' formulas."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from lappet.geometry.axis_rays import AxisRays
from lappet.geometry.self_overlap import self_overlap
from lappet.program.compile import compile_program
from small_procedure import small_procedure

RADIUS = 10.0


def box(center: tuple[float, float, float], sides: tuple[float, float, float]) -> tuple[NDArray, NDArray]:
    """The points and triangles of a box with vertices about 1 mm apart."""
    mesh = trimesh.creation.box(sides).subdivide_to_size(1.5)
    mesh.merge_vertices()
    return np.asarray(mesh.vertices, float) + center, np.asarray(mesh.faces)


def two_boxes(apart: float) -> tuple[NDArray, NDArray]:
    """Two boxes of 6 mm whose middles are so far apart along x, as one surface; the second is smaller across."""
    (a, s), (b, t) = box((0.0, 0.0, 0.0), (6.0, 6.0, 6.0)), box((apart, 0.11, 0.07), (6.0, 4.0, 4.0))
    return np.vstack([a, b]), np.vstack([s, t + len(a)])


def rolled(turns: float) -> tuple[NDArray, NDArray]:
    """A strip 2 mm thick that is bent about y to a ring, so many times round."""
    points, triangles = box((0.0, 0.0, 0.0), (60.0, 8.0, 2.0))
    angle = 2.0 * np.pi * turns * (points[:, 0] / np.ptp(points[:, 0]))
    radius = RADIUS - points[:, 2]
    return np.stack([radius * np.sin(angle), points[:, 1], -radius * np.cos(angle)], axis=1), triangles


def test_a_line_enters_and_leaves_a_box_where_its_sides_are() -> None:
    points, triangles = box((1.0, 2.0, 3.0), (4.0, 6.0, 2.0))
    for axis, side in enumerate((4.0, 6.0, 2.0)):
        line, along, leaves = AxisRays(points, triangles, axis).crossings(np.array([[1.1, 2.2, 3.3], [9.0, 9.0, 9.0]]))
        at = (1.1, 2.2, 3.3)[axis] - (1.0, 2.0, 3.0)[axis]
        order = np.argsort(along)
        np.testing.assert_array_equal(line, [0, 0])
        np.testing.assert_allclose(along[order], [-side / 2 - at, side / 2 - at], atol=1e-5)
        np.testing.assert_array_equal(leaves[order], [False, True])


def test_boxes_that_do_not_meet_do_not_overlap() -> None:
    assert len(self_overlap(*two_boxes(6.2)).vertices) == 0


@pytest.mark.parametrize("deep", [0.1, 0.5, 0.9])
def test_a_box_that_is_pushed_into_another_lies_in_it_as_deep_as_it_was_pushed(deep: float) -> None:
    points, triangles = two_boxes(6.0 - deep)
    found = self_overlap(points, triangles)
    end = np.flatnonzero((np.arange(len(points)) >= len(points) // 2) & (points[:, 0] < 3.0))
    inside = end[np.abs(points[end, 0] - (3.0 - deep)) < 1e-6]
    assert set(inside) <= set(found.vertices)
    np.testing.assert_allclose(found.depth.max(), deep, atol=1e-3)


def test_a_strip_that_is_rolled_up_once_round_lies_in_itself_only_where_its_ends_pass() -> None:
    assert len(self_overlap(*rolled(0.98)).vertices) == 0
    points, triangles = rolled(1.05)
    found = self_overlap(points, triangles)
    # The ends are at the top of the ring; 2.5 % of its circumference lie to each side of that.
    angle = np.abs(np.arctan2(points[found.vertices, 0], points[found.vertices, 2]))
    assert len(found.vertices) > 20
    assert angle.max() <= 0.025 * 2.0 * np.pi + 1e-3
    # The strip is 2 mm thick.
    assert 0.5 < found.depth.max() <= 2.0


def test_an_open_slit_is_no_overlap() -> None:
    for epoch in compile_program(small_procedure()).epochs:
        assert len(self_overlap(epoch.surface.points, epoch.surface.triangles).vertices) == 0
