"""A procedure compiles to what acts in every frame, and what makes no sense is refused with the prim's path."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import (
    Bone,
    Hook,
    Incision,
    Landmark,
    Material,
    Procedure,
    Region,
    Retractor,
    Suture,
    Undermine,
)
from lappet.program.compile import compile_program, frame_times
from lappet.program.keys import frame_keys
from lappet.program.payloads import solve_payload
from lappet.program.program import Program
from lappet.program.settings import MaterialParameters, SolverSettings
from lappet.tissue.patch import flat_patch
from lappet.tissue.surface import skin_faces
from refusals import refuses
from slit_program import compiled
from small_procedure import TOP, small_procedure


@pytest.fixture(scope="module")
def program() -> Program:
    return compile_program(small_procedure())


def test_frames_are_the_whole_time_codes_and_belong_to_the_last_epoch_begun(program: Program) -> None:
    assert [frame.time for frame in program.frames] == [1, 2, 3, 4, 5, 6, 7, 8]
    assert [frame.epoch for frame in program.frames] == [0, 0, 1, 1, 1, 1, 1, 1]
    assert frame_times(small_procedure(start_time=0.5, end_time=3.5)) == [1, 2, 3]
    with refuses(ProblemCode.TIMELINE_NO_FRAME, "/Procedure"):
        frame_times(small_procedure(start_time=3.0, end_time=2.0))


def test_a_hook_acts_from_its_start_until_before_its_release(program: Program) -> None:
    assert [len(frame.hook_index) for frame in program.frames] == [0, 0, 0, 1, 1, 1, 0, 0]
    assert [len(frame.hook_stiffness) for frame in program.frames] == [0, 0, 0, 1, 1, 1, 0, 0]


def test_a_target_is_linear_between_samples_and_held_at_the_ends(program: Program) -> None:
    hook = Hook("h", (0.0, 3.0, TOP), ((6.0, (4.0, 0.0, 8.0)), (3.0, (1.0, 3.0, 2.0))), 1.0, 9.0)
    targets = np.concatenate([frame.hook_targets for frame in compiled(program, hook).frames])
    expected = [(1, 3, 2)] * 3 + [(2, 2, 4), (3, 1, 6)] + [(4, 0, 8)] * 3
    assert np.allclose(targets, expected)


@pytest.mark.parametrize(
    ("start", "duration", "closures"),
    [
        (5.0, 2.0, [0.0, 0.5, 1.0, 1.0]),
        (4.5, 2.0, [0.25, 0.75, 1.0, 1.0]),
        (6.0, 0.0, [1.0, 1.0, 1.0]),
        (8.0, 5.0, [0.0]),
    ],
)
def test_a_suture_closes_over_its_duration_and_stays(
    program: Program, start: float, duration: float, closures: list[float]
) -> None:
    suture = Suture("s", ((2.0, -1.0, TOP), (2.0, 1.0, TOP)), start, duration, 77.0)
    frames = compiled(program, suture).frames
    placed = [frame for frame in frames if len(frame.suture_index)]
    assert [frame.time for frame in placed] == [time for time in range(1, 9) if time >= start]
    assert [float(frame.suture_closure[0]) for frame in placed] == pytest.approx(closures)
    assert {float(frame.suture_stiffness[0]) for frame in placed} == {77.0}
    assert all(not len(frame.suture_is_thread) for frame in frames)


def test_threads_tell_their_stiffness_length_and_tension(program: Program) -> None:
    ends = ((2.0, -2.0, TOP), (2.0, 2.0, TOP))
    free = Suture("free", ends, 4.0, stiffness=77.0, mode="thread", length=0.5)
    nylon = Suture("nylon", ends, 5.0, mode="thread", thread="nylon 5-0", length=1.0, tension=300.0)
    exact = Suture("exact", ends, 6.0, thread="nylon 5-0")
    last = compiled(program, free, nylon, exact).frames[-1]
    assert last.suture_is_thread.tolist() == [1, 1, 0]
    assert last.suture_length.tolist() == [0.5, 1.0, 0.0]
    assert last.suture_tension.tolist() == [0.0, 300.0, 0.0]
    # E A / length of 2500 MPa, 0.125 mm and 4 mm
    assert last.suture_stiffness[:2].tolist() == pytest.approx([77.0, 2.5e6 * np.pi * 0.125**2 / 4.0 / 4.0])


def test_threads_tell_the_bites_between_their_ends_in_order(program: Program) -> None:
    two = Suture("two", ((2.0, -2.0, TOP), (2.0, 2.0, TOP)), 4.0, mode="thread")
    bites = ((-4.0, -2.0, TOP), (-4.0, -2.0, 1.0), (-4.0, 2.0, 1.0), (-4.0, 2.0, TOP), (-4.0, -2.0, TOP))
    loop = Suture("loop", bites, 5.0, mode="thread", thread="nylon 5-0", length=10.0)
    three = Suture("three", ((6.0, -2.0, TOP), (6.0, 2.0, TOP), (9.0, -2.0, TOP)), 6.0, mode="thread")
    frames = compiled(program, two, loop, three).frames
    assert all(not len(frame.suture_inner_bites) for frame in frames if frame.time < 5.0)
    last = frames[-1]
    assert last.suture_inner_bites.tolist() == [0, 3, 1]
    assert last.suture_anchors[1].tolist() == [list(bites[0]), list(bites[-1])]
    assert last.inner_bite_anchors.tolist() == [*map(list, bites[1:4]), [6.0, 2.0, TOP]]
    assert last.inner_bite_triangles.shape == (4,)
    # E A over all of it
    assert last.suture_stiffness[1] == pytest.approx(2.5e6 * np.pi * 0.125**2 / 4.0 / (8.0 + 2.0 * (TOP - 1.0)))
    told = solve_payload(last).arrays
    assert told["suture_inner_bites"].tolist() == [0, 3, 1]
    assert "inner_bite_anchors" not in solve_payload(frames[3]).arrays


def test_sutures_are_numbered_by_their_start(program: Program) -> None:
    late = Suture("late", ((3.0, -1.0, TOP), (3.0, 1.0, TOP)), 7.0)
    early = Suture("early", ((2.0, -1.0, TOP), (2.0, 1.0, TOP)), 5.0)
    made = compiled(program, late, early)
    assert made.sutures == ("early", "late")
    assert [list(frame.suture_index) for frame in made.frames[4:]] == [[0], [0], [0, 1], [0, 1]]


def gripped(*retractors: Retractor, subsets: dict[str, list[int]] | None = None) -> Program:
    tissue = flat_patch((24.0, 16.0, TOP), resolution=2.0)
    top = [
        i
        for i, face in enumerate(tissue.face_vertex_indices.reshape(-1, 4))
        if (tissue.points[face][:, 2] == TOP).all()
    ]
    named = {"flap": top[:4], "other": top[10:14]} if subsets is None else subsets
    grips = {name: np.array(faces, np.int32) for name, faces in named.items()}
    tissue = replace(tissue, subsets={**tissue.subsets, **grips})
    return compile_program(small_procedure(tissue=tissue, events=retractors))


def matrix(translate: tuple[float, float, float] = (0.0, 0.0, 0.0), turn: float = 0.0, scale: float = 1.0) -> Any:
    """A matrix in USD's row-vector convention: scale, then a turn about z, then a translation."""
    c, s = np.cos(turn), np.sin(turn)
    rows = np.eye(4)
    rows[:3, :3] = scale * np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    rows[3, :3] = translate
    return tuple(rows.ravel())


def test_a_retractor_moves_relative_to_its_start_in_the_column_convention() -> None:
    motion = ((2.0, matrix((10.0, 0.0, 0.0))), (6.0, matrix((10.0, 4.0, 0.0), np.pi / 2)))
    made = gripped(Retractor("pull", "flap", motion, 4.0, 7.0))
    assert [len(frame.retractor_index) for frame in made.frames] == [0, 0, 0, 1, 1, 1, 0, 0]
    assert np.allclose(made.frames[3].retractor_motion[0], np.eye(4))
    # From 4 to 6 the prim turns by 45 degrees about itself while its origin goes from (10, 2, 0) to (10, 4, 0).
    last = made.frames[5].retractor_motion[0]
    assert np.allclose(last @ [10.0, 2.0, 0.0, 1.0], [10.0, 4.0, 0.0, 1.0])
    root = np.sqrt(0.5)
    assert np.allclose(last @ [11.0, 2.0, 0.0, 1.0], [10.0 + root, 4.0 + root, 0.0, 1.0])
    assert set(np.unique(made.grips[0])) == {-1, 0}
    assert (made.grips[0] == 0).sum() == made.epochs[0].surface.grips["flap"].sum()


def test_a_constant_scale_of_the_prim_is_no_deformation_but_a_changing_one_is_refused() -> None:
    constant = RigidMotion([(1.0, matrix(scale=3.0)), (2.0, matrix((1.0, 2.0, 3.0), scale=3.0))])
    assert np.allclose(constant.at(2.0), [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    growing = ((1.0, matrix()), (2.0, matrix(scale=1.2)))
    with refuses(ProblemCode.MOTION_NOT_RIGID, "/Procedure/Timeline/pull"):
        gripped(Retractor("pull", "flap", growing, 1.0, 9.0))


@pytest.mark.parametrize("angle", [1e-12, 1e-4, 0.5, 3.0, np.pi - 1e-9, np.pi])
def test_half_way_between_two_samples_is_half_the_turn(angle: float) -> None:
    motion = RigidMotion([(0.0, matrix()), (2.0, matrix((0.0, 0.0, 6.0), angle))])
    half = motion.at(1.0)
    assert np.allclose(half[:3, :3] @ half[:3, :3], motion.at(2.0)[:3, :3], atol=1e-12)
    assert np.allclose(half[:3, :3].T @ half[:3, :3], np.eye(3), atol=1e-12)
    assert half[2, 3] == 3.0


def test_two_retractors_on_one_face_are_refused_unless_they_act_in_different_epochs() -> None:
    still = ((1.0, matrix()),)
    first, second = Retractor("a", "flap", still, 1.0, 3.0), Retractor("b", "flap", still, 3.0, 9.0)
    with refuses(ProblemCode.GRIP_SHARED, "/Procedure/Timeline/b"):
        gripped(first, second)
    apart = gripped(first, replace(second, grip="other"))
    assert set(np.unique(apart.grips[0])) == {-1, 0, 1}
    cut = Incision("slit", 3.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1)
    across = gripped(first, second, cut)  # type: ignore[arg-type]
    assert [set(np.unique(grip)) for grip in across.grips] == [{-1, 0}, {-1, 1}]


def test_a_subset_that_is_not_there_is_refused() -> None:
    with refuses(ProblemCode.GRIP_UNKNOWN, "/Procedure/Timeline/pull"):
        gripped(Retractor("pull", "nowhere", ((1.0, matrix()),), 1.0, 9.0))


def test_labels_that_two_prims_share_are_told_apart(program: Program) -> None:
    marks = [Landmark(name, ((x, 4.0, TOP),), "tip") for name, x in (("left", -8.0), ("right", 8.0))]
    assert compiled(program, *marks).landmarks == ("tip (left)", "tip (right)")


@pytest.mark.parametrize(
    ("regions", "code", "prim"),
    [
        ((), ProblemCode.TISSUE_MATERIAL_UNKNOWN, "/Procedure/Tissue"),
        ((Region("cheek", "lip"),), ProblemCode.REGION_MATERIAL_UNKNOWN, "/Procedure/Tissue/cheek"),
        (
            (Region("lid", "skin"),),
            ProblemCode.REGION_NO_SUBSET,
            "/Procedure/Tissue/lid",
        ),
        ((Region("bed", "skin"),), ProblemCode.REGION_NO_SUBSET, "/Procedure/Tissue/bed"),
    ],
)
def test_a_material_or_a_region_that_is_not_there_is_refused(
    program: Program, regions: tuple[Region, ...], code: ProblemCode, prim: str
) -> None:
    tissue = small_procedure().tissue
    tissue = replace(tissue, subsets={**tissue.subsets, "cheek": [0]}, regions=regions)
    materials = (Material("skin" if regions else "fat"),)
    with refuses(code, prim):
        compile_program(small_procedure(tissue=tissue, materials=materials), program.epochs)


def _painted() -> Procedure:
    """Fat below 1 mm everywhere, muscle throughout where x > 4; a material that nothing is made of."""
    tissue = small_procedure().tissue
    corners = tissue.face_vertex_indices.reshape(len(tissue.face_vertex_counts), -1)
    skin = np.flatnonzero(skin_faces(tissue))
    right = skin[tissue.points[corners[skin]][:, :, 0].min(axis=1) >= 4.0]
    return small_procedure(
        tissue=replace(
            tissue,
            subsets={**tissue.subsets, "all": skin, "right": right},
            regions=(Region("right", "muscle"), Region("all", "fat", 1.0)),
        ),
        materials=(
            Material("unused", fiber_k1=9.0),
            Material("muscle", "stableNeoHookean", 20.0, muscle_stress=300.0, fiber_direction=(0, 3, 4),
                     muscle_activation=((6.0, 1.0), (2.0, 0.2))),
            Material("fat", "mooneyRivlin", 5.0, mooney_ratio=0.5, fiber_k2=3.0, fiber_direction=(0, 0, 9)),
            Material("skin"),
        ),
    )  # fmt: skip


def test_the_table_holds_what_is_in_use_and_what_has_an_effect(program: Program) -> None:
    settings = compile_program(_painted(), program.epochs).settings
    assert settings.materials == (
        MaterialParameters(),
        MaterialParameters("mooneyRivlin", 5.0, mooney_ratio=0.5),
        MaterialParameters("stableNeoHookean", 20.0, fiber_direction=(0.0, 0.6, 0.8), muscle_stress=300.0),
    )


def test_the_regions_lie_on_the_uncut_skin_in_every_epoch() -> None:
    made = compile_program(_painted())
    assert len(made.epochs) == 2
    for epoch in made.epochs:
        regions = epoch.regions
        assert regions.material.tolist() == [1, 2]
        assert regions.depth_from.tolist() == [1.0, 0.0]
        assert np.isinf(regions.depth_to).all()
        corners = regions.skin_points[regions.skin_triangles]
        assert (corners[:, :, 2] == TOP).all()
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        assert areas.sum() == pytest.approx(24.0 * 16.0)  # no slit in it
        assert regions.faces[0].all()
        assert areas[regions.faces[1]].sum() == pytest.approx(8.0 * 16.0)
        np.testing.assert_array_equal(regions.faces[1], corners[:, :, 0].min(axis=1) >= 4.0)


def test_the_activation_is_linear_between_samples_and_held_at_the_ends(program: Program) -> None:
    frames = compile_program(_painted(), program.epochs).frames
    found = np.array([frame.activation for frame in frames])
    assert found.shape == (8, 3)
    assert (found[:, :2] == 0.0).all()
    assert found[:, 2] == pytest.approx([0.2, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0])


def test_a_procedure_without_regions_and_muscle_says_nothing_of_them(program: Program) -> None:
    assert all(len(epoch.regions) == 0 and len(epoch.regions.skin_points) == 0 for epoch in program.epochs)
    assert all(len(frame.activation) == 0 for frame in program.frames)
    assert program.settings.materials == (MaterialParameters(),)


def test_the_settings_are_those_of_the_procedure_and_of_the_call(program: Program) -> None:
    procedure = small_procedure(materials=(Material("skin", "corotated", 30.0, 0.4, density=900.0),))
    procedure = replace(procedure, tissue=replace(procedure.tissue, gravity=9.81, bed_stiffness=4.0, bed_shear=2.0))
    asked = SolverSettings(spacing=0.5, tolerance=1e-4, quadrature=8, precision="double", threads=2)
    settings = compile_program(procedure, program.epochs, asked).settings
    assert settings.materials == (MaterialParameters("corotated", 30.0, 0.4, 900.0),)
    assert (settings.spacing, settings.tolerance, settings.quadrature, settings.precision) == (0.5, 1e-4, 8, "double")
    assert (settings.gravity, settings.bed_stiffness, settings.bed_shear) == ((0.0, 0.0, -9.81), 4.0, 2.0)
    assert settings.threads == 2
    assert settings.origin == (-12.0, -8.0, 0.0)
    assert (settings.sutures, settings.retractors) == (1, 0)


def test_another_spacing_divides_the_surface_accordingly() -> None:
    coarse, fine = (
        compile_program(small_procedure(), settings=SolverSettings(spacing=spacing)).epochs[0].surface
        for spacing in (2.0, 0.7)
    )
    assert len(fine.triangles) > 2 * len(coarse.triangles)


def test_bones_reach_the_program_as_one_closed_surface_without_faces_inside(program: Program) -> None:
    def block(name: str, x: float, turned: bool = False) -> Bone:
        mesh = flat_patch((4.0, 4.0, 3.0), 4.0, (x, 0.0))
        corners = mesh.face_vertex_indices.reshape(-1, 4)
        return Bone(
            name, mesh.points - (0, 0, 9), mesh.face_vertex_counts, (corners[:, ::-1] if turned else corners).ravel()
        )

    def volume(*bones: Bone) -> tuple[float, int]:
        made = compile_program(small_procedure(bones=bones), program.epochs)
        assert made.notes == ()
        solid = trimesh.Trimesh(made.bones.points, made.bones.triangles, process=False)
        assert solid.is_watertight
        return float(solid.volume), int(solid.body_count)

    assert len(program.bones.triangles) == 0
    assert volume(block("one", 0.0, turned=True)) == pytest.approx((48.0, 1))
    assert volume(block("one", 0.0), block("apart", 10.0)) == pytest.approx((96.0, 2))
    assert volume(block("one", 0.0), block("touching", 4.0)) == pytest.approx((96.0, 1))
    assert volume(block("one", 0.0), block("lapping", 3.0)) == pytest.approx((84.0, 1))


def test_undermined_tissue_rests_on_its_plane_but_where_bone_close_below_bears_it() -> None:
    def block(name: str, x: float, top: float) -> Bone:
        mesh = flat_patch((6.0, 16.0, 3.0), 2.0, (x, 0.0))
        points = mesh.points - np.array([0.0, 0.0, mesh.points[:, 2].max() - top])
        return Bone(name, points, mesh.face_vertex_counts, mesh.face_vertex_indices)

    def support(*bones: Bone) -> tuple[Program, NDArray[np.uint8], NDArray[np.float64]]:
        line = [(-11.0, -7.0, TOP), (11.0, -7.0, TOP), (11.0, 7.0, TOP), (-11.0, 7.0, TOP)]
        made = compile_program(small_procedure(events=(Undermine("freed", 2.0, tuple(line)),), bones=bones))
        surface = made.epochs[-1].surface
        return made, made.epochs[-1].support, surface.points[surface.triangles].mean(axis=1)

    boneless, plain, _ = support()
    # Below: close on the left, deep on the right. In the middle one lies above the skin, where nothing rests.
    bony, told, middles = support(block("near", -6.0, -0.2), block("deep", 6.0, -2.5), block("above", 0.0, TOP + 3.5))
    changed = told != plain
    assert {*plain} == {0, 1, 2}
    assert (plain[changed] == 2).all()
    assert (told[changed] == 0).all()
    aside = np.abs(middles[:, 0] + 6.0)
    assert changed[(plain == 2) & (aside < 3.0)].all()
    assert aside[changed].max() < 4.0
    assert (bony.epochs[0].support == boneless.epochs[0].support).all()
    assert frame_keys(replace(bony, bones=boneless.bones), "s")[0] == frame_keys(boneless, "s")[0]
    assert frame_keys(replace(bony, bones=boneless.bones), "s")[-1] != frame_keys(boneless, "s")[-1]


def test_frames_are_in_order_of_time_also_when_an_epoch_has_none() -> None:
    cuts = [
        Incision(f"cut_{i}", time, ((-6.0, 3.0 * i, TOP), (6.0, 3.0 * i, TOP)))
        for i, time in enumerate((3.2, 3.6, 5.0))
    ]
    made = compile_program(small_procedure(events=tuple(cuts)))
    assert all(a.time < b.time for a, b in pairwise(made.frames))
    assert [frame.epoch for frame in made.frames] == [0, 0, 0, 2, 3, 3, 3, 3]


def test_a_procedure_without_events_compiles() -> None:
    made = compile_program(Procedure(flat_patch((8.0, 8.0, 2.0)), end_time=2.0))
    assert len(made.frames) == 2
    assert made.frames[0].suture_anchors.shape == (0, 2, 3)
