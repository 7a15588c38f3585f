"""With self-contact the solve says which suture tissue holds open, and how far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.procedure import Incision, Procedure, Suture
from lappet.program.compile import DEFAULT, compile_program
from lappet.program.program import Program
from lappet.solve.contact_reach import contact_reach
from lappet.solve.held_apart import held_apart_notes
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN

TOP = 2.0


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Program, FrameResult]:
    """A short wound that two sutures close until its walls touch."""
    line = ((0.0, -5.0, TOP), (0.0, 5.0, TOP))
    sutures = (
        Suture("one", ((-1.0, -1.5, 1.0), (1.0, -1.5, 1.0)), 1.0),
        Suture("other", ((-1.0, 1.5, 1.0), (1.0, 1.5, 1.0)), 1.0),
    )
    patch = flat_patch((20.0, 20.0, TOP), resolution=2.0, spacing=1.0, gravity=0.0)
    procedure = Procedure(
        patch, (SKIN.unstretched,), (Incision("cut", 1.0, line, kerf=0.3), *sutures), start_time=1.0, end_time=2.0
    )
    program = compile_program(procedure, settings=replace(DEFAULT, self_contact=True))
    folder = tmp_path_factory.mktemp("store")
    solved = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert solved.reason is None
    return program, solved.frames[-1]


def held_open(frame: FrameResult, by: float) -> FrameResult:
    """A frame whose sutures tissue holds open, the last one by more than the first."""
    count = len(frame.solved.suture_gaps)
    diagnostics = replace(frame.solved.diagnostics, self_contacts=5)
    gaps = by * np.arange(1, count + 1) / count
    return replace(frame, solved=replace(frame.solved, suture_gaps=gaps, diagnostics=diagnostics))


def test_the_suture_that_is_open_the_farthest_is_named(closed: tuple[Program, FrameResult]) -> None:
    program, frame = closed
    (note,) = held_apart_notes(program, [frame, held_open(frame, 0.3)])
    assert note.code is ProblemCode.SUTURE_HELD_APART
    assert note.prim == "/Procedure/Timeline/other"
    assert float(note.value) == pytest.approx(0.3)
    assert "1 more" in note.message


def test_walls_that_keep_what_walls_keep_are_not_named(closed: tuple[Program, FrameResult]) -> None:
    program, frame = closed
    assert held_apart_notes(program, [frame, held_open(frame, 1.24 * contact_reach(1.0))]) == []


def test_without_self_contact_nothing_holds_a_suture_open(closed: tuple[Program, FrameResult]) -> None:
    program, frame = closed
    without = replace(program, settings=replace(program.settings, self_contact=False))
    assert held_apart_notes(without, [held_open(frame, 0.3)]) == []


@pytest.mark.parametrize(("spacing", "reach"), [(0.5, 0.025), (1.0, 0.05), (2.0, 0.2)])
def test_surfaces_press_from_a_twentieth_of_the_spacing_and_from_more_beyond_a_millimeter(
    spacing: float, reach: float
) -> None:
    assert contact_reach(spacing) == pytest.approx(reach)
