"""Designs draped over a skin: geodesics from the middle, compared with the formula on a sphere and a cylinder."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.designs import draped_on
from lappet.geometry.closest_point import ClosestPoint
from lappet.tissue.dome import dome_scalp, draped
from lappet.tissue.skin_sheet import SkinSheet

RADIUS = 60.0  # mm


def star(reach: float) -> NDArray[np.float64]:
    """Points (k, 2) all around a middle, up to so far from it, and the middle itself."""
    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    rays = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([np.zeros((1, 2)), 0.3 * reach * rays, 0.7 * reach * rays, reach * rays])


def cylinder(step: float) -> SkinSheet:
    """Half a cylinder about the y axis, its top at (0, 0, RADIUS)."""
    turn = np.arange(-80.0, 80.5, np.degrees(step / RADIUS)) * np.pi / 180.0
    along = np.arange(-50.0, 50.5, step)
    points = np.array([(RADIUS * np.sin(t), y, RADIUS * np.cos(t)) for t in turn for y in along])
    row = len(along)
    corner = (np.arange(len(turn) - 1)[:, None] * row + np.arange(row - 1)).ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + row, corner + row + 1], 1), np.stack([corner, corner + row + 1, corner + 1], 1)]
    )
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return SkinSheet(ClosestPoint(points, triangles), unit, points, triangles)


def test_on_a_sphere_a_design_lies_where_the_formula_puts_it() -> None:
    skin = SkinSheet.of(dome_scalp(RADIUS, 45.0, 5.0, resolution=1.5))
    flat = np.column_stack([star(35.0), np.full(73, RADIUS)])
    apart = np.linalg.norm(draped_on(skin, (0.0, 0.0, RADIUS))(flat) - draped(RADIUS)(flat), axis=1)
    assert apart.max() < 0.15


def test_on_a_cylinder_a_design_rolls_up_without_stretch() -> None:
    skin = cylinder(1.5)
    middle, normals = skin.at((0.0, 0.3, RADIUS))
    # The tangent plane of the facet there, which leans a little: the design is drawn in it.
    across = np.cross((0.0, 1.0, 0.0), normals[0])
    flat = star(35.0)
    found = draped_on(skin, middle[0])(middle + flat[:, :1] * across + flat[:, 1:] * np.array([0.0, 1.0, 0.0]))
    turn = np.arctan2(middle[0][0], middle[0][2]) + flat[:, 0] / RADIUS
    exact = np.column_stack([RADIUS * np.sin(turn), middle[0][1] + flat[:, 1], RADIUS * np.cos(turn)])
    assert np.linalg.norm(found - exact, axis=1).max() < 0.15


def test_a_line_ends_at_the_border_of_the_skin() -> None:
    skin = SkinSheet.of(dome_scalp(RADIUS, 20.0, 5.0, resolution=2.0))
    (end,) = draped_on(skin, (0.0, 0.0, RADIUS))(np.array([[30.0, 0.0, RADIUS]]))
    assert end == pytest.approx(draped(RADIUS)(np.array([[20.0, 0.0, RADIUS]]))[0], abs=0.2)
