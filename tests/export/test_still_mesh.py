"""Meshes of one frame: millimetres, closed, colored, and read by others."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

import synthetic_skin_cache as synthetic
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_fields import SKIN, UNDERSIDE
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.surface_look import SKIN_LOOK
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.export.still_mesh import open_edges
from lappet.output.named_steps import operation_steps


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("still"), step=2.0))


def written(cache: SkinCache, path: Path, **options: object) -> list[Path]:
    return export(ExportRequest((cache.path,), path, options))


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
def test_trimesh_reads_a_closed_mesh_with_the_points_of_the_frame(
    cache: SkinCache, tmp_path: Path, suffix: str
) -> None:
    time = float(synthetic.LIFTED)
    (path,) = written(cache, tmp_path / f"flap.{suffix}", frames=[time])
    read = trimesh.load_mesh(path)
    epoch = cache.epoch_at(time)
    points = cache.positions(epoch, time)
    assert read.is_watertight
    corners = np.asarray(read.vertices)[read.faces]
    assert np.abs(corners - points[epoch.triangles]).max() < 1e-4
    own = trimesh.Trimesh(points, epoch.triangles, process=False)
    assert read.volume == pytest.approx(own.volume, rel=1e-5)


def test_a_ply_has_the_color_of_each_face_and_an_obj_those_of_its_vertices(cache: SkinCache, tmp_path: Path) -> None:
    epoch = cache.epoch_at(cache.frames[-1])
    (ply,) = written(cache, tmp_path / "flap.ply")
    colors = np.asarray(trimesh.load_mesh(ply, process=False).visual.face_colors)[:, :3]
    assert (colors[epoch.origin == SKIN] == SKIN_LOOK.display_color).all()
    assert not (colors[epoch.origin == UNDERSIDE] == SKIN_LOOK.display_color).all(axis=1).any()
    (obj,) = written(cache, tmp_path / "flap.obj")
    rows = [line.split() for line in obj.read_text().splitlines() if line.startswith("v ")]
    inside = np.setdiff1d(epoch.triangles[epoch.origin == SKIN], epoch.triangles[epoch.origin != SKIN])
    shown = np.array([[float(each) for each in rows[k][4:7]] for k in inside])
    assert np.abs(255.0 * shown - SKIN_LOOK.display_color).max() < 0.51


def test_a_3mf_says_millimetres_and_has_a_material_for_each_face(cache: SkinCache, tmp_path: Path) -> None:
    (path,) = written(cache, tmp_path / "flap.3mf")
    archive = zipfile.ZipFile(io.BytesIO(path.read_bytes()))
    assert archive.testzip() is None
    assert {"[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"} == set(archive.namelist())
    model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    space = {"m": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    assert model.get("unit") == "millimeter"
    epoch = cache.epoch_at(cache.frames[-1])
    vertices = model.findall(".//m:vertex", space)
    points = np.array([[float(each.get(axis, "nan")) for axis in "xyz"] for each in vertices])
    assert np.abs(points - cache.positions(epoch, cache.frames[-1])).max() < 1e-3
    faces = model.findall(".//m:triangle", space)
    assert [[int(each.get(f"v{k}", "-1")) for k in (1, 2, 3)] for each in faces] == epoch.triangles.tolist()
    names = [each.get("name") for each in model.findall(".//m:base", space)]
    skin = {names[int(each.get("p1", "-1"))] for each, own in zip(faces, epoch.origin, strict=True) if own == SKIN}
    assert skin == {"Skin"}


def test_a_step_is_chosen_by_its_number_or_its_name(cache: SkinCache, tmp_path: Path) -> None:
    steps = operation_steps(cache)
    assert len(steps) > 2
    for number, step in enumerate(steps, start=1):
        (first,) = written(cache, tmp_path / f"n{number}.stl", step=str(number))
        (second,) = written(cache, tmp_path / f"s{number}.stl", step=step.caption.upper())
        (third,) = written(cache, tmp_path / f"f{number}.stl", frames=[step.frame])
        assert first.read_bytes() == second.read_bytes() == third.read_bytes()


def test_every_frame_is_a_file_with_its_number(cache: SkinCache, tmp_path: Path) -> None:
    paths = written(cache, tmp_path / "flap.stl", every_frame=True)
    assert [path.name for path in paths] == [f"flap_{time:04g}.stl" for time in cache.frames]
    assert sorted(tmp_path.iterdir()) == sorted(paths)


def test_what_cannot_be_chosen_is_refused_before_anything_is_written(cache: SkinCache, tmp_path: Path) -> None:
    for options, code in (
        ({"step": "sewn with gold"}, ProblemCode.EXPORT_STEP),
        ({"frames": [99.0]}, ProblemCode.EXPORT_FRAME),
        ({"frames": [1.0], "step": "1"}, ProblemCode.EXPORT_TWO_CHOICES),
    ):
        with pytest.raises(RefusedError) as refusal:
            written(cache, tmp_path / "flap.stl", **options)
        assert [each.code for each in refusal.value.problems] == [code]
    assert list(tmp_path.iterdir()) == []


def test_edges_that_join_no_second_triangle_are_counted() -> None:
    box = trimesh.creation.box()
    assert open_edges(np.asarray(box.faces, np.int32)) == 0
    assert open_edges(np.asarray(box.faces[1:], np.int32)) == 3
    turned = np.asarray(box.faces, np.int32).copy()
    turned[0] = turned[0, ::-1]
    assert open_edges(turned) > 0


def test_a_surface_that_is_not_closed_is_told(cache: SkinCache, tmp_path: Path) -> None:
    told: list[Problem] = []
    # In the last frame the lips lie at one place: an STL, which has no vertices, joins four triangles there.
    for suffix in (".stl", ".ply"):
        export(ExportRequest((cache.path,), tmp_path / f"flap{suffix}", note=told.append))
    assert [(each.code, each.severity) for each in told] == [(ProblemCode.EXPORT_OPEN_SURFACE, "warning")]
