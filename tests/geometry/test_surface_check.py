"""Where a surface is open, where its parts touch, and where they pass through each other."""

from __future__ import annotations

import numpy as np
import trimesh

from lappet.geometry.surface_check import intersections, piercings, pinched_vertices, unpaired_edges

BOX = np.asarray(trimesh.creation.box().faces, np.int64)


def glued(*pairs: tuple[int, int]) -> np.ndarray:
    """Two boxes of which vertices are one, each a vertex of the first and one of the second."""
    second = BOX + 8
    for one, other in pairs:
        second = np.where(second == other + 8, one, second)
    return np.concatenate([BOX, second])


def test_a_closed_surface_is_neither_open_nor_pinched() -> None:
    for faces in (BOX, glued(), np.asarray(trimesh.creation.torus(3.0, 1.0).faces)):
        assert len(unpaired_edges(faces)) == 0
        assert len(pinched_vertices(faces)) == 0


def test_a_hole_has_unpaired_edges_and_pinches_nothing() -> None:
    a, b, c = BOX[0]
    found = unpaired_edges(BOX[1:])
    assert {tuple(edge) for edge in found.tolist()} == {(b, a), (c, b), (a, c)}
    assert len(pinched_vertices(BOX[1:])) == 0


def test_boxes_that_touch_at_a_corner_are_pinched_there_and_not_open() -> None:
    assert len(unpaired_edges(glued((3, 5)))) == 0
    assert pinched_vertices(glued((3, 5))).tolist() == [3]


def test_boxes_that_share_an_edge_are_pinched_at_its_ends() -> None:
    a, b, _ = BOX[0].tolist()
    faces = glued((a, a), (b, b))
    assert {tuple(sorted(edge)) for edge in unpaired_edges(faces).tolist()} == {(min(a, b), max(a, b))}
    assert pinched_vertices(faces).tolist() == sorted((a, b))


def test_no_triangles_have_no_edges() -> None:
    none = np.zeros((0, 3), np.int64)
    assert len(unpaired_edges(none)) == 0
    assert len(pinched_vertices(none)) == 0


def test_a_triangle_with_a_common_corner_is_pierced_by_the_edge_across_from_it() -> None:
    points = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0.5, 0.5, -1), (0.5, 0.5, 1), (9, 9, 9)], np.float64)
    faces = np.array([(0, 1, 2), (0, 3, 4), (1, 2, 5)])
    assert list(intersections(points, faces)) == []
    for chosen in ([True, False, False], [False, True, False], [True, True, True]):
        found = piercings(points, faces, np.array(chosen))
        assert {tuple(sorted(pair)) for pair in found.tolist()} == {(0, 1)}
    assert len(piercings(points, faces, np.array([False, False, True]))) == 0
