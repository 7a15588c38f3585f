"""What is refused of a suture run before anything is solved, and what is warned of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.checks.suture_run_problems import UNEQUAL, edges_cross
from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Incision, Procedure, Suture, SutureLayer, SutureRun
from lappet.tissue.patch import flat_patch

PATCH = flat_patch((60.0, 40.0, 4.0), spacing=2.0)
TOP = 4.0
CUT = ((-15.0, 0.0, TOP), (0.0, 0.0, TOP), (15.0, 0.0, TOP))
RUN = SutureRun("run", (CUT, CUT), 4.0, duration=4.0, spacing=5.0)
BESIDE = tuple((x, -3.0, z) for x, _, z in CUT)


def codes(run: SutureRun, *others: Suture) -> list[ProblemCode]:
    procedure = Procedure(PATCH, events=(Incision("cut", 2.0, CUT), run, *others), end_time=9.0)
    return [each.code for each in check(procedure) if "run" in each.prim or "stitch" in each.prim]


def test_a_run_along_both_walls_of_a_cut_is_right() -> None:
    assert codes(RUN) == []


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"spacing": 0.0}, ProblemCode.SUTURE_RUN_SPACING),
        ({"spacing": -2.0}, ProblemCode.SUTURE_RUN_SPACING),
        ({"spacing": 31.0}, ProblemCode.SUTURE_RUN_SPACING),
        ({"spacing": float("nan")}, ProblemCode.SUTURE_RUN_SPACING),
        ({"margin": 15.0}, ProblemCode.SUTURE_RUN_MARGIN),
        ({"margin": -1.0}, ProblemCode.SUTURE_RUN_MARGIN),
        ({"edges": (CUT[:1], CUT)}, ProblemCode.SUTURE_RUN_EDGE),
        ({"edges": (CUT, (CUT[0], CUT[0]))}, ProblemCode.SUTURE_RUN_EDGE),
        ({"edges": (CUT, ())}, ProblemCode.SUTURE_RUN_EDGE),
        ({"edges": (CUT, tuple((x, y, 20.0) for x, y, _ in CUT))}, ProblemCode.SUTURE_RUN_OFF_SKIN),
        ({"edges": (CUT, tuple((x, 50.0, z) for x, _, z in CUT))}, ProblemCode.SUTURE_RUN_OFF_SKIN),
        ({"edges": (CUT, tuple((x, y, 1.0) for x, y, _ in CUT))}, ProblemCode.SUTURE_RUN_OFF_SKIN),
        ({"edges": (((0.0, np.nan, TOP), CUT[0]), CUT)}, ProblemCode.EVENT_POINT_NOT_FINITE),
        ({"sides": (1, 1)}, ProblemCode.SUTURE_RUN_SAME_EDGE),
        ({"edges": (CUT, CUT[::-1]), "sides": (1, -1)}, ProblemCode.SUTURE_RUN_SAME_EDGE),
        ({"bite": 0.0}, ProblemCode.SUTURE_RUN_SAME_EDGE),
        ({"edges": (CUT, ((-15.0, 3.0, TOP), (15.0, -2.0, TOP)))}, ProblemCode.SUTURE_RUN_EDGES_CROSS),
        ({"sides": (1, 0)}, ProblemCode.SUTURE_RUN_SIDE),
        ({"corners": ((3, 3),)}, ProblemCode.SUTURE_RUN_CORNER),
        ({"corners": ((1, 1), (1, 1))}, ProblemCode.SUTURE_RUN_CORNER),
        ({"corners": ((0, 1),)}, ProblemCode.SUTURE_RUN_CORNER),
        ({"insides": (((0, 3, TOP), (0, -3, TOP)),)}, ProblemCode.SUTURE_RUN_INSIDES),
        ({"layers": ()}, ProblemCode.SUTURE_RUN_LAYERS),
        ({"layers": (SutureLayer("skin"), SutureLayer("skin", 1.0))}, ProblemCode.SUTURE_RUN_LAYERS),
        ({"layers": (SutureLayer("not a name"),)}, ProblemCode.SUTURE_RUN_LAYERS),
        ({"layers": (SutureLayer("deep", 9.0),)}, ProblemCode.SUTURE_RUN_DEPTH),
        ({"layers": (SutureLayer("deep", -1.0),)}, ProblemCode.SUTURE_RUN_NUMBER),
        ({"pattern": "simple", "pass_depth": 9.0}, ProblemCode.SUTURE_RUN_DEPTH),
        ({"bite": -1.0}, ProblemCode.SUTURE_RUN_NUMBER),
        ({"drawn": float("inf")}, ProblemCode.SUTURE_RUN_NUMBER),
        ({"pattern": "crochet"}, ProblemCode.SUTURE_RUN_WORD),
        ({"order": "backwards"}, ProblemCode.SUTURE_RUN_WORD),
        ({"thread": "hemp 4-0"}, ProblemCode.SUTURE_THREAD),
        ({"duration": -1.0}, ProblemCode.SUTURE_DURATION),
        ({"stiffness": 0.0}, ProblemCode.EVENT_STIFFNESS),
        ({"start": 20.0}, ProblemCode.EVENT_AFTER_END),
    ],
)
def test_a_run_that_cannot_be_sewn_is_refused_with_one_problem(changes: dict[str, object], code: ProblemCode) -> None:
    assert codes(replace(RUN, **changes)) == [code]  # type: ignore[arg-type]


def test_a_running_suture_through_too_many_places_is_refused() -> None:
    fine = replace(PATCH, spacing=0.1)
    run = replace(RUN, pattern="running", spacing=0.4, bite=1.0)
    procedure = Procedure(fine, events=(Incision("cut", 2.0, CUT), run), end_time=9.0)
    found = [each.code for each in check(procedure) if each.prim.endswith("/run")]
    assert found == [ProblemCode.SUTURE_BITES]


def test_very_unequal_edges_are_warned_of_and_nearly_equal_ones_not() -> None:
    straight = ((-8.0, 0.0, TOP), (8.0, 0.0, TOP))
    for depth, warned in ((12.0, False), (16.0, True)):
        bent = (straight[0], (0.0, -depth, TOP), straight[1])
        run = replace(RUN, edges=(straight, bent))
        assert (run.lengths[1] / run.lengths[0] > UNEQUAL) == warned
        assert codes(run) == ([ProblemCode.SUTURE_RUN_UNEQUAL] if warned else [])


def test_a_stitch_of_a_run_and_a_single_suture_of_the_same_points_are_told_of() -> None:
    ends = ((-12.5, 0.035, TOP), (-12.5, -0.035, TOP))
    assert codes(RUN, Suture("stitch", ends, 4.0)) == [ProblemCode.SUTURE_TWICE]


def test_lines_cross_where_each_reaches_to_both_sides_of_the_other() -> None:
    one = np.array([(0.0, 0.0, 0.0), (10.0, 0.0, 0.0)])
    assert edges_cross(one, np.array([(5.0, -1.0, 0.0), (5.0, 1.0, 0.0)])) == pytest.approx([5.0, 0.0, 0.0])
    for other in (
        [(0.0, 0.0, 0.0), (5.0, 5.0, 0.0)],  # from the same point
        [(5.0, 0.0, 0.0), (5.0, 5.0, 0.0)],  # on the line
        [(0.0, 1.0, 0.0), (10.0, 1.0, 0.0)],  # beside it
        [(5.0, -1.0, 3.0), (5.0, 1.0, 3.0)],  # far above
    ):
        assert edges_cross(one, np.array(other)) is None
