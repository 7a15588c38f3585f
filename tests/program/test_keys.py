"""Keys say what a frame depends on: all of it, and nothing else."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from lappet.cutting.epoch import Regions
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Hook, Landmark, Material, Procedure, Suture
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.program.program import Bones, Program
from lappet.program.settings import MaterialParameters
from small_procedure import TOP, small_procedure


@pytest.fixture(scope="module")
def program() -> Program:
    return compile_program(small_procedure())


def keys_of(procedure: Procedure, program: Program) -> tuple[str, ...]:
    """The keys of a procedure that has the topology of `program`."""
    return frame_keys(compile_program(procedure, program.epochs), "solver 1")


def first_difference(a: tuple[str, ...], b: tuple[str, ...]) -> int | None:
    return next((i for i, (x, y) in enumerate(zip(a, b, strict=True)) if x != y), None)


def test_the_same_procedure_has_the_same_keys_and_no_two_frames_share_one(program: Program) -> None:
    again = frame_keys(compile_program(small_procedure()), "solver 1")
    assert again == frame_keys(program, "solver 1")
    assert len(set(again)) == len(program.frames) == 8


def test_an_edit_changes_the_keys_from_its_frame_on(program: Program) -> None:
    base = frame_keys(program, "solver 1")
    procedure = small_procedure()
    moved = replace(procedure.event("hook"), targets=((4.0, (0.0, 2.0, TOP)), (6.0, (0.0, 5.0, TOP))))  # type: ignore[type-var]
    edited = replace(procedure, events=tuple(moved if e.name == "hook" else e for e in procedure.events))
    changed = keys_of(edited, program)
    assert first_difference(base, changed) == 4  # frame 5: at frame 4 the target is the same
    assert all(a != b for a, b in zip(base[4:], changed[4:], strict=True))


def test_what_is_added_late_leaves_the_frames_before_alone_wherever_it_stands_in_the_list(program: Program) -> None:
    base = frame_keys(program, "solver 1")
    procedure = small_procedure()
    late = Suture("a_late_one", ((4.0, -1.0, TOP), (4.0, 1.0, TOP)), 7.0, 1.0)
    for events in ((*procedure.events, late), (late, *procedure.events)):
        assert first_difference(base, keys_of(replace(procedure, events=events), program)) == 6


def test_names_notes_and_texture_are_in_no_key(program: Program) -> None:
    base = frame_keys(program, "solver 1")
    procedure = small_procedure()
    renamed = tuple(replace(e, name=f"{e.name}_2") for e in procedure.events)
    assert keys_of(replace(procedure, events=renamed), program) == base
    surfaces = [replace(epoch, surface=replace(epoch.surface, uv=epoch.surface.uv + 1)) for epoch in program.epochs]
    assert frame_keys(replace(program, epochs=tuple(surfaces)), "solver 1") == base


@pytest.mark.parametrize(
    "change",
    [
        {"spacing": 0.5},
        {"tolerance": 1e-4},
        {"quadrature": 8},
        {"precision": "double"},
        *(
            {"materials": (replace(MaterialParameters(), **{item.name: value}),)}
            for item, value in zip(
                fields(MaterialParameters),
                ("corotated", 51.0, 0.4, 1000.0, 0.1, (0.0, 1.0, 0.0), 1.0, 1.0, 0.1, 1.1, 20.0, 300.0, (1.1, 1.0)),
                strict=True,
            )
        ),
        {"materials": (MaterialParameters(), MaterialParameters())},
        {"gravity": (0.0, 0.0, -9.8)},
        {"bed_stiffness": 11.0},
        {"bed_shear": 0.25},
    ],
)
def test_settings_that_change_the_solution_change_every_key(program: Program, change: dict[str, object]) -> None:
    base = frame_keys(program, "solver 1")
    changed = frame_keys(replace(program, settings=replace(program.settings, **change)), "solver 1")  # type: ignore[arg-type]
    assert not set(base) & set(changed)


@pytest.mark.parametrize("change", [{"threads": 2}, {"memory_budget": 1}, {"time_budget": 9.0}, {"sutures": 7}])
def test_settings_that_do_not_change_the_solution_change_no_key(program: Program, change: dict[str, int]) -> None:
    changed = replace(program, settings=replace(program.settings, **change))  # type: ignore[arg-type]
    assert frame_keys(changed, "solver 1") == frame_keys(program, "solver 1")


def test_a_bone_and_where_it_lies_is_in_every_key(program: Program) -> None:
    base = frame_keys(program, "solver 1")
    points = np.array([[0, 0, -9], [4, 0, -9], [0, 4, -9], [0, 0, -5]], float)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
    here = frame_keys(replace(program, bones=Bones(points, triangles)), "solver 1")
    there = frame_keys(replace(program, bones=Bones(points - [0, 0, 1e-9], triangles)), "solver 1")
    assert len({*base, *here, *there}) == 3 * len(base)


def test_another_solver_changes_every_key(program: Program) -> None:
    assert not set(frame_keys(program, "solver 1")) & set(frame_keys(program, "solver 2"))


def test_one_vertex_or_one_fixed_face_changes_the_keys_of_its_epoch_on(program: Program) -> None:
    base = frame_keys(program, "solver 1")
    last = program.epochs[-1]
    points = last.surface.points.copy()
    points[3, 1] = np.nextafter(points[3, 1], np.inf)
    fixed = last.surface.fixed.copy()
    fixed[5] ^= True
    for surface in (replace(last.surface, points=points), replace(last.surface, fixed=fixed)):
        epochs = (*program.epochs[:-1], replace(last, surface=surface))
        assert first_difference(base, frame_keys(replace(program, epochs=epochs), "solver 1")) == 2


def test_every_part_of_a_region_is_in_the_keys_of_its_epoch_on(program: Program) -> None:
    skin = Regions(
        np.array([[0.0, 0.0, TOP], [1.0, 0.0, TOP], [0.0, 1.0, TOP]]),
        np.array([[0, 1, 2]], np.int32),
        np.array([[True]]),
        np.array([0], np.int32),
        np.array([1.0]),
        np.array([np.inf]),
    )

    def keys(regions: Regions) -> tuple[str, ...]:
        epochs = (*program.epochs[:-1], replace(program.epochs[-1], regions=regions))
        return frame_keys(replace(program, epochs=epochs), "solver 1")

    variants = [
        Regions(),
        skin,
        replace(skin, skin_points=skin.skin_points + 1.0),
        replace(skin, skin_triangles=skin.skin_triangles[:, ::-1]),
        replace(skin, faces=~skin.faces),
        replace(skin, material=skin.material + 1),
        replace(skin, depth_from=skin.depth_from + 0.5),
        replace(skin, depth_to=np.array([3.0])),
    ]
    found = [keys(regions) for regions in variants]
    assert len({each[-1] for each in found}) == len(variants)
    assert all(first_difference(found[0], each) == 2 for each in found[1:])


def test_a_muscle_is_in_the_keys_from_where_it_first_differs(program: Program) -> None:
    muscle = Material("skin", muscle_stress=300.0, muscle_activation=((2.0, 0.0), (8.0, 1.0)))
    base = keys_of(small_procedure(materials=(muscle,)), program)
    later = replace(muscle, muscle_activation=((2.0, 0.0), (5.0, 0.5), (8.0, 0.9)))
    assert first_difference(base, keys_of(small_procedure(materials=(later,)), program)) == 5  # frame 6
    slack = (Material("skin", muscle_activation=later.muscle_activation),)
    assert keys_of(small_procedure(materials=slack), program) == frame_keys(program, "solver 1")


def test_a_material_that_is_not_in_use_or_has_no_effect_is_in_no_key(program: Program) -> None:
    base = frame_keys(program, "solver 1")
    idle = Material("skin", mooney_ratio=2.0, fiber_k2=3.0, fiber_dispersion=0.1, fiber_direction=(0, 1, 0))
    assert keys_of(small_procedure(materials=(Material("fat", youngs_modulus=3.0), idle)), program) == base


def test_whether_a_free_face_rests_on_the_bed_is_in_the_keys(program: Program) -> None:
    """The daemon is not told of origins, but an underside face without attachment rests on its bed."""
    last = program.epochs[-1].surface
    below = np.flatnonzero(last.bed)[0]
    freed = last.bed.copy()
    freed[below] = False
    walled = last.origin.copy()
    walled[below] = FaceOrigin.WOUND_WALL
    variants = [
        frame_keys(replace(program, epochs=(*program.epochs[:-1], replace(program.epochs[-1], surface=surface))), "s")
        for surface in (last, replace(last, bed=freed), replace(last, bed=freed, origin=walled))
    ]
    assert len({keys[-1] for keys in variants}) == 3


def test_a_minus_zero_is_a_zero(program: Program) -> None:
    procedure = small_procedure()
    hook = Hook("hook", (0.0, 2.0, TOP), ((4.0, (0.0, 2.0, TOP)), (6.0, (0.0, 4.0, TOP + 2.0))), 4.0, 7.0)
    minus = replace(hook, targets=tuple((t, (-0.0, y, z)) for t, (_, y, z) in hook.targets))
    edited = replace(procedure, events=tuple(minus if e.name == "hook" else e for e in procedure.events))
    assert keys_of(edited, program) == frame_keys(program, "solver 1")


def test_a_landmark_is_measured_by_the_solver_so_it_is_in_the_keys(program: Program) -> None:
    procedure = small_procedure()
    more = procedure.with_events(Landmark("other", ((3.0, 3.0, TOP),), "other"))
    assert first_difference(frame_keys(program, "solver 1"), keys_of(more, program)) == 0
