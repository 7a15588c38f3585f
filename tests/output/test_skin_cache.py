"""The skin cache is what docs/skin_cache.md says, passes USD's validators, and opens in Blender."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdValidation

from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.shading_normals import ShadingNormals
from lappet.output.skin_cache import write_skin_cache
from lappet.procedure import Procedure, Suture
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.solve.measures import FrameMeasures, Gauges
from lappet.solve.seam_measures import SeamState
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure


@pytest.fixture(scope="module")
def procedure() -> Procedure:
    return small_procedure()


@pytest.fixture(scope="module")
def program(procedure: Procedure) -> Program:
    return compile_program(procedure)


@pytest.fixture(scope="module")
def frames(program: Program, tmp_path_factory: pytest.TempPathFactory) -> tuple[FrameResult, ...]:
    store = FrameStore(tmp_path_factory.mktemp("store"))
    return solve_program(program, store, FakeSolver().connect, "fake", SolveObserver()).frames


@pytest.fixture(scope="module", params=[".usdc", ".usda"])
def cache(
    request: pytest.FixtureRequest,
    procedure: Procedure,
    program: Program,
    frames: tuple[FrameResult, ...],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    folder = tmp_path_factory.mktemp("cache")
    write_procedure(procedure, folder / "p.usda")
    path = folder / "caches" / f"skin{request.param}"
    path.parent.mkdir(exist_ok=True)
    write(path, folder / "p.usda", procedure, program, frames)
    return path


def write(output: Path, below: Path, procedure: Procedure, program: Program, frames: Sequence[FrameResult]) -> None:
    solved = [frame.solved for frame in frames]
    write_skin_cache(output, below, procedure, program, solved, frames[-1].key, measured(procedure, program, solved))


def measured(procedure: Procedure, program: Program, frames: Sequence[SolvedFrame]) -> list[FrameMeasures]:
    gauges = Gauges(program)
    return [gauges.measure(frame) for frame in frames]


def seams_at(procedure: Procedure, program: Program, frames: Sequence[SolvedFrame]) -> list[SeamState]:
    return [state for each in measured(procedure, program, frames) for state in each.seams]


def mesh_at(stage: Usd.Stage, index: int) -> UsdGeom.Mesh:
    return UsdGeom.Mesh(stage.GetPrimAtPath(f"/Procedure/Skin/epoch_{index:02d}"))


def test_every_validator_of_usd_passes(cache: Path) -> None:
    registry = UsdValidation.ValidationRegistry()
    validators = registry.GetOrLoadAllValidators()
    assert len(validators) > 10
    errors = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(cache)))
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_the_stage_goes_over_the_procedure_and_has_its_units_and_times(cache: Path) -> None:
    stage = Usd.Stage.Open(str(cache))
    assert list(stage.GetRootLayer().subLayerPaths) == ["../p.usda"]
    assert stage.GetDefaultPrim().GetPath() == "/Procedure"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.001
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (1, 8, 24)
    assert stage.GetPrimAtPath("/Procedure/Timeline/hook")
    assert UsdGeom.Imageable(stage.GetPrimAtPath("/Procedure/Tissue")).ComputeVisibility() == "invisible"


def test_one_epoch_shows_at_every_frame_with_the_points_that_were_solved(
    cache: Path, program: Program, frames: tuple[FrameResult, ...]
) -> None:
    stage = Usd.Stage.Open(str(cache))
    for frame in frames:
        time = frame.constraints.time
        shown = [mesh for mesh in (mesh_at(stage, 0), mesh_at(stage, 1)) if mesh.ComputeVisibility(time) == "inherited"]
        assert [mesh.GetPrim().GetName() for mesh in shown] == [f"epoch_{frame.constraints.epoch:02d}"]
        points = np.array(shown[0].GetPointsAttr().Get(time))
        assert np.array_equal(points, frame.solved.points)
        assert np.array_equal(np.array(shown[0].GetExtentAttr().Get(time)), [points.min(0), points.max(0)])
        for name, value in (("strain", 0.1), ("stress", 0.2), ("tension", 0.3)):
            primvar = UsdGeom.PrimvarsAPI(shown[0]).GetPrimvar(name)
            assert primvar.GetInterpolation() == "vertex"
            assert np.array_equal(np.array(primvar.Get(time)), np.full(len(points), value, np.float32))


def test_without_a_time_the_points_are_those_at_rest(cache: Path, program: Program) -> None:
    stage = Usd.Stage.Open(str(cache))
    for epoch in program.epochs:
        points = mesh_at(stage, epoch.index).GetPointsAttr().Get()
        assert np.array_equal(np.array(points), epoch.surface.points.astype(np.float32))


def test_between_two_frames_an_epoch_is_shown_whole_or_not_at_all(cache: Path) -> None:
    stage = Usd.Stage.Open(str(cache))
    for time, index in ((1.0, 0), (2.0, 0), (2.5, 0), (2.99, 0), (3.0, 1), (3.5, 1), (8.0, 1)):
        sizes = [mesh_at(stage, i).ComputeLocalToWorldTransform(time).GetDeterminant() for i in (0, 1)]
        assert sizes == [1.0 - index, float(index)]


def test_topology_texture_and_subsets_are_those_of_the_epoch(cache: Path, program: Program) -> None:
    stage = Usd.Stage.Open(str(cache))
    for epoch in program.epochs:
        mesh, surface = mesh_at(stage, epoch.index), epoch.surface
        assert np.array_equal(np.array(mesh.GetFaceVertexIndicesAttr().Get()), surface.triangles.ravel())
        assert set(mesh.GetFaceVertexCountsAttr().Get()) == {3}
        assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
        st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        assert (st.GetInterpolation(), st.ValueMightBeTimeVarying()) == ("faceVarying", False)
        assert np.array_equal(np.array(st.Get()), surface.uv.reshape(-1, 2))
        names = {"skin": 0, "woundWall": 1, "underside": 2, "rim": 3}
        for name, origin in names.items():
            subset = UsdGeom.Subset(stage.GetPrimAtPath(mesh.GetPath().AppendChild(name)))
            assert np.array_equal(np.array(subset.GetIndicesAttr().Get()), np.flatnonzero(surface.origin == origin))
            assert subset.GetFamilyNameAttr().Get() == "lappet"
    wall = UsdGeom.Subset(stage.GetPrimAtPath("/Procedure/Skin/epoch_01/woundWall"))
    assert len(wall.GetIndicesAttr().Get()) > 20


def test_velocities_are_in_mm_per_second_and_stay_inside_an_epoch(cache: Path, frames: tuple[FrameResult, ...]) -> None:
    stage = Usd.Stage.Open(str(cache))
    mesh = mesh_at(stage, 1)
    at = {frame.constraints.time: frame.solved.points for frame in frames}
    inside = (at[6] - at[4]) * 12.0
    assert np.allclose(np.array(mesh.GetVelocitiesAttr().Get(5)), inside, atol=1e-4)
    assert np.allclose(np.array(mesh.GetVelocitiesAttr().Get(3)), (at[4] - at[3]) * 24.0, atol=1e-4)
    assert np.allclose(np.array(mesh.GetVelocitiesAttr().Get(8)), (at[8] - at[7]) * 24.0, atol=1e-4)


def test_normals_are_straight_up_on_the_skin_right_to_the_wounds_edge(cache: Path, program: Program) -> None:
    stage = Usd.Stage.Open(str(cache))
    mesh = mesh_at(stage, 1)
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals")
    assert primvar.GetInterpolation() == "faceVarying"
    normals = np.array(primvar.ComputeFlattened(5)).reshape(-1, 3, 3)
    origin = program.epochs[1].surface.origin
    assert np.allclose(normals[origin == FaceOrigin.SKIN], (0.0, 0.0, 1.0), atol=1e-3)
    assert np.allclose(normals[origin == FaceOrigin.UNDERSIDE], (0.0, 0.0, -1.0), atol=1e-3)
    assert np.abs(normals[origin == FaceOrigin.WOUND_WALL, :, 2]).max() < 1e-2


def test_sutures_hooks_and_landmarks_follow_and_say_when_they_act(cache: Path) -> None:
    stage = Usd.Stage.Open(str(cache))

    def active(name: str) -> list[list[int]]:
        primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/Procedure/Skin/{name}")).GetPrimvar("active")
        return [list(primvar.Get(time)) for time in range(1, 9)]

    assert active("Sutures") == [[0], [0], [0], [0], [1], [1], [1], [1]]
    assert active("Hooks") == [[0], [0], [0], [1], [1], [1], [0], [0]]
    assert active("Landmarks") == [[1]] * 8
    hooks = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Procedure/Skin/Hooks"))
    assert np.allclose(np.array(hooks.GetPointsAttr().Get(6))[1], (0.0, 4.0, 4.0))
    released = np.array(hooks.GetPointsAttr().Get(7))
    assert np.array_equal(released[0], released[1])
    marks = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Procedure/Skin/Landmarks")).GetPrimvar("label")
    assert list(marks.Get()) == ["corner"]


def test_forces_of_sutures_and_hooks_are_vectors_in_rows_of_their_own_and_zero_while_they_do_not_act(
    cache: Path,
) -> None:
    stage = Usd.Stage.Open(str(cache))
    pulls, nothing = {"Sutures": (0.0, 5.0, 0.0), "Hooks": (2.0, 2.0, 2.0)}, (0.0, 0.0, 0.0)
    acting = [(name, 6, pull) for name, pull in pulls.items()]
    for name, time, force in (*acting, ("Sutures", 4, nothing), ("Hooks", 7, nothing)):
        primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/Procedure/Skin/{name}")).GetPrimvar("forceVector")
        assert primvar.GetInterpolation() == "uniform"
        assert [tuple(each) for each in primvar.Get(time)] == [force]


def test_a_seam_is_a_curve_with_what_is_measured_at_its_places(
    cache: Path, procedure: Procedure, program: Program, frames: tuple[FrameResult, ...]
) -> None:
    stage = Usd.Stage.Open(str(cache))
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Procedure/Skin/Seams"))
    primvars = UsdGeom.PrimvarsAPI(curves)
    assert list(primvars.GetPrimvar("label").Get()) == ["stitch"]
    assert [list(primvars.GetPrimvar("active").Get(time)) for time in range(1, 9)] == [[0], [0], *([[1]] * 6)]
    states = {state.measure.time: state for state in seams_at(procedure, program, [frame.solved for frame in frames])}
    assert list(states) == [3, 4, 5, 6, 7, 8]
    for time in (3, 8):
        state = states[time]
        points = np.array(curves.GetPointsAttr().Get(time))
        assert list(curves.GetCurveVertexCountsAttr().Get()) == [len(points)]
        assert np.allclose(points, state.points, atol=1e-5)
        assert points[:, 0].min() < -5.9
        assert points[:, 0].max() > 5.9
        for name in ("gap", "step", "mismatch"):
            primvar = primvars.GetPrimvar(name)
            assert primvar.GetInterpolation() == "vertex"
            assert np.allclose(np.array(primvar.Get(time)), getattr(state, name), atol=1e-6)
        assert primvars.GetPrimvar("scarLength").Get(time)[0] == pytest.approx(state.measure.scar_length_mm)
    assert np.array(primvars.GetPrimvar("gap").Get(5)).max() == pytest.approx(0.1, abs=1e-3)
    assert np.isnan(primvars.GetPrimvar("tension").Get(4)[0])
    assert primvars.GetPrimvar("tension").Get(5)[0] == pytest.approx(0.005 / states[5].measure.scar_length_mm)
    before = np.array(curves.GetPointsAttr().Get(2))
    assert np.ptp(before, axis=0).max() == 0.0


def test_forces_and_seams_have_their_errors_beside_them_and_nan_where_there_is_none(tmp_path: Path) -> None:
    procedure = small_procedure()
    program = compile_program(procedure)
    solver = FakeSolver()
    frames = solve_program(program, FrameStore(tmp_path / "s"), solver.connect, "fake", SolveObserver()).frames
    solved = [frame.solved for frame in frames]
    known = [
        replace(
            each,
            sutures=tuple(replace(row, force_error_mn=0.4, resolved=False) for row in each.sutures),
            hooks=tuple(replace(row, force_error_mn=0.3) for row in each.hooks),
            seams=tuple(
                replace(state, measure=replace(state.measure, scar_length_error_mm=0.2)) for state in each.seams
            ),
        )
        for each in measured(procedure, program, solved)
    ]
    write_procedure(procedure, tmp_path / "p.usda")
    for name, measures in (("known", known), ("bare", measured(procedure, program, solved))):
        path = tmp_path / f"{name}.usdc"
        write_skin_cache(path, tmp_path / "p.usda", procedure, program, solved, "key", measures)
    stages = {name: Usd.Stage.Open(str(tmp_path / f"{name}.usdc")) for name in ("known", "bare")}
    primvars = {
        (name, prim): UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/Procedure/Skin/{prim}"))
        for name, stage in stages.items()
        for prim in ("Sutures", "Hooks", "Seams")
    }
    for prim, error, active in (("Sutures", 0.4, 8.0), ("Hooks", 0.3, 5.0)):
        values = primvars["known", prim].GetPrimvar("forceError")
        assert values.Get(active)[0] == pytest.approx(error)
        assert np.isnan(values.Get(1.0)[0])  # it does not pull yet
        assert not primvars["bare", prim].GetPrimvar("forceError").HasValue()
    resolved = {name: primvars[name, "Sutures"].GetPrimvar("resolved") for name in ("known", "bare")}
    assert [list(resolved["known"].Get(time)) for time in (1.0, 8.0)] == [[1], [0]]  # it is not placed yet, it is
    assert list(resolved["bare"].Get(8.0)) == [1]
    lengths = {name: primvars[name, "Seams"].GetPrimvar("scarLengthError").Get(8.0)[0] for name in ("known", "bare")}
    assert lengths["known"] == pytest.approx(0.2)
    assert np.isnan(lengths["bare"])


def test_a_thread_with_several_bites_has_a_curve_through_all_of_them(program: Program, tmp_path: Path) -> None:
    top = float(program.epochs[0].surface.points[:, 2].max())
    bites = ((2.0, -2.0, top), (2.0, 2.0, top), (4.0, -2.0, top), (4.0, 2.0, top))
    running = Suture("running", bites, 3.0, mode="thread")
    procedure = small_procedure().with_events(running)
    own = compile_program(procedure)
    up = np.array([0.0, 0.0, 1.0])
    places = np.array(bites) + up
    solved = [
        SolvedFrame(
            each.time,
            own.epochs[each.epoch].surface.points.astype(np.float32),
            suture_index=each.suture_index,
            suture_points=each.suture_anchors + up,
            suture_forces=np.ones(len(each.suture_index)),
            suture_inner_bites=each.suture_inner_bites,
            inner_bite_points=each.inner_bite_anchors + up,
        )
        for each in own.frames
    ]
    write_procedure(procedure, tmp_path / "p.usda")
    write_skin_cache(tmp_path / "c.usdc", tmp_path / "p.usda", procedure, own, solved, "key")
    stage = Usd.Stage.Open(str(tmp_path / "c.usdc"))
    threads = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Procedure/Skin/Threads"))
    assert list(threads.GetCurveVertexCountsAttr().Get()) == [4]
    primvars = UsdGeom.PrimvarsAPI(threads)
    assert list(primvars.GetPrimvar("label").Get()) == ["running"]
    assert [primvars.GetPrimvar("active").Get(time)[0] for time in range(1, 9)] == [0, 0, 1, 1, 1, 1, 1, 1]
    assert np.allclose(np.array(threads.GetPointsAttr().Get(2)), bites[0])
    assert np.allclose(np.array(threads.GetPointsAttr().Get(8)), places)
    both = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Procedure/Skin/Sutures"))
    assert list(both.GetCurveVertexCountsAttr().Get()) == [2, 2]


def test_a_cache_without_such_a_thread_has_no_prim_of_them(cache: Path) -> None:
    assert not Usd.Stage.Open(str(cache)).GetPrimAtPath("/Procedure/Skin/Threads")


def test_a_cache_is_replaced_whole_also_while_it_is_open(
    procedure: Procedure, program: Program, frames: tuple[FrameResult, ...], tmp_path: Path
) -> None:
    write_procedure(procedure, tmp_path / "p.usda")
    path = tmp_path / "c.usdc"
    write(path, tmp_path / "p.usda", procedure, program, frames[:2])
    first = Usd.Stage.Open(str(path))
    assert first.GetEndTimeCode() == 2
    write(path, tmp_path / "p.usda", procedure, program, frames)
    assert Usd.Stage.Open(str(path)).GetEndTimeCode() == 8
    assert sorted(each.name for each in tmp_path.iterdir()) == ["c.usdc", "p.usda"]


def test_frames_of_one_epoch_alone_make_a_cache_without_the_others(
    procedure: Procedure, program: Program, frames: tuple[FrameResult, ...], tmp_path: Path
) -> None:
    write_procedure(procedure, tmp_path / "p.usda")
    write(tmp_path / "c.usda", tmp_path / "p.usda", procedure, program, frames[4:6])
    stage = Usd.Stage.Open(str(tmp_path / "c.usda"))
    assert not stage.GetPrimAtPath("/Procedure/Skin/epoch_00")
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (5, 6)


def test_shading_normals_of_a_sphere_point_outwards() -> None:
    import trimesh

    sphere = trimesh.creation.icosphere(subdivisions=3)
    nothing = np.zeros(len(sphere.faces), bool)
    surface = Surface(
        np.asarray(sphere.vertices, np.float64),
        np.asarray(sphere.faces, np.int32),
        np.zeros((len(sphere.faces), 3, 2), np.float32),
        np.zeros(len(sphere.faces), np.uint8),
        nothing,
        nothing,
    )
    shading = ShadingNormals(surface)
    assert shading.groups == len(sphere.vertices)
    corners = shading.at(surface.points * 3.0)[shading.indices].reshape(-1, 3, 3)
    assert np.abs(corners - surface.points[surface.triangles]).max() < 0.01


def test_shading_normals_of_a_box_are_those_of_its_faces_and_survive_collapse() -> None:
    import trimesh

    box = trimesh.creation.box()
    nothing = np.zeros(len(box.faces), bool)
    surface = Surface(
        np.asarray(box.vertices, np.float64),
        np.asarray(box.faces, np.int32),
        np.zeros((len(box.faces), 3, 2), np.float32),
        np.zeros(len(box.faces), np.uint8),
        nothing,
        nothing,
    )
    shading = ShadingNormals(surface)
    assert shading.groups == 24
    corners = shading.at(surface.points)[shading.indices].reshape(-1, 3, 3)
    assert np.allclose(corners, np.asarray(box.face_normals)[:, None, :], atol=1e-6)
    collapsed = shading.at(np.zeros_like(surface.points))
    assert np.allclose(np.linalg.norm(collapsed, axis=1), 1.0)


_IMPORT = """
import json, sys
import bpy
import numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.frame_set(1)
bpy.ops.wm.usd_import(filepath=sys.argv[1], import_visible_only=False, set_frame_range=True)
answer = {"range": [bpy.context.scene.frame_start, bpy.context.scene.frame_end]}
for frame in (2, 5, 8):
    bpy.context.scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    for name in ("epoch_00", "epoch_01"):
        object = bpy.data.objects[name].evaluated_get(graph)
        mesh = object.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        world = points.reshape(-1, 3) @ np.array(object.matrix_world)[:3, :3].T
        uv = np.empty(2 * len(mesh.loops), np.float32)
        if mesh.uv_layers:
            mesh.uv_layers[0].data.foreach_get("uv", uv)
        strain = mesh.attributes.get("strain")
        answer[f"{name} {frame}"] = {
            "vertices": len(mesh.vertices),
            "triangles": len(mesh.polygons),
            "z": float(world[:, 2].max()),
            "uv": [mesh.uv_layers[0].name if mesh.uv_layers else None, float(uv.max()), float(uv.std())],
            "strain": None if strain is None else float(np.array([each.value for each in strain.data]).mean()),
            "custom_normals": bool(mesh.has_custom_normals),
            "down": float(min(normal.vector.z for normal in mesh.corner_normals)),
            "size": float(np.ptp(world[:, 0])),
        }
        object.to_mesh_clear()
print("ANSWER " + json.dumps(answer))
"""


@pytest.mark.slow
def test_blender_imports_points_texture_normals_and_strain_on_every_frame_and_shows_one_epoch(
    cache: Path, program: Program
) -> None:
    pytest.importorskip("bpy")
    done = subprocess.run(
        [sys.executable, "-c", _IMPORT, str(cache)], capture_output=True, text=True, timeout=240, check=False
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("ANSWER ")]
    assert lines, done.stdout[-2000:] + done.stderr[-2000:]
    answer: dict[str, Any] = json.loads(lines[0][7:])
    assert answer["range"] == [1, 8]
    for frame in (2, 5, 8):
        for index in (0, 1):
            seen, surface = answer[f"epoch_{index:02d} {frame}"], program.epochs[index].surface
            assert (seen["vertices"], seen["triangles"]) == (len(surface.points), len(surface.triangles))
            assert seen["uv"][0] == "st"
            assert seen["uv"][1] == pytest.approx(surface.uv.max(), abs=1e-5)
            assert seen["uv"][2] > 0.01
            assert seen["strain"] == pytest.approx(0.1)
            assert seen["custom_normals"]
            assert seen["down"] < -0.99
    shown = {2: 0, 5: 1, 8: 1}
    for frame, index in shown.items():
        assert answer[f"epoch_{index:02d} {frame}"]["size"] == pytest.approx(0.024, rel=1e-3)  # metres
        assert answer[f"epoch_{1 - index:02d} {frame}"]["size"] < 1e-7
    heights = [answer[f"epoch_01 {frame}"]["z"] for frame in (5, 8)]
    assert heights[1] > heights[0]
