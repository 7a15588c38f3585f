"""A .usdz is what augmented reality plays, and USD's own skinning puts its vertices where the cache has them."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade, UsdSkel, UsdValidation

import synthetic_skin_cache as synthetic
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export import usdz_file
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.geometry.closest_point import ClosestPoint
from model_players import places, played, player_site

TOLERANCE = 0.5  # mm
STANDING = np.array([0.0, 0.0, synthetic.THICKNESS])  # from the cache to the table, mm
BODY = "/Operation/Body"
EPOCHS = ("epoch_00", "epoch_01")


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("usdz"), step=4.0))


@pytest.fixture(scope="module")
def told() -> list[Problem]:
    return []


@pytest.fixture(scope="module")
def usdz(cache: SkinCache, told: list[Problem]) -> Path:
    target = cache.path.with_name("skin.usdz")
    (path,) = export(ExportRequest((cache.path,), target, {"pause": 0.0}, note=told.append))
    return path


def skinned(stage: Usd.Stage, name: str, time: float) -> np.ndarray:
    """A mesh's vertices at a time as USD skins them, in mm with Z up."""
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(stage.GetPrimAtPath(BODY)), Usd.PrimDefaultPredicate)
    skeleton = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(f"{BODY}/Skeleton")))
    mesh = stage.GetPrimAtPath(f"{BODY}/{name}")
    points = UsdGeom.Mesh(mesh).GetPointsAttr().Get()
    cache.GetSkinningQuery(mesh).ComputeSkinnedPoints(skeleton.ComputeSkinningTransforms(time), points, time)
    x, y, z = np.asarray(points, float).T * 1000.0
    return np.stack([x, -z, y], axis=1)


def both_ways(a: np.ndarray, b: np.ndarray) -> float:
    """The greatest distance from a point of either set to the nearest of the other."""
    worst = 0.0
    for one, other in ((a, b), (b, a)):
        every = np.arange(len(other))
        worst = max(worst, float(ClosestPoint(other.astype(float), np.stack([every] * 3, 1)).query(one)[2].max()))
    return worst


def test_no_validator_finds_anything_in_the_package(usdz: Path) -> None:
    stage = Usd.Stage.Open(str(usdz))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert {"UsdzPackageValidator", "RootPackageValidator", "SkelBindingApiValidator"} <= {
        each.GetMetadata().name.rpartition(":")[2] for each in validators
    }
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_the_package_is_as_the_format_asks(usdz: Path) -> None:
    with zipfile.ZipFile(usdz) as package:
        entries = package.infolist()
        assert {each.compress_type for each in entries} == {zipfile.ZIP_STORED}
        assert entries[0].filename.endswith(".usdc")
        assert {Path(each.filename).suffix for each in entries} == {".usdc", ".png"}
        for each in entries:
            assert (each.header_offset + 30 + len(each.filename) + extra_length(usdz, each)) % 64 == 0
    assert usdz.stat().st_size < 10e6


def extra_length(path: Path, entry: zipfile.ZipInfo) -> int:
    with path.open("rb") as file:
        file.seek(entry.header_offset + 28)
        return int.from_bytes(file.read(2), "little")


def test_it_stands_on_a_table_at_real_size(usdz: Path, cache: SkinCache) -> None:
    stage = Usd.Stage.Open(str(usdz))
    assert (UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)) == (1.0, "Y")
    assert stage.GetDefaultPrim().GetPath() == "/Operation"
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, cache.frames[-1] - cache.frames[0])
    points = skinned(stage, "epoch_00", 0.0)
    assert points.min(axis=0) == pytest.approx([-50.0, -40.0, 0.0], abs=1e-3)
    assert points.max(axis=0) == pytest.approx([50.0, 40.0, synthetic.THICKNESS], abs=1e-3)


def test_every_frame_shows_its_epoch_where_it_was_solved_and_the_other_nearly_as_a_point(
    usdz: Path, cache: SkinCache
) -> None:
    stage = Usd.Stage.Open(str(usdz))
    for time in cache.frames:
        epoch = cache.epoch_at(time)
        for name in EPOCHS:
            points = skinned(stage, name, time - cache.frames[0])
            if name == epoch.name:
                solved = cache.positions(epoch, time) + STANDING
                assert both_ways(points, solved) < TOLERANCE
            else:
                assert np.ptp(points, axis=0).max() < 0.1


def test_an_epoch_appears_at_once_and_not_by_growing(usdz: Path, cache: SkinCache) -> None:
    stage = Usd.Stage.Open(str(usdz))
    appears = synthetic.INCISED - cache.frames[0]
    sizes = [np.ptp(skinned(stage, "epoch_01", appears - early), axis=0).max() for early in (0.5, 0.02, 0.0)]
    assert [round(each) for each in sizes] == [0, 0, 100]


_IMPORT = """
import sys
import bpy
import numpy as np

usdz, out, last = sys.argv[1], sys.argv[2], int(sys.argv[3])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=usdz)
seen = {}
for time in range(last + 1):
    bpy.context.scene.frame_set(time)
    graph = bpy.context.evaluated_depsgraph_get()
    for each in bpy.context.scene.objects:
        if each.type == "MESH":
            own = each.evaluated_get(graph)
            mesh = own.to_mesh()
            points = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", points)
            matrix = np.array(own.matrix_world)
            seen[f"{each.name} {time}"] = (points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]) * 1000.0
            own.to_mesh_clear()
np.savez(out, **seen)
"""


@pytest.mark.slow
def test_blender_shows_every_frame_where_it_was_solved(usdz: Path, cache: SkinCache, tmp_path: Path) -> None:
    pytest.importorskip("bpy")
    last = round(cache.frames[-1] - cache.frames[0])
    command = [sys.executable, "-c", _IMPORT, str(usdz), str(tmp_path / "seen.npz"), str(last)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    assert "WARNING" not in done.stdout + done.stderr
    seen = np.load(tmp_path / "seen.npz")
    for time in cache.frames:
        epoch, frame = cache.epoch_at(time), round(time - cache.frames[0])
        (hidden,) = {*EPOCHS} - {epoch.name}
        assert both_ways(seen[f"{epoch.name} {frame}"], cache.positions(epoch, time) + STANDING) < TOLERANCE
        assert np.ptp(seen[f"{hidden} {frame}"], axis=0).max() < 0.1


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_loader_of_three_plays_every_frame_where_it_was_solved_with_its_picture(
    usdz: Path, cache: SkinCache, tmp_path: Path
) -> None:
    site = player_site(tmp_path, "usd", usdz)
    poses = [("Motion", (time - cache.frames[0]) / cache.fps) for time in cache.frames]
    done = played(site, "usd", usdz, poses, ("evaluate", "players.draw()"))
    assert (done.results[0], done.console) == (["Motion"], [])
    for time, shown in zip(cache.frames, done.results[1:-1], strict=True):
        epoch = cache.epoch_at(time)
        (hidden,) = {*EPOCHS} - {epoch.name}
        assert both_ways(places(shown[epoch.name]), cache.positions(epoch, time) + STANDING) < TOLERANCE
        assert hidden not in shown or np.ptp(places(shown[hidden]), axis=0).max() < 0.1
        assert any(each["picture"] for each in shown[epoch.name])
    drawn = done.results[-1]
    red, green, blue = drawn["mean"]
    assert drawn["fault"] == 0
    assert red > 1.1 * green > 1.1 * blue > 60.0  # skin, lit


def test_weights_are_four_at_most_none_negative_and_together_one(usdz: Path) -> None:
    stage = Usd.Stage.Open(str(usdz))
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    assert {each.GetName() for each in meshes} == {*EPOCHS, "bed", "threads", "hooks"}
    for mesh in meshes:
        binding = UsdSkel.BindingAPI(mesh)
        weights = np.array(binding.GetJointWeightsPrimvar().Get()).reshape(-1, 4)
        bones = np.array(binding.GetJointIndicesPrimvar().Get())
        assert weights.min() >= 0.0
        assert np.abs(weights.sum(axis=1) - 1.0).max() < 1e-5
        assert 0 <= bones.min() <= bones.max() < len(binding.GetJointsAttr().Get())


def test_skin_has_a_picture_and_the_wound_its_colors(usdz: Path) -> None:
    stage = Usd.Stage.Open(str(usdz))
    sources = {}
    for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Mesh(stage.GetPrimAtPath(f"{BODY}/epoch_01"))):
        material = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
        color = material.ComputeSurfaceSource()[0].GetInput("diffuseColor")
        sources[subset.GetPrim().GetName()] = color.HasConnectedSource()
    assert sources.pop("Skin")
    assert sources
    assert not any(sources.values())


def test_the_error_that_is_told_is_that_of_the_file(usdz: Path, told: list[Problem], cache: SkinCache) -> None:
    (said,) = [each for each in told if each.code == ProblemCode.EXPORT_BONES_ERROR]
    stage = Usd.Stage.Open(str(usdz))
    worst = max(
        both_ways(
            skinned(stage, cache.epoch_at(time).name, time - cache.frames[0]),
            cache.positions(cache.epoch_at(time), time) + STANDING,
        )
        for time in cache.frames
    )
    # The nearest vertex may be another one than its own.
    assert worst - 1e-3 <= float(said.value) < TOLERANCE


def test_a_pause_holds_each_step_and_the_last_frame(cache: SkinCache, tmp_path: Path) -> None:
    chosen = (cache.frames[0], cache.frames[3], cache.frames[-1])
    options = {"frames": chosen, "pause": 2.0, "instruments": False}
    (path,) = export(ExportRequest((cache.path,), tmp_path / "held.usdz", options))
    stage = Usd.Stage.Open(str(path))
    assert stage.GetEndTimeCode() >= chosen[-1] - chosen[0] + 2.0 * cache.fps
    last = stage.GetEndTimeCode()
    held = [skinned(stage, "epoch_01", time) for time in (last - 2.0 * cache.fps, last - 1.0, last)]
    assert np.array_equal(held[0], held[1])
    assert np.array_equal(held[0], held[2])
    assert not stage.GetPrimAtPath(f"{BODY}/threads")


def refusal(cache: SkinCache, folder: Path, **options: object) -> Problem:
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache.path,), folder / "no.usdz", options))
    assert list(folder.iterdir()) == []
    (problem,) = refused.value.problems
    return problem


def test_bones_that_do_not_suffice_are_refused_with_what_they_reach(cache: SkinCache, tmp_path: Path) -> None:
    problem = refusal(cache, tmp_path, bones=1, tolerance_mm=0.1)
    assert problem.code == ProblemCode.EXPORT_BONES
    assert problem.value == "1"
    assert " mm away" in problem.message


def test_a_skin_too_large_is_refused_before_any_bone_with_the_spacing_that_would_fit(
    cache: SkinCache, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usdz_file, "MOST_VERTICES", 500)
    monkeypatch.setattr(usdz_file, "skinned_surface", None)
    problem = refusal(cache, tmp_path)
    assert problem.code == ProblemCode.EXPORT_AR_SIZE
    count = sum(len(np.unique(epoch.triangles)) for epoch in cache.epochs)
    assert f"{(count / 500) ** 0.5:.1f} times" in problem.remedy


def test_a_cache_without_its_procedure_is_refused(tmp_path: Path) -> None:
    cache = synthetic.write_cache(tmp_path, step=8.0)
    (tmp_path / "procedure.usda").unlink()
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache,), tmp_path / "skin.usdz"))
    assert {each.code for each in refused.value.problems} == {ProblemCode.USD_COMPOSITION}
    assert not (tmp_path / "skin.usdz").exists()
