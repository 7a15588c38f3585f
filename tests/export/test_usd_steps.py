"""USD with a file for each step is the stage of one file, for pxr and for Blender, whose value clips it plays."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdValidation

import synthetic_skin_cache as synthetic
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export import usd_steps
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.export.usd_steps import StepFiles
from lappet.output.skin_cache import write_skin_cache
from lappet.program.compile import compile_program
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure

SKIN = "/Procedure/Skin"


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    folder = tmp_path_factory.mktemp("steps")
    own = small_procedure(fps=12.0)  # so that an export has other time codes
    program = compile_program(own)
    frames = solve_program(program, FrameStore(folder / "s"), FakeSolver().connect, "fake", SolveObserver()).frames
    write_procedure(own, folder / "p.usda")
    write_skin_cache(folder / "c.usdc", folder / "p.usda", own, program, [each.solved for each in frames], "key")
    return SkinCache(folder / "c.usdc")


@pytest.fixture(scope="module")
def divided(cache: SkinCache, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return export(ExportRequest((cache.path,), tmp_path_factory.mktemp("divided") / "x.usdc", {"step_files": True}))


def looked_at(path: Path, look: str) -> Usd.Stage:
    stage = Usd.Stage.Open(str(path))
    stage.SetEditTarget(stage.GetSessionLayer())
    assert stage.GetPrimAtPath(SKIN).GetVariantSet("look").SetVariantSelection(look)
    return stage


def test_every_value_at_every_frame_and_between_is_that_of_one_file(
    cache: SkinCache, divided: list[Path], tmp_path: Path
) -> None:
    whole, *_ = export(ExportRequest((cache.path,), tmp_path / "x.usdc"))
    for look in ("grid", "strain"):
        one, many = looked_at(whole, look), looked_at(divided[0], look)
        paths = [{str(each.GetPath()) for each in stage.Traverse()} for stage in (one, many)]
        assert paths[0] == paths[1]
        for epoch in cache.epochs:
            mesh, other = (stage.GetPrimAtPath(f"{SKIN}/{epoch.name}") for stage in (one, many))
            assert mesh.GetPropertyNames() == other.GetPropertyNames()
            for time in (None, *(2.0 * frame for frame in epoch.frames), 2.0 * epoch.frames[0] + 1.0):
                code = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
                for name in (each.GetName() for each in mesh.GetAttributes()):
                    found, wanted = other.GetAttribute(name).Get(code), mesh.GetAttribute(name).Get(code)
                    assert np.array_equal(np.asarray(found), np.asarray(wanted)), (look, name, time)


def test_what_moves_lies_in_a_file_for_each_step_and_not_in_the_file_itself(
    cache: SkinCache, divided: list[Path]
) -> None:
    names = [each.name for each in divided]
    steps = [name for name in names if name.startswith("step_")]
    assert names[0] == "x.usdc"
    assert len(steps) == len(Usd.Stage.Open(str(divided[0])).GetPrimAtPath(f"{SKIN}/Steps").GetChildren())
    assert sorted(each.name for each in divided[0].with_name("x_steps").iterdir()) == sorted(
        ["lasting.usdc", "moving.usda", *steps]
    )
    held: list[float] = []
    for path in divided:
        layer = Sdf.Layer.FindOrOpen(str(path)) if path.suffix.startswith(".usd") else None
        if layer is None or path.name == "x_studio.usda":
            continue
        own = [time for epoch in cache.epochs for time in layer.ListTimeSamplesForPath(f"{SKIN}/{epoch.name}.points")]
        assert bool(own) == path.name.startswith("step_"), path.name
        held += own
    assert held == [2.0 * time for time in cache.frames]


def test_no_layer_of_a_frame_is_open_before_the_frame_is_asked_for(divided: list[Path]) -> None:
    stage = Usd.Stage.Open(str(divided[0]))
    assert not [each for each in stage.GetUsedLayers() if each.GetDisplayName().startswith("step_")]
    UsdGeom.Mesh(stage.GetPrimAtPath(f"{SKIN}/epoch_01")).GetPointsAttr().Get(16.0)
    opened = [each.GetDisplayName() for each in stage.GetUsedLayers() if each.GetDisplayName().startswith("step_")]
    assert len(opened) <= 2


@pytest.mark.parametrize("look", ["grid", "strain"])
def test_no_validator_complains(divided: list[Path], look: str) -> None:
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(looked_at(divided[0], look))
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_lappet_reads_it_and_writes_one_file_of_it_again(cache: SkinCache, divided: list[Path], tmp_path: Path) -> None:
    (again,) = export(ExportRequest((divided[0],), tmp_path / "again.usdc", {"one_file": True}))
    read = SkinCache(again)
    assert read.frames == tuple(2.0 * time for time in cache.frames)
    for time in cache.frames:
        epoch = cache.epoch_at(time)
        assert np.array_equal(read.positions(read.epoch_at(2.0 * time), 2.0 * time), cache.positions(epoch, time))


def test_a_step_that_is_too_large_for_one_file_has_several(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usd_steps, "_MOST_BYTES", 200.0)
    steps = StepFiles.of(Path("a.usdc"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], [2.0, 2.0, 6.0], 100.0)
    assert steps.spans == ((1.0, 2.0), (3.0, 4.0), (5.0, 6.0), (7.0,))
    assert steps.names == ("step_01.usdc", "step_02_1.usdc", "step_02_2.usdc", "step_02_3.usdc")


def test_one_file_and_a_file_for_each_step_are_refused_together(tmp_path: Path) -> None:
    options = {"one_file": True, "step_files": True}
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((synthetic.write_cache(tmp_path, step=8.0),), tmp_path / "x.usdc", options))
    assert [each.code for each in refusal.value.problems] == [ProblemCode.EXPORT_STEP_FILES]


_IMPORT = """
import json, sys
import bpy
import numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[1])
scene, answer = bpy.context.scene, {}
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    for each in bpy.data.objects:
        own = each.evaluated_get(graph)
        if each.name.startswith("epoch") and max(own.matrix_world.to_scale()) > 1e-6:
            mesh = own.to_mesh()
            points = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", points)
            answer.setdefault(str(frame), {})[each.name] = points.tolist()
            own.to_mesh_clear()
print("ANSWER " + json.dumps(answer))
"""


@pytest.mark.slow
def test_blender_plays_the_files_of_the_steps(cache: SkinCache, divided: list[Path]) -> None:
    pytest.importorskip("bpy")
    command = [sys.executable, "-c", _IMPORT, str(divided[0])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith("ANSWER ")]
    assert lines, done.stdout[-2000:] + done.stderr[-2000:]
    assert "warn" not in (done.stdout + done.stderr).lower()
    shown = json.loads(lines[0][7:])
    for time in cache.frames:
        epoch = cache.epoch_at(time)
        ((name, points),) = shown[f"{2 * time:g}"].items()
        assert name == epoch.name
        assert np.abs(np.reshape(points, (-1, 3)) - cache.positions(epoch, time)).max() < 1e-4
