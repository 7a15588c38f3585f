"""A field inside an outline that was drawn on the skin."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from face_meshes import grid_triangles, nose
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops
from lappet.geometry.closest_point import closest_points
from lappet.geometry.triangles import areas
from lappet.tissue import Outline, tissue_of_mesh
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.outline_file import read_outline
from lappet.tissue.surface import tissue_surface
from lappet.tissue.surgical_field import surgical_field
from refusals import refuses
from surface_measures import assert_closed


def test_on_a_flat_skin_the_field_is_the_polygon() -> None:
    at = np.arange(-30.0, 30.1, 2.0)
    x, y = (each.ravel() for each in np.meshgrid(at, at))
    skin = Mesh(np.stack([x, y, np.zeros_like(x)], 1), grid_triangles(len(at), len(at)))
    corners = [(-15.0, -10.0, 1.0), (15.0, -10.0, 0.0), (12.0, 9.0, -1.0), (0.0, 3.0, 0.0), (-12.0, 9.0, 0.0)]
    field, _ = surgical_field(skin, Outline(corners), 1.0, "skin")
    x, y = np.array(corners)[:, :2].T
    polygon = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert areas(field.points[field.triangles]).sum() == pytest.approx(polygon, rel=0.02)


@pytest.mark.parametrize("way_round", [1, -1])
def test_an_outline_around_a_nose_takes_the_nose_and_ends_at_the_outline(way_round: int) -> None:
    mesh = nose()
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)[::way_round]
    drawn = np.stack([16.0 * np.cos(turn), -4.0 + 18.0 * np.sin(turn), np.full(24, 3.0)], axis=1)
    drawn = closest_points(drawn, mesh.points, mesh.triangles)[1]
    field, notes = surgical_field(mesh, Outline(drawn.tolist()), 1.5, "nose")
    assert field.points[:, 2].max() == pytest.approx(mesh.points[:, 2].max(), abs=0.3)
    (loop,) = border_loops(field.triangles)
    rim = field.points[loop]
    from_outline = np.linalg.norm(rim[:, None] - drawn[None], axis=2)
    apart = np.linalg.norm(np.roll(drawn, -1, axis=0) - drawn, axis=1).max()
    assert from_outline.min(axis=1).max() < 0.6 * apart
    assert from_outline.min(axis=0).max() < 1.0
    assert "24 points" in notes[0].value


def test_tissue_is_made_of_what_an_outline_encloses() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=60.0)
    turn = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    drawn = 60.0 * np.stack([np.sin(0.4) * np.cos(turn), np.sin(0.4) * np.sin(turn), np.full(36, np.cos(0.4))], axis=1)
    mesh = Mesh(np.asarray(ball.vertices), np.asarray(ball.faces, np.int64))
    tissue, _ = tissue_of_mesh(mesh, 4.0, Outline(drawn.tolist()), resolution=2.0)
    surface = tissue_surface(tissue)
    assert_closed(surface)
    skin = surface.points[surface.triangles[surface.origin == 0]]
    assert areas(skin).sum() == pytest.approx(2.0 * np.pi * 60.0**2 * (1.0 - np.cos(0.4)), rel=0.02)


def test_an_outline_that_crosses_itself_or_lies_off_the_skin_is_refused() -> None:
    mesh = nose()
    eight = [(-20.0, 25.0, -5.0), (20.0, 30.0, -5.0), (-20.0, 35.0, -5.0), (20.0, 25.0, -5.0)]
    with refuses(ProblemCode.OUTLINE_CROSSES_ITSELF):
        surgical_field(mesh, Outline(eight), 2.0, "nose")
    with refuses(ProblemCode.REGION_POINT_OFF_SURFACE):
        surgical_field(mesh, Outline([(x, y, z + 60.0) for x, y, z in eight]), 2.0, "nose")


@pytest.mark.parametrize("text", ["", "{}", "[[1, 2, 3]]", '[["a", 1, 2]]', "[[0,0,0],[1,0,0],[1,1]]", "[" * 100_000])
def test_a_file_without_an_outline_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "outline.json"
    file.write_text(text)
    with refuses(ProblemCode.OUTLINE_NO_POINTS):
        read_outline(file)


def test_an_outline_is_read_as_it_was_written(tmp_path: Path) -> None:
    points = [[0.0, 0.0, 1.5], [10.0, 0.0, 1.0], [10.0, 8.0, 0.0]]
    file = tmp_path / "outline.json"
    file.write_text(json.dumps(points))
    assert read_outline(file) == Outline(tuple(tuple(each) for each in points))
