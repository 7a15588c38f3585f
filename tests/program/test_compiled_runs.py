"""A compiled suture run: the daemon is told of its stitches as of single sutures, layer by layer in order of time."""

from __future__ import annotations

from dataclasses import replace

import pytest

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Incision, Procedure, SutureLayer, SutureRun
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.program.settings import SolverSettings
from lappet.solve.suture_forces import closure_of, suture_number
from lappet.suturing import with_single_sutures
from lappet.tissue.patch import flat_patch

TOP = 4.0
CUT = ((-10.0, 0.0, TOP), (10.0, 0.0, TOP))
LAYERS = (SutureLayer("deep", 3.0), SutureLayer("skin", 0.0, True))
RUN = SutureRun("wound", (CUT, CUT), 3.0, duration=4.0, spacing=4.0, layers=LAYERS)


@pytest.fixture(scope="module")
def procedure() -> Procedure:
    tissue = flat_patch((40.0, 30.0, TOP), spacing=2.0)
    return Procedure(tissue, events=(Incision("cut", 2.0, CUT), RUN), end_time=8.0)


def test_the_daemon_is_told_the_same_of_a_run_as_of_its_single_sutures(procedure: Procedure) -> None:
    program, single = compile_program(procedure), compile_program(with_single_sutures(procedure))
    assert frame_keys(program, "solver") == frame_keys(single, "solver")
    assert program.sutures == single.sutures
    assert len(program.frames[-1].suture_index) == 5 + 4


def test_the_stitches_of_a_layer_are_one_closure_in_order(procedure: Procedure) -> None:
    names = compile_program(procedure).sutures
    assert {closure_of(name) for name in names} == {"wound/deep", "wound/skin"}
    assert sorted(suture_number(name) for name in names if closure_of(name) == "wound/deep") == [1, 2, 3, 4, 5]


def test_a_run_solved_on_a_coarser_lattice_has_fewer_stitches(procedure: Procedure) -> None:
    coarse = compile_program(procedure, settings=SolverSettings(spacing=4.0))
    assert len(coarse.sutures) < len(compile_program(procedure).sutures)


def test_what_is_wrong_with_a_stitch_names_it_below_its_run(procedure: Procedure) -> None:
    crossed = replace(RUN, name="askew", edges=(CUT, CUT[::-1]), sides=(1, 1), layers=(SutureLayer(),))
    notes = compile_program(replace(procedure, events=(procedure.events[0], crossed))).notes
    assert {note.code for note in notes} == {ProblemCode.SUTURES_CROSSED}
    assert all(note.prim.startswith("/Procedure/Timeline/askew/") for note in notes)


def test_another_spacing_leaves_the_frames_before_the_run_as_they_are(procedure: Procedure) -> None:
    cut, run = procedure.events
    assert isinstance(run, SutureRun)
    denser = replace(procedure, events=(cut, replace(run, spacing=3.0)))
    keys = frame_keys(compile_program(procedure), "solver")
    changed = frame_keys(compile_program(denser), "solver")
    assert [one == other for one, other in zip(keys, changed, strict=True)] == [True, True, *[False] * 6]
