"""Export and import: the procedure and the skin cache as USD, through Blender's own pxr."""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

from event_patch import co, patch_scene
from lappet.core.interpreter import child_environment
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import DaemonMissing
from lappet.daemon.process import find_daemon
from lappet.solve.store import FrameStore
from lappet_blender.files.bundled_pxr import bundled_pxr
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.solving import frames
from refusals import refusal

TOP = 2.0
ops = bpy.ops.lappet

KEYS = """
import sys
import pxr
assert "bpy" not in pxr.__file__, pxr.__file__
from lappet.program.compile import compile_program
from lappet.daemon.daemon_solver import solver_identity
from lappet.program.keys import frame_keys
from lappet.usd.stage import read_procedure
print(*frame_keys(compile_program(read_procedure(sys.argv[1])), solver_identity(None)))
"""

POINTS = """
import sys
import numpy as np
from pxr import Usd, UsdGeom
stage = Usd.Stage.Open(sys.argv[1])
for mesh in stage.GetPrimAtPath("/Procedure/Skin").GetChildren():
    if mesh.IsA(UsdGeom.Mesh):
        points = UsdGeom.Mesh(mesh).GetPointsAttr()
        for time in points.GetTimeSamples():
            print(mesh.GetName(), time, np.asarray(points.Get(time), np.float32).tobytes().hex())
"""


@pytest.fixture
def slit(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A patch of 24 x 16 x 2 mm, slit, hooked along a curve and sutured, in 6 frames; made by operators."""
    patch_scene(scene, (24.0, 16.0, TOP), 6, resolution=2.0)
    scene.lappet.tissue.spacing = 1.0
    ops.incision_add(points=co([(-5.7, 0, TOP), (5.7, 0.3, TOP)]), time=2, kerf=0.1)
    ops.hook_add(anchor=(0.1, 2.2, TOP), target=(0, 3.3, TOP + 1), start=3, end=5, arrive=2)
    for curve_key in scene.lappet.events[1].target.animation_data.action.layers[0].strips[0].channelbags[0].fcurves:
        for key in curve_key.keyframe_points:
            key.interpolation = "BEZIER"
    ops.suture_run(incision="incision_1", count=2, start=4, duration=2)
    ops.landmark_add(point=(-8, 4, TOP), label="corner")
    return scene


@pytest.fixture
def daemon() -> None:
    """There is a daemon to solve with."""
    try:
        find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))


def headless(code: str, *arguments: object) -> str:
    """What Python says in a process with usd-core and without Blender."""
    run = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, env=os.environ, check=False
    )
    assert run.returncode == 0, run.stderr[-2000:]
    return run.stdout


def test_pxr_is_blenders_own_with_lappets_schemas(scene: bpy.types.Scene) -> None:
    usd = bundled_pxr()
    assert "bpy" in str(usd.Usd.__file__)
    registry = usd.Usd.SchemaRegistry()
    assert registry.FindAppliedAPIPrimDefinition("LappetHookAPI")


@pytest.mark.usefixtures("daemon")
def test_an_exported_procedure_is_the_scenes_and_has_its_keys_without_blender(
    slit: bpy.types.Scene, tmp_path: Path
) -> None:
    path = tmp_path / "slit.usda"
    ops.export_procedure(filepath=str(path))
    from lappet.usd.stage import read_procedure

    procedure = read_scene(slit).procedure
    assert read_procedure(path) == procedure
    assert len(procedure.event("hook_1").targets) == 3, "a curved way is sampled at every frame"
    ops.plan_now(wait=True)
    manifest = frames.manifest_of(slit)
    assert manifest is not None
    assert headless(KEYS, path).split() == [frame.key for frame in manifest.frames]


@pytest.mark.usefixtures("daemon")
def test_the_button_and_the_command_give_the_same_frames_bit_for_bit(slit: bpy.types.Scene, tmp_path: Path) -> None:
    cache, path = tmp_path / "skin.usdc", tmp_path / "slit.usda"
    missing = refusal(lambda: ops.export_cache(filepath=str(cache)))
    assert (missing.code, missing.value) == (ProblemCode.FRAMES_NOT_SOLVED, "1")
    assert not cache.exists()
    ops.solve(wait=True)
    ops.export_cache(filepath=str(cache))
    ops.export_procedure(filepath=str(path))
    assert (tmp_path / "skin.procedure.usda").read_bytes() == path.read_bytes()

    command = [sys.executable, "-m", "lappet", "solve", str(path), "-o", str(tmp_path / "own.usdc")]
    report = tmp_path / "report.json"
    apart = {**os.environ, "LAPPET_STORE": str(tmp_path / "another store")}
    run = subprocess.run([*command, "--report", str(report)], env=apart, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    assert not any(frame["cache_hit"] for frame in json.loads(report.read_text())["frames"])
    assert headless(POINTS, cache) == headless(POINTS, tmp_path / "own.usdc")

    slit.lappet.events["suture_run_1"].moment = 5.0
    assert refusal(lambda: ops.export_cache(filepath=str(cache))).code is ProblemCode.FRAMES_NOT_SOLVED


@pytest.mark.usefixtures("daemon")
def test_a_cache_brings_its_frames_along(slit: bpy.types.Scene, tmp_path: Path) -> None:
    ops.solve(wait=True)
    cache = tmp_path / "skin.usdc"
    ops.export_cache(filepath=str(cache))
    manifest = frames.manifest_of(slit)
    shown = {time: frames.shown_at(slit, time) for time in range(1, 7)}

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.unit_settings.scale_length = 0.001
    from lappet_blender.solving.controller import frame_cache

    frame_cache.clear()
    store = FrameStore()
    for frame in manifest.frames:
        store.path(frame.key).unlink()
    ops.import_procedure(filepath=str(cache))
    scene = bpy.context.scene
    ops.plan_now(wait=True)
    assert [frame.key for frame in frames.manifest_of(scene).frames] == [frame.key for frame in manifest.frames]
    for time in range(1, 7):
        again = frames.shown_at(scene, time)
        assert not again.stale
        assert frames.frame_state(scene, time) == "solved"
        np.testing.assert_array_equal(again.frame.points, shown[time].frame.points)
        here, there = again.frame.arrays(), shown[time].frame.arrays()
        for name in ("strain", "stress", "tension", "suture_index", "hook_index", "landmark_index"):
            np.testing.assert_array_equal(here[name], there[name])
        for name in ("suture_points", "hook_points", "landmarks"):
            np.testing.assert_allclose(here[name], there[name], atol=1e-5)
    assert not any(frame.key in store for frame in manifest.frames), "frames without their state would mislead a solve"


@pytest.mark.usefixtures("daemon")
def test_frames_that_were_solved_otherwise_are_shown_as_such(slit: bpy.types.Scene, tmp_path: Path) -> None:
    slit.lappet.materials[0].youngs_modulus = 47.0  # a tissue that no other test has solved
    slit.lappet.solving.tolerance = 1e-4
    ops.solve(wait=True)
    cache = tmp_path / "skin.usdc"
    ops.export_cache(filepath=str(cache))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ops.import_procedure(filepath=str(cache))
    scene = bpy.context.scene
    ops.plan_now(wait=True)
    assert {frames.frame_state(scene, time) for time in range(1, 7)} == {"stale"}
    assert frames.shown_at(scene, 5).frame is not None


def test_an_import_goes_into_a_scene_of_its_own_where_there_is_a_procedure_already(
    slit: bpy.types.Scene, tmp_path: Path
) -> None:
    path = tmp_path / "slit.usda"
    ops.export_procedure(filepath=str(path))
    before = read_scene(slit).procedure
    ops.import_procedure(filepath=str(path))
    assert [scene.name for scene in bpy.data.scenes] == ["Scene", "slit"]
    assert read_scene(bpy.data.scenes["Scene"]).procedure == before
    again = read_scene(bpy.data.scenes["slit"]).procedure
    assert [event.name for event in again.events] == [event.name for event in before.events]
    assert again.events == before.events


def test_files_that_cannot_be_read_or_written_are_refused_in_a_sentence(slit: bpy.types.Scene, tmp_path: Path) -> None:
    broken = tmp_path / "broken.usda"
    broken.write_text("#usda 1.0\n(")
    empty = tmp_path / "empty.usda"
    empty.write_text("#usda 1.0\n")
    for path, code in (
        (tmp_path / "none.usda", ProblemCode.USD_NO_FILE),
        (broken, ProblemCode.USD_UNREADABLE),
        (empty, ProblemCode.STAGE_TISSUES),
    ):
        assert refusal(lambda path=path: ops.import_procedure(filepath=str(path))).code is code
    assert len(bpy.data.scenes) == 1
    export = ops.export_procedure
    assert refusal(lambda: export(filepath=str(tmp_path / "a.obj"))).code is ProblemCode.USD_SUFFIX
    assert refusal(lambda: export(filepath=str(tmp_path / "no" / "a.usda"))).code is ProblemCode.FILE_NO_FOLDER
    slit.lappet.tissue.object = None
    assert refusal(lambda: export(filepath=str(tmp_path / "a.usda"))).code is ProblemCode.TISSUE_NONE


def test_a_procedure_that_refers_outside_its_folder_is_imported_only_where_that_is_allowed(
    slit: bpy.types.Scene, tmp_path: Path
) -> None:
    path = tmp_path / "inside" / "slit.usda"
    path.parent.mkdir()
    ops.export_procedure(filepath=str(tmp_path / "outside.usda"))
    times = '    startTimeCode = 1\n    endTimeCode = 6\n    metersPerUnit = 0.001\n    upAxis = "Z"\n'
    path.write_text(f"#usda 1.0\n(\n{times}    subLayers = [@../outside.usda@]\n)\n")
    assert refusal(lambda: ops.import_procedure(filepath=str(path))).code is ProblemCode.READ_OUTSIDE
    assert len(bpy.data.scenes) == 1
    ops.import_procedure(filepath=str(path), allow_external=True)
    assert len(bpy.data.scenes["slit"].lappet.events) == len(slit.lappet.events)
    assert refusal(lambda: ops.import_procedure(filepath=str(path))).code is ProblemCode.READ_OUTSIDE, "asked each time"


def test_an_import_reads_as_much_as_its_properties_say(slit: bpy.types.Scene, tmp_path: Path) -> None:
    path = tmp_path / "slit.usda"
    ops.export_procedure(filepath=str(path))
    with path.open("a") as file:
        file.write("\n" * (3 << 20))
    refused = refusal(lambda: ops.import_procedure(filepath=str(path), read_size=2 / 1024))
    assert (refused.code, refused.value) == (ProblemCode.READ_SIZE, "3.0")
    ops.import_procedure(filepath=str(path))
    assert len(bpy.data.scenes) == 2


@pytest.mark.skipif(os.name != "posix", reason="no pipes here")
def test_a_pipe_is_not_imported(scene: bpy.types.Scene, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.usda")
    assert refusal(lambda: ops.import_procedure(filepath=str(tmp_path / "pipe.usda"))).code is (
        ProblemCode.READ_NOT_REGULAR
    )


def test_the_child_that_reads_has_blenders_own_pxr(scene: bpy.types.Scene) -> None:
    """Blender comes with no other."""
    usd = bundled_pxr()
    folder = str(Path(usd.Usd.__file__).parents[2])
    code = "import lappet.usd.stage; print(lappet.usd.stage.pxr().Usd.__file__)"
    found = subprocess.run(
        [sys.executable, "-s", "-P", "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=child_environment(os.environ, [folder, *sys.path], None),
    )
    assert Path(found.stdout.strip()) == Path(usd.Usd.__file__)


def test_without_pxr_import_and_export_say_so_and_everything_else_works(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise ModuleNotFoundError("No module named 'pxr'", name="pxr")

    monkeypatch.setattr("lappet_blender.files.bundled_pxr.pxr", missing)
    for act in (ops.export_procedure, ops.import_procedure, ops.export_cache):
        code = refusal(lambda act=act: act(filepath=str(tmp_path / "a.usda"))).code
        assert code is ProblemCode.USD_NOT_IN_BLENDER
    ops.incision_add(points=co([(-5, 5, TOP), (5, 5, TOP)]), time=2)


def test_what_there_are_no_tools_for_is_kept_and_exported_again(scene: bpy.types.Scene, tmp_path: Path) -> None:
    from lappet.procedure import Bone, Hook, Muscle, Pressure, Procedure, Roller, Section, Strand, Traction
    from lappet.tissue.patch import flat_patch
    from lappet.usd.stage import read_procedure, write_procedure

    tissue = flat_patch((12.0, 8.0, TOP), 2.0)
    tissue = replace(tissue, subsets={**tissue.subsets, "plane": np.arange(3)}, rollers=(Roller("plane", (0, 1, 0)),))
    events = (
        Hook("hook", (0, 0, TOP), ((2.0, (0, 0, TOP)), (3.0, (0, 2, TOP))), 2.0, 5.0),
        Traction("push", "bed", ((1.0, (0, 0, 0.1)), (4.0, (0, 1, 0))), 1.0, 6.0),
        Pressure("air", "bed", ((1.0, 0.3),), 1.0, 6.0),
        Section("neck", (0, 0, 0), (1, 0, 0), "neck"),
    )
    corners = np.array([[x, y, z] for x in (-2, 2) for y in (-2, 2) for z in (TOP + 1, TOP + 3)], float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    down = np.eye(4)
    down[3, 2] = -2.0
    motion = ((1.0, tuple(np.eye(4).ravel())), (6.0, tuple(down.ravel())))
    bones = (Bone("punch", corners, np.full(6, 4), np.ravel(faces), motion),)
    muscles = (Muscle("belly", (Strand(((-4, 0, 2), (4, 0, 2)), (1, 1)),), "skin"),)
    procedure = Procedure(tissue, events=events, bones=bones, muscles=muscles, end_time=6.0)
    write_procedure(procedure, tmp_path / "told.usda")
    ops.import_procedure(filepath=str(tmp_path / "told.usda"))
    assert [event.name for event in scene.lappet.events] == ["hook"]
    reading = read_scene(bpy.context.scene)
    assert reading.procedure is not None
    assert reading.procedure.tissue.rollers == tissue.rollers
    assert reading.procedure.events[1:] == events[1:]
    ops.export_procedure(filepath=str(tmp_path / "again.usda"))
    back = read_procedure(tmp_path / "again.usda")
    assert (back.events[1:], back.tissue.rollers) == (events[1:], tissue.rollers)
    assert (back.muscles, back.bones[0].motion) == (muscles, motion)
    scene.lappet.kept = "damaged"
    damaged = read_scene(bpy.context.scene).procedure
    assert damaged is not None
    assert len(damaged.events) == 1


def test_plates_go_through_a_scene_unchanged(scene: bpy.types.Scene, tmp_path: Path) -> None:
    from lappet.procedure import Plate, PlateAnnotation, PlatePanel, Procedure
    from lappet.tissue.patch import flat_patch
    from lappet.usd.stage import read_procedure, write_procedure

    notes = (PlateAnnotation("tip", "label", ((1.0, 2.0, TOP),), "Spitze", offset=(3.0, -2.0)),)
    plates = (
        Plate(
            "mine",
            "ink",
            panels=(PlatePanel("before", "plan", caption="Défaut"),),
            annotations=notes,
            text=9.0,
            marks="dots",
            marks_spacing=4.0,
            skin_lines=True,
            journal="plos",
        ),
    )
    write_procedure(Procedure(flat_patch((12.0, 8.0, TOP), 2.0), plates=plates), tmp_path / "plates.usda")
    ops.import_procedure(filepath=str(tmp_path / "plates.usda"))
    ops.export_procedure(filepath=str(tmp_path / "again.usda"))
    assert read_procedure(tmp_path / "again.usda").plates == plates


def test_plates_of_an_earlier_version_are_read_and_damaged_ones_are_dropped(scene: bpy.types.Scene) -> None:
    from lappet.core.value_codec import pack
    from lappet.procedure import Plate, PlatePanel
    from lappet_blender.model.migrate import migrate
    from lappet_blender.model.plate_values import KeptPlates, plate_values

    plates = (Plate("mine", "wash", panels=(PlatePanel("after", "result"),)),)
    scene.lappet.version = 1
    scene.lappet.plates = base64.b64encode(pack(KeptPlates(plates))).decode("ascii")
    assert migrate(scene)
    assert plate_values(scene) == plates
    scene.lappet.pages.clear()
    scene.lappet.version = 1
    scene.lappet.plates = "damaged"
    assert migrate(scene)
    assert plate_values(scene) == ()
