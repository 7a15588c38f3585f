"""Cross-sections: the outline of a box, what is left of lines, and values inside an outline."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.drawing.mean_value import mean_values
from lappet.drawing.section_plane import SectionPlane
from lappet.tissue.patch import flat_patch
from lappet.tissue.surface import tissue_surface


def test_the_outline_of_a_box_is_a_rectangle_with_the_values_of_its_places() -> None:
    surface = tissue_surface(flat_patch((20.0, 12.0, 4.0), resolution=2.0))
    plane = SectionPlane.of((1.3, 0.0, 0.0, 2.0, 0.0, 0.0))
    values = surface.points @ np.array([[1.0, 0.0], [2.0, -1.0], [0.5, 3.0]])
    edges, found = plane.outline(surface.points, surface.triangles, values)
    assert np.allclose(edges[..., 0], 1.3)
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).sum() == pytest.approx(2 * (12.0 + 4.0))
    assert np.allclose(found, edges @ np.array([[1.0, 0.0], [2.0, -1.0], [0.5, 3.0]]))
    a, b = np.moveaxis(plane.flat(edges), 1, 0)
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    assert abs(area) == pytest.approx(12.0 * 4.0), "the edges are turned alike"
    starts, ends = (np.unique(np.round(edges[:, k], 9), axis=0) for k in (0, 1))
    assert np.array_equal(starts, ends), "and closed"


def test_the_outline_through_vertices_has_no_edge_without_length_and_none_twice() -> None:
    surface = tissue_surface(flat_patch((20.0, 12.0, 4.0), resolution=2.0))
    assert (np.abs(surface.points[:, 0] - 2.0) < 1e-9).any()
    plane = SectionPlane.of((2.0, 0.0, 0.0, 1.0, 0.0, 0.0))
    edges, _ = plane.outline(surface.points, surface.triangles, surface.points)
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    assert lengths.min() > 1e-6
    assert lengths.sum() == pytest.approx(2 * (12.0 + 4.0), abs=1e-3)
    assert len(np.unique(np.round(edges.mean(axis=1), 6), axis=0)) == len(edges)


def test_lines_are_cut_off_at_the_plane_with_their_radii() -> None:
    plane = SectionPlane.of((0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    wave = np.array([(0.0, 0.0, -1.0), (1.0, 0.0, 1.0), (2.0, 0.0, 1.0), (3.0, 0.0, -3.0)])
    lines, radii = plane.before([wave, wave + np.array((0.0, 0.0, 5.0))], [np.array([1.0, 2.0, 2.0, 4.0]), 1.0])
    assert [line[:, 0].tolist() for line in lines] == [[0.0, 0.5], [2.25, 3.0]]
    assert [np.asarray(radius).tolist() for radius in radii] == [[1.0, 1.5], [2.5, 4.0]]
    places, number = plane.pierced([wave])
    assert [place.tolist() for place in places] == [[[0.5, 0.0, 0.0]], [[2.25, 0.0, 0.0]]]
    assert number == [0, 0]


def test_mean_values_reproduce_linear_values_inside_an_outline_with_a_hole_and_on_it() -> None:
    def ring(radius: float, way: int) -> np.ndarray:
        turn = way * np.linspace(0.0, 2.0 * np.pi, 40)
        at = radius * np.stack([np.cos(turn), 0.6 * np.sin(turn)], axis=1)
        return np.stack([at[:-1], at[1:]], axis=1)

    edges = np.concatenate([ring(5.0, 1), ring(1.5, -1)])
    slope = np.array([[2.0, -1.0, 0.3], [0.5, 4.0, 0.0]])
    values = edges @ slope + 7.0
    rng = np.random.default_rng(3)
    turn, radius = rng.uniform(0.0, 2.0 * np.pi, 200), rng.uniform(1.6, 4.9, 200)
    places = np.stack([radius * np.cos(turn), 0.6 * radius * np.sin(turn)], axis=1)
    places = np.concatenate([places, edges[::7, 0], edges[::5].mean(axis=1)])
    assert np.allclose(mean_values(places, edges, values), places @ slope + 7.0, atol=1e-6)


def test_a_section_without_a_normal_is_refused() -> None:
    for numbers in ((0.0,) * 6, (0.0, 0.0, 0.0, np.nan, 0.0, 1.0), (1.0, 2.0)):
        with pytest.raises(ValueError, match="six numbers"):
            SectionPlane.of(numbers)
