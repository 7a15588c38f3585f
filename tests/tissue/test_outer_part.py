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
    (line,) = [each for each in lines.lines if "taken: part" in each]
    assert f"{cap_area(OUTER):.0f}"[:2] in line
    assert "of 2 the one that faces outwards nearest to the region's center" in line


def test_of_two_parts_that_face_outwards_the_nearer_one_is_taken(tmp_path: Path) -> None:
    near, far = (trimesh.creation.icosphere(subdivisions=4, radius=radius) for radius in (10.0, 14.0))
    far.apply_translation([0.0, 0.0, 40.0])
    file = tmp_path / "two.stl"
    trimesh.util.concatenate([near, far]).export(file)
    tissue, _ = new_tissue(file, thickness=1.0, sphere=((0.0, 0.0, 16.0), 14.0), units="mm")
    assert tissue.points[:, 2].max() == pytest.approx(10.0, rel=1e-2)


def _balls(*radii_and_turns: tuple[float, bool]) -> trimesh.Trimesh:
    """Balls around one place; those that are turned face inwards."""
    balls = [trimesh.creation.icosphere(subdivisions=4, radius=radius) for radius, _ in radii_and_turns]
    for ball, (_, turned) in zip(balls, radii_and_turns, strict=True):
        if turned:
            ball.invert()
    return trimesh.util.concatenate(balls)


@pytest.mark.parametrize(
    ("balls", "radii_of_tissue", "said"),
    [
        (((50.0, False), (45.0, True)), ((50.0, 1), (45.0, -1)), "with 1 cavity"),
        (((50.0, True), (45.0, False)), ((50.0, 1), (45.0, -1)), "with 1 cavity"),
        (((45.0, True), (50.0, False), (30.0, False)), ((50.0, 1), (45.0, -1), (30.0, 1)), "with 1 cavity"),
        (((50.0, False), (45.0, False)), ((50.0, 1), (45.0, 1)), None),
        (((50.0, True), (45.0, True)), ((50.0, 1), (45.0, 1)), None),
    ],
    ids=["a wall", "a wall, all turned", "a ball in a hollow one", "two solids", "two solids, all turned"],
)
def test_a_part_that_is_turned_against_the_one_around_it_bounds_a_cavity(
    tmp_path: Path,
    balls: tuple[tuple[float, bool], ...],
    radii_of_tissue: tuple[tuple[float, int], ...],
    said: str | None,
) -> None:
    file = tmp_path / "balls.stl"
    _balls(*balls).export(file)
    tissue, lines = new_tissue(file, units="mm")
    triangles = tissue.face_vertex_indices.reshape(-1, 3)
    volume = trimesh.Trimesh(tissue.points, triangles, process=False).volume
    assert volume == pytest.approx(4 / 3 * np.pi * sum(sign * radius**3 for radius, sign in radii_of_tissue), rel=0.01)
    assert (
        [said in line for line in lines.lines if "tissue: closed" in line] == [True]
        if said
        else "cavit" not in str(lines)
    )
