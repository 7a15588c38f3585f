"""What a solve does otherwise than it is told is a value with a code, in the result, the report and the summary."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.commands.run_solve import told_lines
from lappet.core.problem import problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to
from lappet.output.report import report
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Hook, Procedure, Tissue
from lappet.program.compile import compile_program
from lappet.program.program import Bones, Program
from lappet.program.settings import SolverSettings
from lappet.solve.error_estimate import ErrorEstimate, FrameErrorEstimate
from lappet.solve.fallbacks import fallbacks, volume_ratio
from lappet.solve.frame_span import span_of
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.solve.untrusted import untrusted
from lappet.tissue.patch import flat_patch
from small_procedure import FakeSolver, small_procedure


@pytest.fixture(scope="module")
def program() -> Program:
    """The small procedure on a bed."""
    return compile_program(small_procedure())


@pytest.fixture(scope="module")
def frames(program: Program, tmp_path_factory: pytest.TempPathFactory) -> tuple[FrameResult, ...]:
    """Its frames by the solver of formulas."""
    store = FrameStore(tmp_path_factory.mktemp("store"))
    return solve_program(program, store, FakeSolver().connect, "fake", SolveObserver()).frames


def restarted(frame: FrameResult, why: str) -> FrameResult:
    """The frame as if it had been solved from rest."""
    solved = replace(frame.solved, diagnostics=replace(frame.solved.diagnostics, restart=why))
    return replace(frame, solved=solved)


def with_lattice(frames: tuple[FrameResult, ...], epoch: int, **counts: int) -> list[FrameResult]:
    """The frames as if an epoch's lattice had other counts."""
    changed = []
    for frame in frames:
        lattice = frame.solved.lattice
        assert lattice is not None
        own = frame.constraints.epoch == epoch
        solved = replace(frame.solved, lattice=replace(lattice, **counts) if own else lattice)
        changed.append(replace(frame, solved=solved))
    return changed


def test_a_solve_that_does_what_it_is_told_has_none(program: Program, frames: tuple[FrameResult, ...]) -> None:
    assert fallbacks(program, frames) == []
    assert untrusted(program, frames, estimate(frames, {})) == []


def test_frames_from_rest_are_told_together_for_each_reason(program: Program, frames: tuple[FrameResult, ...]) -> None:
    why = {2: "no_equilibrium", 3: "no_equilibrium", 5: "no_equilibrium", 6: "inverted"}
    said = [restarted(frame, why.get(round(frame.constraints.time), "")) for frame in frames]
    first, second = fallbacks(program, said)
    assert (first.code, first.prim, first.severity) == (ProblemCode.FRAMES_FROM_REST, "Frames 2 to 3 and 5", "note")
    assert (second.code, second.prim) == (ProblemCode.FRAMES_FROM_REST, "Frame 6")
    assert "no equilibrium" in first.message
    assert "inverted" in second.message


def test_dropped_voxels_are_told_once_with_their_volume(program: Program, frames: tuple[FrameResult, ...]) -> None:
    (found,) = fallbacks(program, with_lattice(frames, 1, dropped_voxels=96))
    assert (found.code, found.severity, found.value) == (ProblemCode.LATTICE_DROPPED, "note", "1.5")


@pytest.mark.parametrize(("percent", "told"), [(97.9, True), (98.1, False), (101.9, False), (102.1, True)])
def test_a_lattice_more_than_2_percent_off_is_a_warning(
    percent: float, told: bool, program: Program, frames: tuple[FrameResult, ...]
) -> None:
    found = fallbacks(program, with_lattice(frames, 0, volume=percent / 100.0 * 24 * 16 * 2))
    assert [(each.code, each.severity, each.value) for each in found] == (
        [(ProblemCode.LATTICE_VOLUME, "warning", f"{percent}")] if told else []
    )


def test_a_neighborhood_that_cannot_be_solved_first_is_told(program: Program, frames: tuple[FrameResult, ...]) -> None:
    box = flat_patch((4.0, 4.0, 1.0), 2.0)
    bones = Bones(box.points, np.zeros((1, 3), np.int32))
    (found,) = fallbacks(replace(program, bones=bones), frames)
    assert (found.code, found.value) == (ProblemCode.NEIGHBORHOOD_OFF, "there are bones")
    whole = replace(program.settings, region="whole")
    assert fallbacks(replace(program, bones=bones, settings=whole), frames) == []


def estimate(frames: tuple[FrameResult, ...], doubted: dict[int, float]) -> ErrorEstimate:
    """An estimate with these errors at frames that are not to be trusted."""
    errors = []
    for frame in frames:
        error = doubted.get(round(frame.constraints.time), 0.01)
        errors.append(
            FrameErrorEstimate(
                error, 0.5 * error, 0.0, 0.0, error, 0.5 * error,
                place=(1.0, 2.0, error), largest_displacement=4.0, is_trusted=error == 0.01,
            )
        )  # fmt: skip
    return ErrorEstimate(tuple(errors), 2.0, 1.25, 0.1)


def test_an_error_larger_than_the_spacing_is_told_with_its_frames_and_the_place_of_the_greatest(
    program: Program, frames: tuple[FrameResult, ...]
) -> None:
    (found,) = untrusted(program, frames, estimate(frames, {4: 1.5, 5: 92.0, 8: 1.2}))
    assert (found.code, found.severity, found.prim) == (ProblemCode.ERROR_LARGE, "warning", "Frames 4 to 5 and 8")
    assert found.value == "92"
    assert found.place is not None
    assert found.place.points == ((1.0, 2.0, 92.0),)
    assert "more than 1 mm, the lattice spacing" in found.message
    (small,) = untrusted(program, frames, estimate(frames, {4: 0.5}))
    assert "more than 0.4 mm, 10% of the largest displacement" in small.message


@pytest.mark.parametrize(
    ("times", "said"),
    [([3.0], "Frame 3"), ([1.0, 2.0], "Frames 1 to 2"), ([1.0, 3.0, 4.0, 5.0, 9.0], "Frames 1, 3 to 5 and 9")],
)
def test_frames_are_named_as_people_read_them(times: list[float], said: str) -> None:
    assert span_of(times) == said


def test_summary_and_report_of_a_solve_hold_all_of_it(program: Program, frames: tuple[FrameResult, ...]) -> None:
    said = tuple(with_lattice((*frames[:-1], restarted(frames[-1], "inverted")), 0, volume=16.0))
    notes = (*fallbacks(program, said), *untrusted(program, said, estimate(frames, {5: 9.0})))
    result = SolveResult(small_procedure(), program, said, notes=notes)
    told = report(result)
    by_code = {note["code"]: note for note in told["notes"]}
    assert set(by_code) == {ProblemCode.FRAMES_FROM_REST, ProblemCode.LATTICE_VOLUME, ProblemCode.ERROR_LARGE}
    assert by_code[ProblemCode.ERROR_LARGE]["points_mm"] == [[1.0, 2.0, 9.0]]
    assert told["frames"][-1]["restart"] == "inverted"
    assert told["epochs"][0]["lattice_volume_ratio"] == pytest.approx(16.0 / 768)
    lines = told_lines(notes)
    assert sum(line.startswith("warning: ") for line in lines) == 2
    (besides,) = [line for line in lines if line.startswith("Besides: ")]
    assert "Frame 8" in besides


def test_of_many_warnings_of_a_kind_the_summary_gives_three_and_their_number() -> None:
    many = [problem(ProblemCode.SUTURE_AFTER_END, f"/m{i}", "9", end=8.0) for i in range(7)]
    other = problem(ProblemCode.TISSUE_SMALL, "/t", "1", least=2.0)
    lines = told_lines([*many[:4], other, *many[4:]])
    assert [line.startswith("warning: /m") for line in lines] == [True, True, True, False, False]
    assert "4 more" in lines[3]
    assert "suture-after-end" in lines[3]
    assert lines[4].startswith("warning: /t")


def wedge(spacing: float) -> Tissue:
    """A prism of 12 mm with a tip of 10 degrees along the diagonal, 3 mm thick, held at its base."""
    turn = np.deg2rad([40.0, 50.0])
    far = 1.3 + 12.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    outline = np.concatenate([[[1.3, 1.2]], far])
    points = np.concatenate([np.column_stack([outline, np.full(3, z)]) for z in (0.0, 3.0)])
    faces = [(2, 1, 0), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
    return Tissue(
        points=points,
        face_vertex_counts=np.array([len(face) for face in faces], np.int32),
        face_vertex_indices=np.concatenate([np.array(face, np.int32) for face in faces]),
        subsets={"fixed": np.array([3], np.int32)},
        spacing=spacing,
        gravity=0.0,
    )


def test_the_daemon_counts_the_voxels_of_a_tip_that_it_drops(binary: Path) -> None:
    dropped = 0
    for ratio in (4, 6, 10):
        program = compile_program(Procedure(wedge(1.0), end_time=1.0), settings=SolverSettings(fine_ratio=ratio))
        solver = connect_to(None)(program.settings, program.bones)
        try:
            counts = solver.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
        finally:
            solver.close()
        dropped += counts.dropped_voxels
        assert volume_ratio(program.epochs[0], counts) == pytest.approx(1.0, abs=0.05)
    assert dropped > 0


def test_thin_tissue_on_a_coarse_lattice_and_a_far_pull_are_not_to_be_trusted(binary: Path, tmp_path: Path) -> None:
    tissue = flat_patch((24.0, 16.0, 2.3), resolution=4.0, spacing=2.0)
    hook = Hook("hook", (0.0, 0.0, 2.3), ((1.0, (0.0, 0.0, 2.3)), (2.0, (0.0, 0.0, 20.0))), 1.0, 3.0)
    procedure = Procedure(tissue, events=(hook,), start_time=1.0, end_time=2.0)
    result = solve_procedure(procedure, tmp_path / "thin.usdc", store=FrameStore(tmp_path / "store"))
    assert result.complete
    codes = [note.code for note in result.notes]
    assert codes == [ProblemCode.HOOK_TARGET_FAR, ProblemCode.ERROR_LARGE]
    counts = result.frames[0].solved.lattice
    assert counts is not None
    assert volume_ratio(result.program.epochs[0], counts) == pytest.approx(1.0, abs=2e-3)  # of 2.3 mm by voxels of 0.5
    doubted = result.notes[-1]
    assert doubted.prim == "Frame 2"
    assert doubted.place is not None
    assert np.linalg.norm(np.array(doubted.place.points[0]) - (0.0, 0.0, 2.3)) < 6.0
