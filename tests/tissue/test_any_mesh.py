"""What people have becomes tissue: solids that are cropped, fins, shared edges, quads, inner walls, loose hair."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from face_meshes import ala, nose, shell
from lappet.geometry.surface_check import signed_volume
from lappet.tissue import Box, Disc, Sphere, new_tissue, tissue_of_mesh
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.surface import tissue_surface
from surface_measures import assert_closed, volume

HALF_BALL = 2.0 / 3.0 * np.pi * 60.0**3


def joined(*meshes: trimesh.Trimesh) -> Mesh:
    both = trimesh.util.concatenate(meshes)
    return Mesh(np.asarray(both.vertices, np.float64), np.asarray(both.faces, np.int64))


def test_a_solid_is_cropped_to_a_box_and_held_where_it_is_cut_off() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=60.0)
    tissue, report = tissue_of_mesh(joined(ball), region=Box((-70.0, -70.0, 0.0), (70.0, 70.0, 70.0)))
    surface = tissue_surface(tissue)
    assert_closed(surface)
    assert volume(surface) == pytest.approx(HALF_BALL, rel=5e-3)
    held = surface.points[surface.triangles[surface.fixed]]
    assert np.abs(held[:, :, 2]).max() < 1e-4
    corners = np.cross(held[:, 1] - held[:, 0], held[:, 2] - held[:, 0])
    assert 0.5 * np.linalg.norm(corners, axis=1).sum() == pytest.approx(np.pi * 60.0**2, rel=5e-3)
    assert "held where it was cut off" in report["region"]


def test_a_cropped_shell_keeps_both_of_its_walls() -> None:
    tissue, _ = tissue_of_mesh(shell(60.0, 50.0), region=Sphere((0.0, 0.0, 60.0), 25.0))
    surface = tissue_surface(tissue)
    assert_closed(surface)
    free = np.linalg.norm(surface.points[np.unique(surface.triangles[~surface.fixed])], axis=1)
    assert np.minimum(np.abs(free - 60.0), np.abs(free - 50.0)).max() < 0.1
    assert (free < 50.1).any()
    assert (free > 59.9).any()


def test_the_sides_of_a_nostril_s_wall_stay_apart_where_the_solid_is_cropped() -> None:
    tissue, _ = tissue_of_mesh(ala(thickness=1.0), region=Sphere((0.0, 0.0, 9.5), 5.0))
    surface = tissue_surface(tissue)
    assert_closed(surface)
    spherical_cap = np.pi * 5.0**2
    assert volume(surface) == pytest.approx(spherical_cap * 1.0, rel=0.1)


def test_the_texture_of_a_cropped_solid_stays_where_it_was() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=60.0)
    faces = np.asarray(ball.faces, np.int64)
    corner = np.asarray(ball.vertices)[faces]
    mesh = Mesh(np.asarray(ball.vertices), faces, 0.01 * corner[:, :, :2])
    tissue, _ = tissue_of_mesh(mesh, region=Sphere((0.0, 0.0, 60.0), 25.0))
    uv = tissue.uv.reshape(-1, 3, 2)
    place = tissue.points[tissue.face_vertex_indices.reshape(-1, 3)][:, :, :2]
    assert uv == pytest.approx(0.01 * place, abs=1e-4)


def test_a_block_of_a_few_quads_stays_a_block_when_it_is_refined() -> None:
    block = trimesh.creation.box((80.0, 60.0, 40.0))
    tissue, report = tissue_of_mesh(joined(block), 3.0, Box((-50.0, -20.0, -30.0), (10.0, 20.0, 30.0)), resolution=2.0)
    away = np.abs(tissue.points) - (40.0, 30.0, 20.0)
    assert away.max() == pytest.approx(0.0, abs=1e-5)
    skin = np.setdiff1d(np.arange(len(tissue.face_vertex_counts)), np.concatenate([*tissue.subsets.values()]))
    corners = tissue.points[tissue.face_vertex_indices.reshape(-1, 3)[skin]]
    assert (np.abs(corners) - (40.0, 30.0, 20.0)).max(axis=2) == pytest.approx(np.zeros(corners.shape[:2]), abs=1e-5)
    assert "0 mm off" in report["refinement"]


def test_a_fin_on_a_solid_is_taken_off() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=60.0)
    a, b = ball.faces[0][:2]
    points = np.concatenate([ball.vertices, [1.3 * ball.vertices[a]]])
    faces = np.concatenate([ball.faces, [[a, b, len(ball.vertices)]]]).astype(np.int64)
    tissue, report = tissue_of_mesh(Mesh(points, faces))
    assert volume(tissue_surface(tissue)) == pytest.approx(ball.volume, rel=1e-5)
    assert report["non-manifold edges"].startswith("1 of more than two faces")
    assert "left out" in report["open parts"]


def test_two_blocks_that_share_an_edge_are_taken_apart_there() -> None:
    one, two = trimesh.creation.box((30.0, 30.0, 30.0)), trimesh.creation.box((30.0, 30.0, 30.0))
    two.apply_translation([30.0, 30.0, 0.0])
    tissue, report = tissue_of_mesh(joined(one, two))
    assert signed_volume(tissue.points, tissue.face_vertex_indices.reshape(-1, 3)) == pytest.approx(2 * 27_000.0)
    assert "non-manifold edges" in report


def test_hair_and_an_inner_shell_do_not_disturb_a_field_of_the_skin() -> None:
    head = shell(60.0, 50.0)
    rng = np.random.default_rng(3)
    roots = 60.0 * trimesh.unitize(rng.standard_normal((300, 3)))
    hair = np.stack([roots, roots * 1.2, roots * 1.2 + rng.normal(0.0, 0.5, (300, 3))], axis=1).reshape(-1, 3)
    mesh = Mesh(
        np.concatenate([head.points, hair]),
        np.concatenate([head.triangles, len(head.points) + np.arange(900).reshape(-1, 3)]),
    )
    tissue, report = tissue_of_mesh(mesh, 3.0, Disc((0.0, 0.0, 60.0), 20.0))
    radius = np.linalg.norm(tissue.points, axis=1)
    assert radius.max() == pytest.approx(60.0, abs=0.05)
    assert radius.min() == pytest.approx(57.0, abs=0.1)
    assert report["separate parts"] == "302, of which 2 are closed"


def test_quads_with_an_inner_wall_become_a_hollow_solid(tmp_path: Path) -> None:
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    lines = [f"v {x} {y} {z}" for x, y, z in np.concatenate([40.0 * corners, 30.0 * corners])]
    lines += ["f " + " ".join(str(k + 1) for k in quad) for quad in [*quads, *(quads + 8)]]
    file = tmp_path / "hollow.obj"
    file.write_text("\n".join(lines))
    tissue, report = new_tissue(file, units="mm")
    hollow = signed_volume(tissue.points, tissue.face_vertex_indices.reshape(-1, 3))
    assert hollow in (pytest.approx(80.0**3 - 60.0**3), pytest.approx(80.0**3 + 60.0**3))
    assert report["polygons"].startswith("12 quads")


def test_a_face_of_200_000_triangles_is_taken_in_seconds() -> None:
    mesh = nose(spacing=0.25)
    assert len(mesh.triangles) > 200_000
    tissue, _ = tissue_of_mesh(mesh, 3.0, Disc((0.0, -8.0, 15.0), 12.0))
    assert_closed(tissue_surface(tissue))
