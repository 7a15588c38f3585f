"""Strokes end where the surface hides them, to a tenth of a millimeter, and none lies behind it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.drawing.framing import Viewpoint
from lappet.plates.feature_lines import FeatureLine, LineKind
from lappet.plates.projection import Projection
from lappet.plates.screen_triangles import ScreenTriangles
from lappet.plates.strokes import sampled, visible_strokes

FAR = 1000.0
VIEW = Projection(Viewpoint(np.array([0.0, 0.0, FAR]), np.eye(3), FAR), (60.0, 45.0), 0.03)  # 1 mm is 1 mm


def wall(x: float, z: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A rectangle from x to the right that faces the camera at a height z."""
    corners = np.array([[x, -10.0, z], [30.0, -10.0, z], [30.0, 10.0, z], [x, 10.0, z]])
    return corners, np.array([[0, 1, 2], [0, 2, 3]])


def strokes_behind(x: float, z: float, lift: float = 0.0) -> list[NDArray[np.float64]]:
    points, triangles = wall(x, z)
    screen = ScreenTriangles(*VIEW.paper(points), triangles, 0.5)
    line = FeatureLine(LineKind.CONTOUR, np.array([[-20.0, 0.0, 0.0], [20.0, 0.0, 0.0]]), lift)
    return [stroke.points for stroke in visible_strokes([line], VIEW, screen)]


@pytest.mark.parametrize("border", [-7.3, 0.0, 3.14])
def test_a_line_ends_where_something_stands_before_it(border: float) -> None:
    (stroke,) = strokes_behind(border, 5.0)
    edge = border * FAR / (FAR - 5.0)  # the wall is nearer to the camera
    assert stroke[:, 0].min() == pytest.approx(-20.0, abs=1e-9)
    assert stroke[:, 0].max() == pytest.approx(edge, abs=0.02)


def test_a_line_in_front_is_whole() -> None:
    (stroke,) = strokes_behind(-7.3, -5.0)
    assert stroke[[0, -1], 0] == pytest.approx([-20.0, 20.0], abs=1e-9)


def test_a_line_on_the_surface_needs_its_lift() -> None:
    assert strokes_behind(-20.0, 0.1) == []
    assert len(strokes_behind(-20.0, 0.1, lift=0.2)) == 1


def test_what_faces_away_hides_nothing() -> None:
    points, triangles = wall(-30.0, 5.0)
    screen = ScreenTriangles(*VIEW.paper(points), triangles[:, ::-1], 0.5)
    assert screen.nearest(np.zeros((1, 2)))[0][0] == -1


def test_of_two_walls_the_nearer_is_seen_everywhere() -> None:
    rng = np.random.default_rng(7)
    near, triangles = wall(-30.0, 3.0)
    far, _ = wall(-30.0, 1.0)
    screen = ScreenTriangles(*VIEW.paper(np.vstack([far, near])), np.vstack([triangles, triangles + 4]), 0.5)
    places = rng.uniform((-29.0, -9.0), (29.0, 9.0), (500, 2))
    found, depth = screen.nearest(places)
    assert set(found) <= {2, 3}
    assert depth == pytest.approx(FAR - 3.0, abs=1e-6)


def test_a_line_is_sampled_at_even_distances_and_one_without_length_is_a_point() -> None:
    course = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0]])
    points = sampled(course, 0.5)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.5)
    np.testing.assert_allclose(points[[0, -1]], course[[0, -1]])
    np.testing.assert_allclose(sampled(np.array([[2.0, 5.0], [2.0, 5.0]]), 0.5), [[2.0, 5.0]])
