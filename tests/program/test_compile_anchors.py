"""Anchors and landmarks: which triangle they are tied to, what is moved and said, and what is refused by name."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import (
    Event,
    Hook,
    Landmark,
    Suture,
)
from lappet.program.compile import compile_program
from lappet.program.program import Program
from refusals import refuses
from slit_program import compiled
from small_procedure import EXCISED, LENS, TOP, small_procedure


@pytest.fixture(scope="module")
def program() -> Program:
    return compile_program(small_procedure())


def test_bites_that_follow_each_other_on_one_spot_are_refused(program: Program) -> None:
    ends, outside = ((2.0, -2.0, TOP), (2.0, 2.0, TOP)), ((6.0, 2.0, TOP + 0.1), (6.0, 2.0, TOP))
    with refuses(ProblemCode.PROGRAM_ANCHORS_FALL_TOGETHER):
        compiled(program, Suture("thread", (*ends, *outside), 6.0, mode="thread"))
    compiled(program, Suture("thread", (*ends, outside[0], ends[0]), 6.0, mode="thread"))  # a loop that is tied


def test_an_anchor_lies_on_the_triangle_it_is_tied_to(program: Program) -> None:
    frame = program.frames[5]
    surface = program.epochs[1].surface
    for point, triangle in (
        (frame.hook_anchors[0], frame.hook_triangles[0]),
        (frame.suture_anchors[0, 0], frame.suture_triangles[0, 0]),
        (frame.suture_anchors[0, 1], frame.suture_triangles[0, 1]),
    ):
        a, b, c = surface.points[surface.triangles[triangle]]
        weights = np.linalg.lstsq(np.vstack([np.stack([a, b, c], 1), np.ones(3)]), np.append(point, 1.0), rcond=None)[0]
        assert weights.min() > -1e-9
        assert np.allclose(weights @ [a, b, c], point)
    assert np.allclose(frame.hook_anchors[0], (0.0, 2.0, TOP))


def test_the_two_ends_of_a_suture_at_the_wounds_edges_are_on_the_skin_of_either_side(program: Program) -> None:
    edge = Suture("s", ((2.0, -0.051, TOP), (2.0, 0.051, TOP)), 5.0)
    frame = compiled(program, edge).frames[-1]
    surface = program.epochs[1].surface
    triangles = frame.suture_triangles[0]
    assert [surface.origin[t] for t in triangles] == [FaceOrigin.SKIN, FaceOrigin.SKIN]
    middles = surface.points[surface.triangles[triangles]].mean(axis=1)
    assert middles[0, 1] < -0.04
    assert middles[1, 1] > 0.04


def test_an_anchor_deep_in_a_wound_is_tied_to_the_wall(program: Program) -> None:
    deep = Suture("s", ((2.0, -0.05, TOP / 2), (2.0, 0.05, TOP / 2)), 5.0)
    frame = compiled(program, deep).frames[-1]
    surface = program.epochs[1].surface
    triangles = frame.suture_triangles[0]
    assert [surface.origin[t] for t in triangles] == [FaceOrigin.WOUND_WALL, FaceOrigin.WOUND_WALL]
    assert surface.points[surface.triangles[triangles[0]]][:, 1].mean() < 0.0
    assert surface.points[surface.triangles[triangles[1]]][:, 1].mean() > 0.0


@pytest.fixture(scope="module")
def excised() -> Program:
    return compile_program(small_procedure(events=EXCISED))


@pytest.mark.parametrize(
    "event",
    [
        Hook("it", (1.0, 0.5, TOP), ((1.0, (1.0, 0.5, TOP)),), 1.0, 9.0),
        Suture("it", ((0.0, -4.0, TOP), (0.0, 1.0, TOP)), 4.0),
    ],
)
def test_an_anchor_in_excised_tissue_is_refused_by_name(excised: Program, event: Event) -> None:
    procedure = small_procedure(events=(*EXCISED, event))
    code = ProblemCode.PROGRAM_HOOK_EXCISED if isinstance(event, Hook) else ProblemCode.PROGRAM_ANCHOR_EXCISED
    with refuses(code, "/Procedure/Timeline/it"):
        compile_program(procedure, excised.epochs)


def test_a_hook_released_before_the_excision_and_anchors_on_its_edge_are_fine(excised: Program) -> None:
    hook = Hook("h", (1.0, 0.5, TOP), ((1.0, (1.0, 0.5, TOP)),), 1.0, 3.0)
    edge = Suture("s", ((0.0, -3.0, TOP), (0.0, 3.0, TOP)), 4.0)
    made = compile_program(small_procedure(events=(*EXCISED, hook, edge)), excised.epochs)
    anchors = made.frames[-1].suture_anchors[0]
    assert np.abs(anchors - edge.anchors).max() < 0.1


def test_a_landmark_ends_with_its_tissue(excised: Program) -> None:
    marks = (
        Landmark("kept", ((8.0, 4.0, TOP),), "kept"),
        Landmark("pair", ((0.0, 0.0, TOP), (9.0, 0.0, TOP)), "pair"),
    )
    made = compile_program(small_procedure(events=(*EXCISED, *marks)), excised.epochs)
    assert made.landmarks == ("kept", "pair 1", "pair 2")
    assert [list(at.index) for at in made.landmarks_at] == [[0, 1, 2], [0, 2]]


def test_anchors_inside_the_tissue_stay_where_they_are_put(program: Program) -> None:
    """On the skin, in the middle, beside the slit's wall and on the underside: not at the nearest surface."""
    deep, beside, below = (3.0, 4.0, 0.375 * TOP), (1.0, 0.0625, 0.5 * TOP), (1.0, -5.0, 0.0)
    made = compiled(
        program,
        Hook("hook", deep, ((4.0, deep),), 4.0, 9.0),
        Suture("stitch", (beside, below), 5.0),
        Landmark("mark", (deep, beside), "deep"),
    )
    frame = made.frames[-1]
    assert np.array_equal(frame.hook_anchors, [deep])
    assert np.array_equal(frame.suture_anchors, [[beside, below]])
    assert np.array_equal(made.landmarks_at[-1].points, [deep, beside])
    assert made.notes == ()
    faces = made.epochs[-1].surface.triangles[frame.suture_triangles[0]]
    corners = made.epochs[-1].surface.points[faces]
    assert (corners[0, :, 1] > 0.0).all(), "the wall on its own side of the slit"
    assert (corners[1, :, 2] == 0.0).all()


def test_an_anchor_a_little_outside_is_moved_onto_the_surface(program: Program) -> None:
    above = (3.0, 4.0, TOP + 0.49)
    made = compiled(program, Hook("hook", above, ((4.0, above),), 4.0, 9.0))
    assert np.allclose(made.frames[-1].hook_anchors, [(3.0, 4.0, TOP)], atol=1e-12)


def test_an_anchor_beyond_a_wounds_edge_is_moved_onto_it_and_said(excised: Program) -> None:
    outwards = np.array([3.0, 5.0, 0.0]) / np.sqrt(34.0)  # the lens's edge through (2.5, 1.5), its kerf 0.05 mm

    def suture(beyond: float) -> Suture:
        end = np.array([2.5, 1.5, TOP]) + (LENS.kerf / 2.0 - beyond) * outwards
        return Suture("s", ((2.5, -2.0, TOP), (float(end[0]), float(end[1]), TOP)), 4.0)

    made = compile_program(small_procedure(events=(*EXCISED, suture(0.4))), excised.epochs)
    held = made.frames[-1].suture_anchors[0]
    assert np.array_equal(held[0], (2.5, -2.0, TOP))
    assert np.linalg.norm(held[1] - suture(0.4).anchors[1]) == pytest.approx(0.4, abs=0.01)
    (note,) = made.notes
    assert (note.code, note.prim) == (ProblemCode.PROGRAM_ANCHOR_MOVED, "/Procedure/Timeline/s")
    assert note.place is not None
    assert np.allclose(note.place.points, [suture(0.4).anchors[1]])
    with refuses(ProblemCode.PROGRAM_ANCHOR_EXCISED, "/Procedure/Timeline/s"):
        compile_program(small_procedure(events=(*EXCISED, suture(0.7))), excised.epochs)


@pytest.mark.parametrize(
    "event",
    [
        Hook("it", (0.0, 2.0, TOP + 0.6), ((1.0, (0.0, 0.0, 0.0)),), 1.0, 9.0),
        Hook("it", (0.0, 2.0, 40.0), ((1.0, (0.0, 0.0, 0.0)),), 1.0, 9.0),
        Suture("it", ((2.0, -1.0, TOP), (90.0, 1.0, TOP)), 5.0),
        Landmark("it", ((0.0, -30.0, TOP),), "off"),
    ],
)
def test_an_anchor_off_the_tissue_is_refused_by_name(program: Program, event: Event) -> None:
    with refuses(ProblemCode.PROGRAM_POINT_OFF_TISSUE, "/Procedure/Timeline/it"):
        compiled(program, event)


def test_a_suture_across_nothing_is_refused(program: Program) -> None:
    with refuses(ProblemCode.PROGRAM_ANCHORS_FALL_TOGETHER, "/Procedure/Timeline/it"):
        compiled(program, Suture("it", ((2.0, 3.0, TOP), (2.0, 3.0, TOP)), 5.0))
