"""A skin cache looks right in other programs: materials, threads, hooks, steps, looks, and nothing that is planned."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade, UsdValidation

from lappet.anatomy.tissue_kind import KIND_COLORS
from lappet.drawing.quantity_scale import frame_peak, full_value, ramp_linear
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.surface_look import MUCOSA_LOOK, PLAIN_COLOR, SKIN_LOOK
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.output.skin_cache import write_skin_cache
from lappet.procedure import Scenery
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure

SKIN = "/Procedure/Skin"


@pytest.fixture(scope="module")
def program() -> Program:
    return compile_program(small_procedure())


@pytest.fixture(scope="module")
def cache(program: Program, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dressed")
    frames = solve_program(program, FrameStore(folder / "s"), FakeSolver().connect, "fake", SolveObserver()).frames
    write_procedure(small_procedure(), folder / "p.usda")
    solved = [frame.solved for frame in frames]
    write_skin_cache(folder / "skin.usdc", folder / "p.usda", small_procedure(), program, solved, "key")
    return folder / "skin.usdc"


def looked_at(cache: Path, **selected: str) -> Usd.Stage:
    """The stage with these variants chosen."""
    stage = Usd.Stage.Open(str(cache))
    stage.SetEditTarget(stage.GetSessionLayer())
    for name, variant in selected.items():
        assert stage.GetPrimAtPath(SKIN).GetVariantSet(name).SetVariantSelection(variant)
    return stage


def color_of(material: UsdShade.Material) -> tuple[float, ...] | str:
    """The color of a material's surface, or the primvar from which it comes."""
    shader = material.ComputeSurfaceSource()[0]
    assert shader.GetIdAttr().Get() == "UsdPreviewSurface"
    color = shader.GetInput("diffuseColor")
    if color.HasConnectedSource():
        return str(UsdShade.Shader(color.GetConnectedSource()[0].GetPrim()).GetInput("varname").Get())
    return tuple(round(float(each), 4) for each in color.Get())


def face_colors(stage: Usd.Stage, epoch: int) -> list[Any]:
    """The color of each face of an epoch's mesh."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"{SKIN}/epoch_{epoch:02d}"))
    colors: list[Any] = [None] * len(mesh.GetFaceVertexCountsAttr().Get())
    for subset in UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets():
        color = color_of(UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial()[0])
        for face in subset.GetIndicesAttr().Get():
            assert colors[face] is None
            colors[face] = color
    return colors


def drawn(stage: Usd.Stage, time: float) -> set[str]:
    """Names of the prims that a viewer draws at a time: visible, of no special purpose, not shrunk to nothing."""
    found = set()
    for prim in stage.Traverse():
        shape = UsdGeom.Gprim(prim)
        if not shape or shape.ComputePurpose() != "default" or shape.ComputeVisibility(time) == "invisible":
            continue
        if shape.ComputeLocalToWorldTransform(time).GetDeterminant() and prim.GetAttribute("points").Get(time):
            found.add(prim.GetName())
    return found


@pytest.mark.parametrize("look", ["natural", "plain", "strain"])
def test_no_validator_of_usd_complains_of_any_look(cache: Path, look: str) -> None:
    stage = looked_at(cache, look=look, instruments="hidden" if look == "plain" else "shown")
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []


def test_every_face_has_the_color_of_what_it_shows(cache: Path, program: Program) -> None:
    origin = program.epochs[1].surface.origin
    colors = face_colors(looked_at(cache), 1)
    skin, cut = (tuple(round(each, 4) for each in color) for color in (SKIN_LOOK.color, KIND_COLORS["skin"]))
    assert {colors[k] for k in np.flatnonzero(origin == FaceOrigin.SKIN)} == {skin}
    for each in (FaceOrigin.WOUND_WALL, FaceOrigin.UNDERSIDE):
        assert {colors[k] for k in np.flatnonzero(origin == each)} == {cut}
    (rim,) = {colors[k] for k in np.flatnonzero(origin == FaceOrigin.RIM)}
    assert all(min(a, b) < r < max(a, b) for r, a, b in zip(rim, skin, cut, strict=True))


def test_the_plain_look_is_gray_all_over_and_its_threads_are_not(cache: Path) -> None:
    stage = looked_at(cache, look="plain")
    assert set(face_colors(stage, 1)) == {PLAIN_COLOR}
    thread = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(f"{SKIN}/Instruments/Threads")).ComputeBoundMaterial()[0]
    assert color_of(thread) != PLAIN_COLOR


def test_the_strain_look_colors_the_skin_by_its_strain(cache: Path, program: Program) -> None:
    stage = looked_at(cache, look="strain")
    origin = program.epochs[1].surface.origin
    colors = face_colors(stage, 1)
    assert {colors[k] for k in np.flatnonzero(origin == FaceOrigin.SKIN)} == {"strainColor"}
    mesh = stage.GetPrimAtPath(f"{SKIN}/epoch_01")
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("strainColor")
    flat = np.array(primvar.ComputeFlattened(5.0))
    assert len(flat) == len(program.epochs[1].surface.points)
    share = 0.1 / full_value(frame_peak(np.full(3, 0.1, np.float32)))
    assert np.allclose(flat, ramp_linear(np.array([share])), atol=0.03)  # one of 64 shades
    natural = looked_at(cache)
    assert not UsdGeom.PrimvarsAPI(natural.GetPrimAtPath(f"{SKIN}/epoch_01")).HasPrimvar("strainColor")


def test_a_cache_without_strain_has_no_such_look(program: Program, tmp_path: Path) -> None:
    frames = solve_program(program, FrameStore(tmp_path / "s"), FakeSolver().connect, "fake", SolveObserver()).frames
    write_procedure(small_procedure(), tmp_path / "p.usda")
    bare = [frame.solved.without_scalars() for frame in frames]
    write_skin_cache(tmp_path / "c.usdc", tmp_path / "p.usda", small_procedure(), program, bare, "key")
    stage = Usd.Stage.Open(str(tmp_path / "c.usdc"))
    looks = stage.GetPrimAtPath(SKIN).GetVariantSet("look")
    assert (looks.GetVariantNames(), looks.GetVariantSelection()) == (["natural", "plain"], "natural")


def test_a_viewer_draws_one_epoch_and_what_acts_and_nothing_that_is_planned(cache: Path) -> None:
    stage = looked_at(cache)
    assert drawn(stage, 2.0) == {"epoch_00", "Landmarks"}
    assert drawn(stage, 3.0) == {"epoch_01", "Landmarks", "Bed"}
    assert drawn(stage, 4.0) == {"epoch_01", "Landmarks", "Bed", "SkinHooks"}
    assert drawn(stage, 6.0) == {"epoch_01", "Landmarks", "Bed", "SkinHooks", "Threads"}
    assert drawn(stage, 8.0) == {"epoch_01", "Landmarks", "Bed", "Threads"}
    without = looked_at(cache, instruments="hidden")
    assert drawn(without, 6.0) == {"epoch_01", "Landmarks", "Bed"}


def test_threads_are_tubes_through_the_places_that_pictures_show(cache: Path) -> None:
    from lappet.drawing.framing import surgical_field
    from lappet.drawing.suture_thread import SutureThread

    stage = looked_at(cache)
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath(f"{SKIN}/Instruments/Threads"))
    source = SkinCache(cache)
    field = surgical_field(source, source.frames)
    lines, radii = SutureThread(source, field.right + 0.6 * field.up, field.stitch_scale).tubes(8.0)
    assert list(curves.GetCurveVertexCountsAttr().Get(8.0)) == [len(line) for line in lines]
    points, widths = np.array(curves.GetPointsAttr().Get(8.0)), np.array(curves.GetWidthsAttr().Get(8.0))
    assert np.allclose(points, np.concatenate(lines), atol=1e-5)
    assert np.allclose(widths, 2.0 * radii[0])
    low, high = np.array(curves.GetExtentAttr().Get(8.0))
    assert (points - 0.5 * widths[:, None] >= low - 1e-5).all()
    assert (points + 0.5 * widths[:, None] <= high + 1e-5).all()


def test_stitches_that_a_thread_finds_are_drawn_once_it_has_found_them(cache: Path) -> None:
    from lappet.drawing.framing import surgical_field
    from lappet.drawing.suture_thread import SutureThread

    class Later:
        """What is found when somebody says so."""

        def __init__(self, find: Callable[[], dict]) -> None:
            self.take, self.done = find, False
            begun.append(self)

    begun: list[Later] = []
    source = SkinCache(cache)
    field = surgical_field(source, source.frames)
    facing = field.right + 0.6 * field.up
    wanted = SutureThread(source, facing, field.stitch_scale).named_lines(8.0)
    thread = SutureThread(source, facing, field.stitch_scale)
    thread.begin = Later
    for _ in range(2):
        assert thread.named_lines(8.0) == {}
        assert thread.pending is begun[0]
    begun[0].done = True
    found = thread.named_lines(8.0)
    assert thread.pending is None
    assert len(begun) == 1
    assert found.keys() == wanted.keys()
    assert all(np.array_equal(found[key], line) for key, line in wanted.items())


def test_the_steps_follow_one_another_from_the_first_frame_to_the_last(cache: Path) -> None:
    stage = looked_at(cache)
    steps = stage.GetPrimAtPath(f"{SKIN}/Steps").GetChildren()
    spans = [tuple(step.GetAttribute(f"lappet:{name}").Get() for name in ("start", "end")) for step in steps]
    captions = [step.GetAttribute("lappet:caption").Get() for step in steps]
    assert captions == ["Before", "Incised", "Lifted with hooks", "Drawn together", "Sutured", "Final result"]
    assert spans[0] == (1.0, 1.0)
    assert [start for start, _ in spans[1:]] == [end for _, end in spans[:-1]]
    assert spans[-1][1] == 8.0
    assert [step.GetDisplayName() for step in steps] == captions


def test_the_cache_is_one_component_and_opens_without_its_procedure(cache: Path, tmp_path: Path) -> None:
    stage = looked_at(cache)
    assert Usd.ModelAPI(stage.GetPrimAtPath("/Procedure")).GetKind() == "component"
    alone = tmp_path / "alone.usdc"
    alone.write_bytes(cache.read_bytes())
    assert drawn(Usd.Stage.Open(str(alone)), 6.0) == {"epoch_01", "Landmarks", "Bed", "SkinHooks", "Threads"}


def test_what_stands_around_the_tissue_is_dressed_too_and_its_rim_is_no_cut(tmp_path: Path) -> None:
    around = Scenery("rest", np.array([[-30.0, -20, 0], [30, -20, 0], [0, 30, 0]]), [3], [0, 1, 2])
    own = small_procedure(scenery=(around,))
    program = compile_program(own)
    frames = solve_program(program, FrameStore(tmp_path / "s"), FakeSolver().connect, "fake", SolveObserver()).frames
    write_procedure(own, tmp_path / "p.usda")
    write_skin_cache(tmp_path / "c.usdc", tmp_path / "p.usda", own, program, [each.solved for each in frames], "key")
    stage = looked_at(tmp_path / "c.usdc")
    binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/Procedure/Scenery/rest"))
    assert binding.ComputeBoundMaterial()[0].GetPrim().GetName() == "Skin"
    rim = np.flatnonzero(program.epochs[0].surface.origin == FaceOrigin.RIM)
    colors = face_colors(stage, 0)
    assert {colors[k] for k in rim} == {MUCOSA_LOOK.color}
    assert "rest" in drawn(stage, 1.0)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert not UsdValidation.ValidationContext(validators).Validate(stage)


_IMPORT = """
import json, sys
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[1])
scene = bpy.context.scene
answer = {"range": [scene.frame_start, scene.frame_end], "objects": sorted(each.name for each in bpy.data.objects)}
mesh = bpy.data.objects["epoch_01"].data
names = [each.name if each else "" for each in mesh.materials]
answer["faces"] = [names[each.material_index] for each in mesh.polygons]
surfaces = {each.name: next(n for n in each.node_tree.nodes if n.inputs)
    for each in mesh.materials if each}
answer["colors"] = {name: list(node.inputs["Base Color"].default_value) for name, node in surfaces.items()}
print("ANSWER " + json.dumps(answer))
"""


@pytest.mark.slow
def test_blender_imports_materials_and_frames_without_a_warning(cache: Path, program: Program) -> None:
    pytest.importorskip("bpy")
    command = [sys.executable, "-c", _IMPORT, str(cache)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith("ANSWER ")]
    assert lines, done.stdout[-2000:] + done.stderr[-2000:]
    said = (done.stdout + done.stderr).lower()
    assert "warn" not in said
    assert "cannot be converted" not in said
    answer: dict[str, Any] = json.loads(lines[0][7:])
    assert answer["range"] == [1, 8]
    shown = {"Bed", "Instruments", "Landmarks", "Procedure", "Skin", "SkinHooks", "Threads", "Wound"}
    assert set(answer["objects"]) == shown | {"epoch_00", "epoch_01"}
    by_origin = {FaceOrigin.SKIN: "Skin", FaceOrigin.WOUND_WALL: "CutSkin", FaceOrigin.RIM: "RimSkin"}
    faces, origin = np.array(answer["faces"]), program.epochs[1].surface.origin
    for each, name in by_origin.items():
        assert set(faces[origin == each]) == {name}
    assert answer["colors"]["Skin"][:3] == pytest.approx(SKIN_LOOK.color, abs=1e-5)
