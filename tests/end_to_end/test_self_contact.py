"""With self-contact no frame of an operation passes through itself: an independent library looks at every surface.

The IPC Toolkit (Li et al. 2020) is the oracle. It shares nothing with the daemon.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import read_procedure
from self_intersection import passes_through_itself

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def solved(example: str, spacing: float, self_contact: bool, folder: Path) -> tuple[Program, tuple[FrameResult, ...]]:
    """Solve an example, all of whose frames must converge."""
    procedure = read_procedure(EXAMPLES / example / f"{example}.usda")
    settings = SolverSettings(spacing=spacing, strain=False, self_contact=self_contact)
    program = compile_program(procedure, settings=settings)
    found = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert found.reason is None, found.reason
    assert len(found.frames) == len(program.frames)
    return program, tuple(found.frames)


def frames_that_pass_through(example: str, spacing: float, self_contact: bool, folder: Path) -> list[float]:
    """Solve an example; the times of frames with intersections."""
    program, frames = solved(example, spacing, self_contact, folder)
    surfaces = {epoch.index: epoch.surface.triangles for epoch in program.epochs}
    return [
        asked.time
        for asked, found in zip(program.frames, frames, strict=True)
        if passes_through_itself(found.solved.points, surfaces[asked.epoch])
    ]


def test_the_oracle_finds_what_passes_through() -> None:
    triangle = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    apart = np.concatenate([triangle, triangle + np.array([0.1, 0.1, 0.1])])
    across = np.concatenate([triangle, np.array([[0.2, 0.2, -0.5], [0.2, 0.2, 0.5], [0.9, 0.9, 0.5]])])
    assert not passes_through_itself(apart, faces)
    assert passes_through_itself(across, faces)


@pytest.mark.parametrize("example", ["ellipse", "stitches", "prestretched_incision"])
def test_wounds_open_and_close_without_passing_through_themselves(example: str, tmp_path: Path) -> None:
    assert frames_that_pass_through(example, 2.0, True, tmp_path) == []


def test_sutures_between_walls_that_do_not_fit_pull_no_harder_than_the_tissue_does(tmp_path: Path) -> None:
    # Ends that had to meet exactly pulled with 6.7 times the force, ends that were drawn no further than walls that
    # touch with 2.5 times.
    pull = {}
    for self_contact in (False, True):
        _, frames = solved("ellipse", 2.0, self_contact, tmp_path / str(self_contact))
        pull[self_contact] = float(np.sum(frames[-1].solved.suture_forces))
    assert 0.7 * pull[False] < pull[True] < 1.2 * pull[False]


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_flaps_change_places_without_passing_through_themselves(tmp_path: Path) -> None:
    through = frames_that_pass_through("z_plasty", 2.0, False, tmp_path / "off")
    assert through, "the test shows nothing where nothing meets"
    assert frames_that_pass_through("z_plasty", 2.0, True, tmp_path / "on") == []


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_two_flaps_of_a_dual_s_plasty_do_not_pass_through_each_other(tmp_path: Path) -> None:
    assert frames_that_pass_through("dual_s_plasty", 2.0, True, tmp_path) == []
