"""Tissue that has passed into other tissue is warned about, with its place at rest and in the frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.solve.overlaps import overlap_notes
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from small_procedure import FakeSolver, small_procedure


@pytest.fixture(scope="module")
def program() -> Program:
    """The small procedure: a patch of 24 x 16 x 2 mm with a slit along x, on a lattice of 1 mm."""
    return compile_program(small_procedure())


def pushed_together(program: Program, frames: tuple[FrameResult, ...], by: float) -> tuple[FrameResult, ...]:
    """The frames where in the last one the sides of the slit are pushed over each other by so many mm."""
    last = frames[-1]
    points = np.asarray(program.epochs[-1].surface.points, float).copy()
    points[:, 1] -= np.sign(points[:, 1]) * 0.5 * by * np.exp(-np.abs(points[:, 1]) / 4.0)
    return (*frames[:-1], replace(last, solved=replace(last.solved, points=points)))


@pytest.fixture(scope="module")
def frames(program: Program, tmp_path_factory: pytest.TempPathFactory) -> tuple[FrameResult, ...]:
    """Frames of a solver of formulas."""
    store = FrameStore(tmp_path_factory.mktemp("store"))
    return solve_program(program, store, FakeSolver().connect, "fake", SolveObserver()).frames


@pytest.mark.parametrize(("by", "told"), [(0.0, False), (0.3, False), (0.45, True), (1.0, True)])
def test_sides_of_a_slit_that_are_pushed_over_each_other_are_told_beyond_a_quarter_of_the_spacing(
    by: float, told: bool, program: Program, frames: tuple[FrameResult, ...]
) -> None:
    found = overlap_notes(program, pushed_together(program, frames, by))
    assert [each.code for each in found] == [ProblemCode.TISSUE_IN_TISSUE] * told
    for each in found:
        assert each.severity == "warning"
        assert float(each.value) == pytest.approx(by - 0.1, rel=0.1)  # the slit is 0.1 mm wide
        assert each.place is not None
        ((x, y, z),) = each.place.points
        assert abs(x) <= 6.0
        assert abs(y) < 0.1
        assert 0.0 <= z <= 2.0


def test_frames_that_start_from_a_surface_that_passes_through_itself_are_told_with_the_first_of_them(
    program: Program, frames: tuple[FrameResult, ...]
) -> None:
    def started(frame: FrameResult, places: int) -> FrameResult:
        said = replace(frame.solved.diagnostics, piercings_before=places)
        return replace(frame, solved=replace(frame.solved, diagnostics=said))

    clear = [started(frame, 0) for frame in pushed_together(program, frames, 0.0)]
    assert len(clear) > 2
    (found,) = overlap_notes(program, [clear[0], *(started(frame, 3) for frame in clear[1:])])
    assert found.code == ProblemCode.FRAMES_START_PIERCED
    assert found.severity == "warning"
    assert found.value == "3"
    assert f"Frame {clear[1].constraints.time:g} " in found.message
    assert f"in {len(clear) - 2} other" in found.message


def test_frames_that_were_taken_apart_at_their_start_are_a_note_and_no_warning(
    program: Program, frames: tuple[FrameResult, ...]
) -> None:
    def started(frame: FrameResult, places: int, untangled: int) -> FrameResult:
        said = replace(frame.solved.diagnostics, piercings_before=places, untangled=untangled)
        return replace(frame, solved=replace(frame.solved, diagnostics=said))

    clear = pushed_together(program, frames, 0.0)
    (note,) = overlap_notes(program, [clear[0], started(clear[1], 7, 7)])
    assert note.code == ProblemCode.FRAMES_UNTANGLED
    assert note.severity == "note"
    assert note.value == "7"
    assert f"Frame {clear[1].constraints.time:g} " in note.message
    both = overlap_notes(program, [started(clear[0], 2, 0), started(clear[1], 7, 7)])
    assert [each.code for each in both] == [ProblemCode.FRAMES_START_PIERCED, ProblemCode.FRAMES_UNTANGLED]


def test_a_warning_counts_what_was_not_taken_apart(program: Program, frames: tuple[FrameResult, ...]) -> None:
    clear = pushed_together(program, frames, 0.0)[0]
    said = replace(clear.solved.diagnostics, piercings_before=7, untangled=5)
    both = overlap_notes(program, [replace(clear, solved=replace(clear.solved, diagnostics=said))])
    assert {each.code: each.value for each in both} == {
        ProblemCode.FRAMES_START_PIERCED: "2",
        ProblemCode.FRAMES_UNTANGLED: "5",
    }


def test_only_the_last_frame_counts_and_no_frames_have_none(program: Program, frames: tuple[FrameResult, ...]) -> None:
    pushed = pushed_together(program, frames, 1.0)
    assert overlap_notes(program, [pushed[-1], pushed_together(program, frames, 0.0)[-1]]) == []
    assert overlap_notes(program, []) == []
