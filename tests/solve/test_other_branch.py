"""Another branch of the coarse solve: two equilibria of one lattice are proof, anything less is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import SolverClient
from lappet.daemon.daemon_solver import connect_to
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.program.program import Program
from lappet.reports.stability.buckling_cases import pressed
from lappet.solve.other_branch import Neighbors, judged, other_branches, way_to
from lappet.solve.sensitive import is_sensitive, stability_notes
from lappet.solve.solve_frames import FrameResult

PROGRAM = pressed(0.8, 1)
EPOCH = PROGRAM.epochs[0]


def bowed(by: float, *, converged: bool = True) -> SolvedFrame:
    """The bar's surface bent by so many mm in its middle."""
    points = np.asarray(EPOCH.surface.points, float)
    shift = np.zeros_like(points)
    shift[:, 2] = by * np.sin(np.pi * points[:, 0] / 40.0)
    return SolvedFrame(1.0, (points + shift).astype(np.float32), diagnostics=Diagnostics(converged))


def test_two_equilibria_of_one_lattice_are_proof_if_the_second_is_near_the_fine_one() -> None:
    found = judged(EPOCH, bowed(-8.0), bowed(7.0), bowed(8.0), 2.0)
    assert found is not None
    assert found.distance == pytest.approx(15.0, rel=0.01)
    assert found.place[0] == pytest.approx(20.0, abs=1.0)
    assert judged(EPOCH, bowed(7.1), bowed(7.0), bowed(8.0), 2.0) is None  # the same equilibrium
    assert judged(EPOCH, bowed(-8.0), bowed(-2.0), bowed(8.0), 2.0) is None  # no nearer: it says nothing
    assert judged(EPOCH, bowed(-8.0), bowed(7.0, converged=False), bowed(8.0), 2.0) is None


def test_nodes_move_like_the_side_of_the_wound_that_they_are_on() -> None:
    points = np.asarray(EPOCH.surface.points, float)
    left = np.arange(len(points)) % 2 == 0  # two sides that lie on each other at rest
    path, target = bowed(0.0), bowed(0.0)
    path.points[left, 1] -= 3.0
    path.points[~left, 1] += 3.0
    target.points[left, 1] -= 4.0
    target.points[~left, 1] += 5.0
    rest = points[:20]
    nodes = np.where(left[:20, None], (0.0, -3.0, 0.0), (0.0, 3.0, 0.0))
    state = SolverState("float", nodes, *(np.zeros((0, 3)),) * 2, *(np.zeros(0),) * 2)
    way = way_to(EPOCH, Neighbors.of(rest, points), replace(path, state=state), target, 1.0)
    np.testing.assert_allclose(way[left[:20], 1], -1.0, atol=0.05)
    np.testing.assert_allclose(way[~left[:20], 1], 2.0, atol=0.05)


def solved(program: Program, nudge: float) -> SolvedFrame:
    """The bar, started from a bow to one side."""
    with SolverClient() as client:
        client.open(program.settings, program.bones)
        _, rest = client.set_epoch_with_nodes(program.epochs[0], program.grips[0], program.landmarks_at[0])
        start = np.zeros_like(rest)
        start[:, 2] = nudge * np.sin(np.pi * rest[:, 0] / 40.0)
        none = np.zeros((0, 3))
        client.set_state(SolverState("float", start, none, none, np.zeros(0), np.zeros(1)))
        return client.solve(program.frames[0])


def test_a_bar_that_buckles_up_and_down_is_one_of_several(binary: Path) -> None:
    coarse = replace(PROGRAM, settings=replace(PROGRAM.settings, spacing=2.0))
    up, down, up_again = solved(PROGRAM, 2.0), solved(coarse, -2.0), solved(coarse, 2.0)
    found = other_branches(coarse, {0: up}, {0: down}, connect_to(None))
    assert found[0].distance > 10.0
    assert np.abs(found[0].frame.points - up_again.points).max() < 0.1
    assert other_branches(coarse, {0: up}, {0: up_again}, connect_to(None)) == {}


def test_frames_are_called_unstable_sensitive_or_buckled_with_the_place() -> None:
    def result(time: float, stiffness: float, left: int = 0) -> FrameResult:
        said = Diagnostics(converged=True, lowest_stiffness=stiffness, saddles_left=left)
        frame = replace(bowed(0.0), time=time, diagnostics=said, softest_point=np.array([[1.0, 2.0, 3.0]]))
        constraints = replace(PROGRAM.frames[0], time=time)
        return FrameResult(constraints, f"{time}", frame, looked_up=False, wall_seconds=0.0)

    frames = [result(1.0, 0.9), result(2.0, 0.04), result(3.0, 0.02), result(4.0, -0.3), result(5.0, 0.5, 2)]
    assert [is_sensitive(each.solved) for each in frames] == [False, True, True, True, False]
    notes = {note.code: note for note in stability_notes(frames)}
    assert set(notes) == {
        ProblemCode.FRAMES_UNSTABLE, ProblemCode.FRAMES_SENSITIVE, ProblemCode.FRAMES_LEFT_SADDLES,
    }  # fmt: skip
    sensitive = notes[ProblemCode.FRAMES_SENSITIVE]
    assert (sensitive.prim, sensitive.value) == ("Frames 2 to 3", "2.0%")
    assert "(1, 2, 3)" in sensitive.message
    assert notes[ProblemCode.FRAMES_UNSTABLE].severity == "warning"
    assert notes[ProblemCode.FRAMES_LEFT_SADDLES].value == "2"
    assert stability_notes([result(1.0, float("nan"))]) == []
