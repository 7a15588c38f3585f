"""Of a head with inner walls the skin is taken, not the wall behind it, however large or near that is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from lappet.tissue import new_tissue

OUTER, INNER, CENTER, RADIUS = 50.0, 45.0, (0.0, 0.0, 42.0), 20.0


def cap_area(ball: float) -> float:
    """Area of the part of a ball around the origin inside a sphere of `RADIUS` around `CENTER`."""
    away = CENTER[2]
    return float(np.pi * ball * (RADIUS**2 - (away - ball) ** 2) / away)


@pytest.fixture(params=[True, False], ids=["walls of one solid", "two skins"])
def hollow_head(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    outer, inner = (trimesh.creation.icosphere(subdivisions=5, radius=radius) for radius in (OUTER, INNER))
    if request.param:
        inner.invert()
    file = tmp_path / "head.stl"
    trimesh.util.concatenate([outer, inner]).export(file)
    return file


def test_the_outer_wall_is_taken_though_the_inner_one_is_larger_and_nearer(hollow_head: Path) -> None:
    assert cap_area(INNER) > cap_area(OUTER)
    assert abs(CENTER[2] - INNER) < abs(CENTER[2] - OUTER)
    tissue, lines = new_tissue(hollow_head, thickness=2.0, sphere=(CENTER, RADIUS), units="mm")
    assert np.linalg.norm(tissue.points, axis=1).max() == pytest.approx(OUTER, rel=1e-3)
    (line,) = [each for each in lines if "separate parts" in each]
    assert f"{cap_area(OUTER):.0f}"[:2] in line
    assert "of 2 separate parts in the region kept the one that faces outwards nearest to its center" in line


def test_of_two_parts_that_face_outwards_the_nearer_one_is_taken(tmp_path: Path) -> None:
    near, far = (trimesh.creation.icosphere(subdivisions=4, radius=radius) for radius in (10.0, 14.0))
    far.apply_translation([0.0, 0.0, 40.0])
    file = tmp_path / "two.stl"
    trimesh.util.concatenate([near, far]).export(file)
    tissue, _ = new_tissue(file, thickness=1.0, sphere=((0.0, 0.0, 16.0), 14.0), units="mm")
    assert tissue.points[:, 2].max() == pytest.approx(10.0, rel=1e-2)
