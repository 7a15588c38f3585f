"""With self-contact a flap that is pulled against skin holds its hook back, and the solve says where."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.procedure import Hook, Incision, Point, Procedure, Undermine
from lappet.program.compile import DEFAULT, compile_program
from lappet.solve.result_notes import result_notes
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN

TOP = 2.0
EDGE = 4.0  # where the flap ends and the skin beyond begins


def notes(target: Point, folder: Path, *, self_contact: bool) -> list[Problem]:
    """What is said where a hook draws the end of a raised flap to a target."""
    around = [(-EDGE, -EDGE, TOP), (-EDGE, EDGE, TOP), (EDGE, EDGE, TOP), (EDGE, -EDGE, TOP)]
    beyond = [(1.25 * x, 1.25 * y, z) for x, y, z in around]
    events = (
        Incision("flap", 1.0, tuple(around), kerf=0.3),
        Undermine("raised", 1.0, tuple(beyond)),
        Hook("hook", (0.0, 3.0, TOP), ((1.0, (0.0, 3.0, TOP)), (2.0, target)), 1.0, 3.0, stiffness=30.0),
    )
    patch = flat_patch((24.0, 20.0, TOP), resolution=2.0, spacing=1.0, gravity=0.0)
    procedure = Procedure(patch, (SKIN.unstretched,), events, start_time=1.0, end_time=2.0)
    program = compile_program(procedure, settings=replace(DEFAULT, self_contact=self_contact))
    solved = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert solved.reason is None
    return [each for each in result_notes(program, solved.frames) if each.code is ProblemCode.HOOK_HELD_BACK]


def test_a_hook_that_skin_holds_back_is_named_with_the_place(tmp_path: Path) -> None:
    (note,) = notes((0.0, 8.0, TOP), tmp_path, self_contact=True)
    assert note.prim == "/Procedure/Timeline/hook"
    assert 2.0 < float(note.value) < 5.0
    assert note.place is not None
    ((x, y, _),) = note.place.points
    assert abs(x) < 1.5
    assert y == pytest.approx(EDGE, abs=1.5)


def test_a_hook_that_goes_over_the_skin_is_not_held_back(tmp_path: Path) -> None:
    assert notes((0.0, 8.0, TOP + 4.0), tmp_path, self_contact=True) == []


def test_without_self_contact_nothing_holds_a_hook_back(tmp_path: Path) -> None:
    assert notes((0.0, 8.0, TOP), tmp_path, self_contact=False) == []
