"""How thick a sheet becomes: as wanted where there is room, less where the surface is curved, folded or has a wall."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from face_meshes import ala, fold, nose, roll, shell
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import first_intersection, signed_volume
from lappet.tissue import Disc, tissue_of_mesh
from lappet.tissue.inner_side import Surroundings
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.surgical_field import surgical_field
from lappet.tissue.thicken import Sheet, thicken
from refusals import refuses


def sheet_of(mesh: Mesh, thickness: float, around: Surroundings | None = None) -> Sheet:
    return thicken(mesh.points, mesh.triangles, thickness, 3, "skin", around)


def assert_whole(sheet: Sheet) -> None:
    """The sheet encloses a volume and passes nowhere through itself."""
    assert signed_volume(sheet.points, sheet.triangles) > 0.0
    assert first_intersection(sheet.points, sheet.triangles) is None


@pytest.mark.parametrize("noise", [0.0, 0.1], ids=["smooth", "scanned"])
@pytest.mark.parametrize("thickness", [3.0, 6.0, 9.0])
def test_a_nose_is_thickened_whatever_its_curvature(thickness: float, noise: float) -> None:
    mesh = nose(noise=noise)
    sheet = sheet_of(mesh, thickness)
    assert_whole(sheet)
    flat = np.abs(mesh.points[:, 0]) > 30.0
    assert sheet.depth[flat] == pytest.approx(np.full(flat.sum(), thickness))
    assert sheet.depth.min() > 0.02 * thickness


def test_below_a_roll_that_is_tighter_than_the_sheet_it_is_thinner_and_changes_slowly_from_there() -> None:
    mesh = roll(radius=4.0)
    sheet = sheet_of(mesh, 6.0)
    assert_whole(sheet)
    depth = sheet.depth
    flat, round_ = mesh.points[:, 0] > 14.0, mesh.points[:, 0] < -1.0
    assert depth[flat] == pytest.approx(np.full(flat.sum(), 6.0))
    assert depth[round_].max() < 4.5
    assert 1.5 < np.median(depth[round_]) < 4.0
    edges = np.concatenate([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]]])
    apart = np.linalg.norm(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]], axis=1)
    assert (np.abs(depth[edges[:, 0]] - depth[edges[:, 1]]) <= 1.0001 * apart).all()


def test_each_side_of_a_fold_takes_less_than_half_of_it() -> None:
    mesh = fold(gap=3.0)
    sheet = sheet_of(mesh, 4.0)
    assert_whole(sheet)
    inside = (mesh.points[:, 0] > 5.0) & (mesh.points[:, 0] < 10.0) & (np.abs(mesh.points[:, 1]) < 5.0)
    assert sheet.depth[inside] == pytest.approx(np.full(inside.sum(), 0.45 * 3.0), rel=0.02)


def test_the_underside_of_a_nose_s_side_is_the_lining_of_its_nostril_and_free() -> None:
    mesh = ala(thickness=3.0)
    tissue, report = tissue_of_mesh(mesh, 5.0, Disc((0.0, 0.0, 12.0), 8.0), resolution=1.0)
    radius = np.linalg.norm(tissue.points, axis=1)
    assert radius.min() == pytest.approx(9.0, abs=0.1)
    assert len(tissue.subsets["bed"]) == 0
    skin = np.setdiff1d(np.arange(len(tissue.face_vertex_counts)), np.concatenate([*tissue.subsets.values()]))
    assert len(tissue.subsets["lining"]) == len(skin)
    assert "lining" in report


def test_a_wall_that_is_not_connected_with_the_skin_ends_the_tissue_and_stays_a_bed() -> None:
    tissue, report = tissue_of_mesh(shell(60.0, 56.0), 8.0, Disc((0.0, 0.0, 60.0), 20.0), resolution=2.0)
    bed = tissue.points[tissue.face_vertex_indices.reshape(-1, 3)[tissue.subsets["bed"]]]
    assert np.linalg.norm(bed, axis=2) == pytest.approx(np.full(bed.shape[:2], 56.0), abs=0.3)
    assert "lining" not in report
    assert "less than 75% of what was wanted" in report["thickness"]


def test_without_a_thickness_a_sheet_goes_down_to_the_inner_wall_wherever_that_is() -> None:
    outer, inner = trimesh.creation.icosphere(5, 60.0), trimesh.creation.icosphere(5, 50.0)
    inner.invert()
    inner.apply_translation([3.0, 0.0, 0.0])
    both = trimesh.util.concatenate([outer, inner])
    mesh = Mesh(np.asarray(both.vertices), np.asarray(both.faces, np.int64))
    for way, thickness in (((1.0, 0.0, 0.0), 7.0), ((-1.0, 0.0, 0.0), 13.0)):
        middle = tuple(60.0 * x for x in way)
        tissue, _ = tissue_of_mesh(mesh, region=Disc(middle, 12.0))
        below = tissue.points[np.linalg.norm(tissue.points, axis=1) < 59.0]
        assert np.linalg.norm(below - (3.0, 0.0, 0.0), axis=1).min() == pytest.approx(50.0, abs=0.1)
        nearest = np.linalg.norm(tissue.points - middle, axis=1)
        n = len(tissue.subsets["bed"])
        assert n > 0
        assert np.sort(nearest[np.linalg.norm(tissue.points, axis=1) < 54.0])[0] == pytest.approx(thickness, abs=0.3)


def test_without_a_thickness_and_without_an_inner_side_a_field_is_refused() -> None:
    with refuses(ProblemCode.REGION_NO_INNER_SIDE) as problems:
        tissue_of_mesh(nose(), region=Disc((0.0, 0.0, 15.0), 10.0))
    assert problems[0].place is not None


def test_where_the_wall_is_further_than_the_thickness_the_thickness_is_as_wanted() -> None:
    tissue, report = tissue_of_mesh(shell(60.0, 50.0), 4.0, Disc((0.0, 0.0, 60.0), 20.0), resolution=2.0)
    assert np.linalg.norm(tissue.points, axis=1).min() == pytest.approx(56.0, abs=0.2)
    assert report["thickness"] == "4 mm"


def test_the_thickness_may_depend_on_the_place() -> None:
    mesh = nose()
    tissue, _ = tissue_of_mesh(mesh, lambda p: np.where(p[:, 1] > 0.0, 2.0, 4.0), Disc((30.0, 0.0, -3.0), 8.0))
    faces = tissue.face_vertex_indices.reshape(-1, 3)
    upper, lower = tissue.points[faces[0]], tissue.points[faces[tissue.subsets["bed"][0]]]
    assert upper.shape == lower.shape
    n = len(np.unique(faces[tissue.subsets["bed"]]))
    apart = np.linalg.norm(tissue.points[:n] - tissue.points[n : 2 * n], axis=1)
    back = tissue.points[:n, 1] > 2.5
    front = tissue.points[:n, 1] < -2.5
    assert apart[back] == pytest.approx(np.full(back.sum(), 2.0), rel=1e-3)
    assert apart[front] == pytest.approx(np.full(front.sum(), 4.0), rel=1e-3)


def test_a_field_s_area_is_that_of_the_disc_around_its_point() -> None:
    ball = Mesh(*(lambda m: (m.points[: len(m.points) // 2], m.triangles[: len(m.triangles) // 2]))(shell(60.0, 50.0)))
    field, notes = surgical_field(ball, Disc((0.0, 0.0, 59.0), 20.0), 2.0, "ball")
    corners = field.points[field.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    assert area == pytest.approx(2.0 * np.pi * 60.0**2 * (1.0 - np.cos(20.0 / 60.0)), rel=5e-3)
    assert "1 mm from the given point" in notes[0].value
