"""A thinned flap in the program: stitches that come out with its deep tissue, and the dressing that presses on it."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Incision, Suture, Thin
from lappet.program.compile import compile_program
from lappet.program.program import FrameConstraints, Program
from small_procedure import TOP, small_procedure

SQUARE = tuple((x, y, TOP) for x, y in ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)))
CUT = Incision("cut", 2.0, ((-8.0, 0.0, TOP), (8.0, 0.0, TOP)))
LEFT = 0.5 * TOP


def across(name: str, x: float, depth: float, start: float = 3.0) -> Suture:
    """A stitch across the cut at a depth."""
    return Suture(name, ((x, -0.3, TOP - depth), (x, 0.3, TOP - depth)), start)


STITCHES = (
    across("deep", 1.0, 0.8 * TOP),
    across("skin", 0.0, 0.0),
    across("beside", 6.5, 0.8 * TOP),
    across("dermal", -1.0, 0.2 * TOP),
)


def thinned(*events: Suture | Thin) -> Program:
    return compile_program(small_procedure(events=(CUT, *events)))


def held(program: Program, time: float) -> set[str]:
    """The names of the stitches that act in a frame."""
    frame = next(each for each in program.frames if each.time == time)
    return {program.stitches[k].name for k in frame.suture_index}


def test_stitches_in_what_is_thinned_away_come_out_with_it_and_the_others_hold() -> None:
    program = thinned(*STITCHES, Thin("thin", 5.0, SQUARE, LEFT))
    assert held(program, 4.0) == {"deep", "skin", "beside", "dermal"}
    assert held(program, 5.0) == held(program, program.frames[-1].time) == {"skin", "beside", "dermal"}
    (note,) = [each for each in program.notes if each.code is ProblemCode.PROGRAM_STITCHES_THINNED]
    assert (note.prim, note.value, note.severity) == ("/Procedure/Timeline/thin", "1", "warning")


def test_a_thinning_that_leaves_all_bites_takes_no_stitch_and_says_nothing() -> None:
    program = thinned(*STITCHES, Thin("thin", 5.0, SQUARE, 0.9 * TOP))
    assert held(program, program.frames[-1].time) == {"deep", "skin", "beside", "dermal"}
    assert ProblemCode.PROGRAM_STITCHES_THINNED not in {each.code for each in program.notes}


def load(frame: FrameConstraints) -> float:
    """The pressure on the only loaded faces in kPa; 0 where nothing is loaded."""
    return float(frame.load_pressure.sum()) if len(frame.load_pressure) else 0.0


def test_the_dressing_presses_on_the_thinned_skin_from_then_on_and_grows_over_its_duration() -> None:
    program = thinned(Thin("thin", 4.0, SQUARE, LEFT, dressing=3.0, duration=2.0))
    pressures = {frame.time: load(frame) for frame in program.frames}
    assert [pressures[time] for time in (2.0, 3.0, 4.0, 5.0, 6.0, 7.0)] == [0.0, 0.0, 0.0, 1.5, 3.0, 3.0]
    last = program.epochs[-1]
    (faces,) = last.boundary.loaded_faces
    corners = last.surface.points[last.surface.triangles[faces]]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    assert area == pytest.approx(100.0, rel=0.15)  # whole faces of the skin
    assert (last.surface.origin[faces] == FaceOrigin.SKIN).all()


def test_without_a_dressing_nothing_presses() -> None:
    program = thinned(Thin("thin", 4.0, SQUARE, LEFT, dressing=0.0))
    assert {load(frame) for frame in program.frames} == {0.0}
    assert program.loads == ()
