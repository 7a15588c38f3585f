"""A USD file of `lappet export` needs no other file, and is where the cache is."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade, UsdValidation

import synthetic_skin_cache as synthetic
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.output.skin_cache import write_skin_cache
from lappet.program.compile import compile_program
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    folder = tmp_path_factory.mktemp("usd")
    program = compile_program(small_procedure())
    frames = solve_program(program, FrameStore(folder / "s"), FakeSolver().connect, "fake", SolveObserver()).frames
    write_procedure(small_procedure(), folder / "p.usda")
    solved = [frame.solved for frame in frames]
    write_skin_cache(folder / "c.usdc", folder / "p.usda", small_procedure(), program, solved, "key")
    return SkinCache(folder / "c.usdc")


@pytest.fixture(scope="module")
def alone(cache: SkinCache, tmp_path_factory: pytest.TempPathFactory) -> Path:
    (path,) = export(ExportRequest((cache.path,), cache.path.with_name("whole.usdc"), {"one_file": True}))
    return Path(shutil.copy(path, tmp_path_factory.mktemp("alone")))


def test_it_has_no_layer_but_itself_and_passes_the_validators(alone: Path) -> None:
    stage = Usd.Stage.Open(str(alone))
    assert len(stage.GetUsedLayers()) == 2  # with that of the session
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []
    assert not any(stage.GetPrimAtPath(f"/Procedure/{name}") for name in ("Tissue", "Timeline", "Skin/Sutures"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (1.0, 8.0, 24.0)


def test_the_skin_is_that_of_the_cache_at_every_frame(alone: Path, cache: SkinCache) -> None:
    read = SkinCache(alone)
    assert read.frames == cache.frames
    for time in cache.frames:
        epoch = read.epoch_at(time)
        assert epoch.name == cache.epoch_at(time).name
        assert np.array_equal(read.positions(epoch, time), cache.positions(cache.epoch_at(time), time))


def test_threads_and_hooks_are_meshes_with_their_materials_shown_while_they_act(alone: Path) -> None:
    stage = Usd.Stage.Open(str(alone))
    for name, material, acting in (("Threads", "Thread", range(5, 9)), ("SkinHooks", "Steel", range(4, 7))):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/Procedure/Skin/Instruments/{name}"))
        assert UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0].GetPrim().GetName() == material
        shown = [time for time in range(1, 9) if mesh.ComputeVisibility(time) == "inherited"]
        assert shown == list(acting)
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
        assert all(indices.max() < len(mesh.GetPointsAttr().Get(time)) for time in acting)


def test_a_cache_of_an_earlier_version_is_exported_too(tmp_path: Path) -> None:
    old = synthetic.write_cache(tmp_path, step=4.0)
    path, *_ = export(ExportRequest((old,), tmp_path / "whole.usdc"))
    stage = Usd.Stage.Open(str(path))
    threads = stage.GetPrimAtPath("/Procedure/Skin/Instruments/Threads")
    material = UsdShade.MaterialBindingAPI(threads).ComputeBoundMaterial()[0]
    assert material.ComputeSurfaceSource()[0].GetInput("diffuseColor").Get() is not None


def test_a_cache_is_not_written_over_itself(cache: SkinCache) -> None:
    before = cache.path.read_bytes()
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((cache.path,), cache.path))
    assert [each.code for each in refusal.value.problems] == [ProblemCode.EXPORT_ITSELF]
    assert cache.path.read_bytes() == before
