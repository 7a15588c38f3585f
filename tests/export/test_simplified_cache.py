"""A simplified skin has the triangles that were asked for, is closed, moves as the cache, and is as near as is said."""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

import synthetic_skin_cache as synthetic
from lappet.commands.cli import cli
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import ORIGINS
from lappet.export import simplified_cache, usdz_file
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.export.simplified_cache import fitting_triangles, simplified
from lappet.export.simplified_mesh import simplified_triangles, surface_distance
from lappet.export.simplify_target import SimplifyTarget
from lappet.export.still_mesh import open_edges

MOST = 500


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("simplified"), step=4.0))


@pytest.fixture(scope="module")
def told() -> list[Problem]:
    return []


@pytest.fixture(scope="module")
def simple(cache: SkinCache, told: list[Problem]) -> SkinCache:
    return simplified(cache, cache.frames, request(cache, told, triangles=MOST))


def request(cache: SkinCache, told: list[Problem], **target: float) -> ExportRequest:
    return ExportRequest((cache.path,), Path("x.glb"), {"simplify": SimplifyTarget(**target)}, note=told.append)  # type: ignore[arg-type]


def test_each_epoch_has_as_few_triangles_as_were_asked_for_and_is_closed(cache: SkinCache, simple: SkinCache) -> None:
    assert [each.name for each in simple.epochs] == [each.name for each in cache.epochs]
    for whole, epoch in zip(cache.epochs, simple.epochs, strict=True):
        assert open_edges(whole.triangles) == 0
        assert open_edges(epoch.triangles) == 0
        assert all(len(set(corners)) == 3 for corners in epoch.triangles.tolist())
        assert 0.9 * MOST <= len(epoch.triangles) <= MOST < len(whole.triangles)


def test_vertices_are_those_of_the_cache_in_every_frame(cache: SkinCache, simple: SkinCache) -> None:
    for whole, epoch in zip(cache.epochs, simple.epochs, strict=True):
        rest = {tuple(point): k for k, point in enumerate(cache.rest(whole).tolist())}
        own = np.array([rest[tuple(point)] for point in simple.rest(epoch).tolist()])
        assert epoch.frames == whole.frames
        for time in epoch.frames:
            assert np.array_equal(simple.positions(epoch, time), cache.positions(whole, time)[own])
            found, full = simple.scalar(epoch, "strain", time), cache.scalar(whole, "strain", time)
            assert found is not None
            assert full is not None
            assert np.array_equal(found, full[own])


def test_borders_between_skin_wall_underside_and_rim_stay_where_they_are(cache: SkinCache, simple: SkinCache) -> None:
    """The area of each is that of the cache, in the frame in which the wound gapes most."""
    time = float(synthetic.LIFTED)
    for label, name in enumerate(ORIGINS):
        areas = []
        for each in (cache, simple):
            epoch = each.epoch_at(time)
            corners = each.positions(epoch, time)[epoch.triangles[epoch.origin == label]].astype(np.float64)
            cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            areas.append(0.5 * np.linalg.norm(cross, axis=1).sum())
        assert areas[1] == pytest.approx(areas[0], rel=0.01), name


def test_texture_coordinates_follow_the_vertices(simple: SkinCache) -> None:
    size = np.array([synthetic.LENGTH, synthetic.WIDTH])
    for epoch in simple.epochs:
        assert epoch.st is not None
        place = epoch.st * size - size / 2
        skin = epoch.origin == 0
        first = simple.positions(epoch, epoch.frames[0])[epoch.triangles][:, :, :2]
        gape = 0.0 if epoch.name == "epoch_00" else synthetic.opening(epoch.frames[0])
        assert np.abs(place - first)[skin][..., 0].max() < 1e-4
        assert np.abs(place - first)[skin][..., 1].max() < gape + 1e-4


def test_the_distance_that_is_told_is_that_of_the_surfaces(
    cache: SkinCache, simple: SkinCache, told: list[Problem]
) -> None:
    """Measured again by many points on either surface and the nearest of those of the other, by trimesh and scipy."""
    from scipy.spatial import cKDTree

    (said,) = told
    assert said.code == ProblemCode.EXPORT_SIMPLIFIED
    time = float(synthetic.LIFTED)
    meshes = [
        trimesh.Trimesh(each.positions(each.epoch_at(time), time), each.epoch_at(time).triangles, process=False)
        for each in (cache, simple)
    ]
    dense = [trimesh.sample.sample_surface(mesh, 150_000, seed=1)[0] for mesh in meshes]
    vertices = meshes[0].vertices
    spacing = np.quantile(cKDTree(dense[1]).query(dense[1], k=2)[0][:, 1], 0.9)
    away = cKDTree(dense[1]).query(vertices)[0].max()
    assert 0.0 < float(said.value) < 0.5
    assert away < float(said.value) + 3.0 * spacing


def test_an_epoch_of_which_no_frame_is_shown_stays_whole(cache: SkinCache) -> None:
    told: list[Problem] = []
    found = simplified(cache, cache.frames[:1], request(cache, told, triangles=MOST))
    assert found.epochs[1].triangles is cache.epochs[1].triangles
    assert len(found.epochs[0].triangles) <= MOST
    assert float(told[0].value) < 1e-6  # the first epoch is flat


def test_a_bump_that_is_left_out_is_as_far_away_as_it_is_high() -> None:
    side = 4
    at = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    x, y = np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    points[at[2, 2], 2] = 0.3
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    flat = np.array([[at[0, 0], at[-1, 0], at[-1, -1]], [at[0, 0], at[-1, -1], at[0, -1]]])
    assert surface_distance(points, triangles, flat) == pytest.approx(0.3)
    assert surface_distance(points, triangles, triangles) == 0.0


def test_what_moves_keeps_vertices_where_it_bends_in_any_state() -> None:
    """A strip that is flat at rest and folds along its middle later: the fold stays, the rest may go."""
    count = 41
    x = np.linspace(0.0, 40.0, count)
    rest = np.concatenate([np.column_stack([x, np.full(count, y), 0 * x]) for y in (0.0, 5.0)])
    folded = rest.copy()
    folded[:, 2] = np.abs(folded[:, 0] - 20.0)
    a, b = np.arange(count - 1), np.arange(count - 1) + count
    triangles = np.concatenate([np.column_stack([a, a + 1, b + 1]), np.column_stack([a, b + 1, b])]).astype(np.int32)
    states = np.stack([rest, folded]).astype(np.float32)
    own = np.arange(2 * count)
    left = simplified_triangles(triangles, own, states, 0, 0.01)
    assert len(left) == 4
    assert set(states[0][np.unique(left)][:, 0]) == {0.0, 20.0, 40.0}
    flat = simplified_triangles(triangles, own, states[:1], 0, 0.01)
    assert set(states[0][np.unique(flat)][:, 0]) == {0.0, 40.0}


@pytest.mark.parametrize("most", [400, 100, 60, 40])
def test_a_thin_ring_is_not_pinched_where_its_triangles_do_not_suffice(most: int) -> None:
    """With 60 triangles meshoptimizer alone leaves six edges at which four triangles meet."""
    ring = trimesh.creation.torus(20.0, 1.0, major_sections=120, minor_sections=8)
    turned = ring.vertices * (1.0, 0.7, 1.0) + np.column_stack([0 * ring.vertices[:, :2], 0.1 * ring.vertices[:, :1]])
    states = np.stack([ring.vertices, turned]).astype(np.float32)
    left = simplified_triangles(ring.faces.astype(np.int32), np.arange(len(ring.vertices)), states, most, 1e9)
    found = trimesh.Trimesh(ring.vertices, left, process=False)
    assert open_edges(left) == 0
    assert found.euler_number == 0
    assert len(left) <= max(most, 300)


def test_an_error_is_kept_in_every_frame(cache: SkinCache) -> None:
    error = 0.2
    told: list[Problem] = []
    found = simplified(cache, cache.frames, request(cache, told, error_mm=error))
    assert float(told[0].value) <= error
    assert max(len(epoch.triangles) for epoch in found.epochs) < 0.7 * len(cache.epochs[1].triangles)
    for whole, epoch in zip(cache.epochs, found.epochs, strict=True):
        for time in epoch.frames:
            rest = {tuple(point): k for k, point in enumerate(cache.rest(whole).tolist())}
            own = np.array([rest[tuple(point)] for point in found.rest(epoch).tolist()])
            away = surface_distance(cache.positions(whole, time), whole.triangles, own[epoch.triangles])
            assert away <= error


def test_a_number_that_cannot_be_met_is_refused_with_the_least(cache: SkinCache, tmp_path: Path) -> None:
    asked = {"simplify": SimplifyTarget(triangles=1)}
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache.path,), tmp_path / "no.glb", asked))
    (problem,) = refused.value.problems
    assert problem.code == ProblemCode.EXPORT_SIMPLIFY
    assert list(tmp_path.iterdir()) == []
    least = int(problem.remedy.split("--simplify ")[1].split()[0])
    found = simplified(cache, cache.frames, ExportRequest((), tmp_path, {"simplify": SimplifyTarget(least)}))
    assert max(len(epoch.triangles) for epoch in found.epochs) <= least


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".3mf"])
def test_a_mesh_for_printing_is_closed_and_has_no_more_triangles(cache: SkinCache, tmp_path: Path, suffix: str) -> None:
    told: list[Problem] = []
    options = {"simplify": SimplifyTarget(MOST), "frames": [float(synthetic.LIFTED)]}
    (path,) = export(ExportRequest((cache.path,), tmp_path / f"skin{suffix}", options, note=told.append))
    if suffix == ".3mf":
        model = ElementTree.fromstring(zipfile.ZipFile(path).read("3D/3dmodel.model"))
        count = sum(1 for each in model.iter() if each.tag.endswith("}triangle"))
    else:
        read = trimesh.load_mesh(path)
        assert read.is_watertight
        count = len(read.faces)
    assert 0.9 * MOST < count <= MOST
    assert [each.code for each in told] == [ProblemCode.EXPORT_SIMPLIFIED]


def test_a_lesson_has_the_triangles_of_the_simplified_skin(cache: SkinCache, tmp_path: Path) -> None:
    options = {"simplify": SimplifyTarget(MOST), "frames": (1.0, 3.0, 12.0)}
    (path,) = export(ExportRequest((cache.path,), tmp_path / "skin.html", options))
    told = path.read_text(encoding="utf-8").split('id="lesson">')[1].split("</script>")[0]
    epochs = json.loads(told)["procedures"][0]["epochs"]
    assert [0.9 * MOST < sum(epoch["faces"]) <= MOST for epoch in epochs] == [True, True]


@pytest.mark.parametrize("suffix", [".glb", ".usdz"])
def test_a_moving_file_is_smaller_by_it(cache: SkinCache, tmp_path: Path, suffix: str) -> None:
    sizes = []
    for options in ({}, {"simplify": SimplifyTarget(MOST)}):
        chosen = {**options, "frames": (1.0, 3.0, 12.0)}
        (path,) = export(ExportRequest((cache.path,), tmp_path / f"skin{suffix}", chosen))
        sizes.append(path.stat().st_size)
    assert sizes[1] < 0.9 * sizes[0]  # the picture of the skin, bed and threads stay as they are


def test_a_skin_too_large_for_augmented_reality_fits_once_it_is_simplified_as_is_said(
    cache: SkinCache, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usdz_file, "MOST_VERTICES", 1000)
    monkeypatch.setattr(simplified_cache, "surface_distance", lambda *_: 0.0)
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache.path,), tmp_path / "skin.usdz", {"frames": (1.0, 7.0)}))
    (problem,) = refused.value.problems
    assert problem.code == ProblemCode.EXPORT_AR_SIZE
    fits = fitting_triangles(1000 / 2)
    assert f"--simplify {fits}" in problem.remedy
    options = {"frames": (1.0, 7.0), "simplify": SimplifyTarget(fits)}
    export(ExportRequest((cache.path,), tmp_path / "skin.usdz", options))


def test_what_is_asked_for_is_a_number_of_triangles_or_millimetres(cache: SkinCache, tmp_path: Path) -> None:
    assert SimplifyTarget.of("20000") == SimplifyTarget(triangles=20000)
    assert SimplifyTarget.of(" 0.2 mm") == SimplifyTarget(error_mm=0.2)
    for text in ("0.2", "12", "-5mm", "0mm", "much", "1e3", "200mm"):
        with pytest.raises(RefusedError) as refused:
            SimplifyTarget.of(text)
        assert refused.value.problems[0].code == ProblemCode.EXPORT_SIMPLIFY_TARGET
    arguments = ["export", str(cache.path), "-o", str(tmp_path / "x.stl"), "--simplify", "much"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 2
    assert "'much' is neither" in result.output


def test_without_the_package_a_sentence_says_how_to_get_it(
    cache: SkinCache, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "meshoptimizer", None)
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache.path,), tmp_path / "x.stl", {"simplify": SimplifyTarget(MOST)}))
    (problem,) = refused.value.problems
    assert problem.code == ProblemCode.EXPORT_NO_MESHOPT
    assert problem.prim == "--simplify"
