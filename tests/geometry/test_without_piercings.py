"""Short edges go unless triangles would come to pass through others: a needle reaches into a pit with a short edge."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.short_edges import collapse_short_edges
from lappet.geometry.without_piercings import unchanged, without_piercings
from self_intersection import passes_through_itself

LEFT, RIGHT = (0.0, 0.0, 0.0), (0.004, 0.0, 0.0)  # the ends of the short edge at the ground of the pit
PIT = [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1), LEFT, RIGHT, (0, 0, -1)]
PIT_FACES = [
    (0, 1, 5), (0, 5, 4), (1, 2, 5), (2, 3, 4), (2, 4, 5), (3, 0, 4),
    (1, 0, 6), (2, 1, 6), (3, 2, 6), (0, 3, 6),
]  # fmt: skip
TETRAHEDRON = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])


def pit_with_needle(x: float, z: float) -> Surface:
    """Two bodies: one with a pit, and one whose tip lies in it, beside nothing but the walls of the pit."""
    needle = [(x, 0.0, z), (x + 0.1, 0.0, 2.0), (x, 0.1, 2.0), (x - 0.1, -0.1, 2.0)]
    triangles = np.concatenate([PIT_FACES, TETRAHEDRON + len(PIT)]).astype(np.int32)
    none = np.zeros(len(triangles), bool)
    return Surface(
        points=np.array([*PIT, *needle], np.float64),
        triangles=triangles,
        uv=np.zeros((len(triangles), 3, 2), np.float32),
        origin=np.full(len(triangles), FaceOrigin.SKIN, np.uint8),
        fixed=none,
        bed=none,
    )


@pytest.mark.parametrize(
    ("x", "z", "stays"),
    [
        pytest.param(0.002, 0.5, [RIGHT], id="high above"),
        pytest.param(0.0002, 0.001, [LEFT], id="where the left end would be buried"),
        pytest.param(0.002, 0.0015, [LEFT, RIGHT], id="where either end would be"),
    ],
)
def test_an_edge_shrinks_to_the_end_that_buries_nothing(
    x: float, z: float, stays: list[tuple[float, float, float]]
) -> None:
    surface = pit_with_needle(x, z)
    assert not passes_through_itself(surface.points, surface.triangles)
    made = without_piercings(lambda left_out: collapse_short_edges(surface, 0.005, left_out))
    assert not passes_through_itself(made.points, made.triangles)
    left = {tuple(point) for point in made.points.tolist()}
    assert [end for end in (LEFT, RIGHT) if end in left] == stays


def test_a_change_without_steps_is_the_surface_itself() -> None:
    surface = pit_with_needle(0.002, 0.5)
    assert without_piercings(lambda _: unchanged(surface)) is surface
