"""The stitches of suture runs: where they lie, when they are made, what they are called, and when they are merged."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Incision, Procedure, Suture, SutureLayer, SutureRun
from lappet.procedure.edits import add_event, replace_event, retime_event
from lappet.procedure.history import History
from lappet.suturing import run_stitches, with_single_sutures
from lappet.suturing.lip_pair import on_edge
from lappet.suturing.single_sutures import skin_of
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch

PATCH = flat_patch((60.0, 60.0, 4.0), spacing=2.0)
TOP = 4.0
CUT = ((-15.0, 0.0, TOP), (15.0, 0.0, TOP))
RUN = SutureRun("run", (CUT, CUT), 4.0, duration=8.0, spacing=3.0)


def sutures(run: SutureRun, cell: float = 0.0) -> tuple[Suture, ...]:
    return run_stitches(run, skin_of(PATCH), cell).sutures


def lips(run: SutureRun, edge: int, cell: float = 0.0) -> np.ndarray:
    return np.array([suture.anchors[edge] for suture in sutures(run, cell)])


def test_along_a_cut_the_stitches_lie_evenly_in_both_of_its_walls() -> None:
    first, second = lips(RUN, 0), lips(RUN, 1)
    np.testing.assert_allclose(first[:, 0], np.arange(-13.5, 15.0, 3.0), atol=1e-4)
    np.testing.assert_allclose(second[:, 0], first[:, 0], atol=1e-4)
    np.testing.assert_allclose((first[:, 1], second[:, 1]), [[0.035] * 10, [-0.035] * 10], atol=1e-4)
    assert [suture.name for suture in sutures(RUN)] == [f"run/{k}" for k in range(1, 11)]
    assert {suture.mode for suture in sutures(RUN)} == {"exact"}


@pytest.mark.parametrize("spacing", [2.5, 3.0, 4.0, 7.0, 29.0])
def test_stitches_are_never_nearer_than_the_spacing_nor_twice_as_far(spacing: float) -> None:
    at = lips(replace(RUN, spacing=spacing), 0)[:, 0]
    gaps = np.diff(at)
    assert (gaps >= spacing - 1e-3).all()
    assert (gaps < 2.0 * spacing).all()
    np.testing.assert_allclose(gaps, gaps[:1].repeat(len(gaps)), atol=1e-3)
    assert at.mean() == pytest.approx(0.0, abs=1e-3)


def test_unequal_edges_are_divided_in_the_same_shares() -> None:
    bow = tuple((12.0 * np.sin(t), 8.0 * np.cos(t) - 8.0 * np.cos(1.2), TOP) for t in np.linspace(-1.2, 1.2, 60))
    chord = (bow[0], bow[-1])
    run = replace(RUN, edges=(bow, chord), spacing=2.0, bite=0.0)
    long, short = run.lengths
    assert long / short > 1.1
    points = np.array(bow)
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    for above, below in zip(lips(run, 0), lips(run, 1), strict=True):
        share = np.linalg.norm(below - bow[0]) / short
        expected = [np.interp(share * long, reached, points[:, axis]) for axis in range(3)]
        np.testing.assert_allclose(above, expected, atol=1e-3)


def test_margins_corners_and_layers_between_give_the_rows_of_a_flap() -> None:
    edge = ((-10.0, 0.0, TOP), (0.0, 10.0, TOP), (10.0, 0.0, TOP))
    other = ((-10.0, -1.0, TOP), (0.0, 9.0, TOP), (10.0, -1.0, TOP))
    layers = (SutureLayer("deep", 3.0), SutureLayer("dermal", 0.5, between=True))
    run = SutureRun("flap", (edge, other), 4.0, corners=((1, 1),), spacing=3.0, margin=2.0, layers=layers)
    found = sutures(run)
    deep = [suture for suture in found if suture.name.startswith("flap/deep/")]
    dermal = [suture for suture in found if suture.name.startswith("flap/dermal/")]
    assert [suture.name for suture in found] == [
        *(f"flap/deep/{k}" for k in range(1, len(deep) + 1)),
        *(f"flap/dermal/{k}" for k in range(1, len(dermal) + 1)),
    ]
    assert (len(deep), len(dermal)) == (2 * 4 + 1, 2 * 3 + 1)  # and one in the corner
    assert {suture.anchors[0][2] for suture in deep} == {TOP - 3.0}
    along = [np.hypot(suture.anchors[0][0] + 10.0, suture.anchors[0][1]) for suture in deep[:4]]
    assert along[0] == pytest.approx(2.0, abs=0.03)
    # Along the other layer they lie half way between those.
    shifted = [np.hypot(suture.anchors[0][0] + 10.0, suture.anchors[0][1]) for suture in dermal[:3]]
    np.testing.assert_allclose(shifted, [0.5 * (a + b) for a, b in pairwise(along)], atol=0.02)
    corner = np.array(deep[4].anchors)
    np.testing.assert_allclose(corner[:, 0], 0.0, atol=1e-4)
    # The tissue of the first edge lies to its left, above; that of the second below: a corner is halved.
    assert corner[0, 1] == pytest.approx(10.0 + 2.0 * (0.035 + 0.05 * 3.0), abs=1e-3)
    assert corner[1, 1] == pytest.approx(9.0 - 2.0 * (0.035 + 0.05 * 3.0), abs=1e-3)


def test_halving_makes_the_middle_first_then_the_middles_of_the_halves() -> None:
    starts = [suture.start for suture in sutures(replace(RUN, spacing=4.0))]
    assert len(starts) == 7
    order = sorted(set(starts))
    assert [order.index(start) for start in starts] == [2, 1, 2, 0, 2, 1, 2]
    assert order[0] == RUN.start
    ends = {suture.start + suture.duration for suture in sutures(RUN)}
    assert max(ends) == pytest.approx(RUN.start + RUN.duration)


def test_the_other_orders_run_from_the_start_or_all_at_once() -> None:
    starts = [suture.start for suture in sutures(replace(RUN, order="forward"))]
    assert starts == sorted(starts)
    assert len(set(starts)) == len(starts)
    together = sutures(replace(RUN, order="together"))
    assert {(suture.start, suture.duration) for suture in together} == {(RUN.start, RUN.duration)}


@pytest.mark.parametrize("cell", [1.0, 2.0, 4.0])
def test_stitches_nearer_than_the_lattice_can_carry_are_merged_and_it_is_said(cell: float) -> None:
    made = run_stitches(replace(RUN, spacing=1.0), skin_of(PATCH), cell)
    at = np.array([suture.anchors[0][0] for suture in made.sutures])
    assert (np.diff(at) >= 1.2 * cell - 1e-3).all()
    assert made.merged is not None
    assert (made.merged.code, made.merged.prim) == (ProblemCode.SUTURE_RUN_MERGED, "/Procedure/Timeline/run")
    assert (made.merged.value, made.merged.severity) == ("1", "warning")
    assert run_stitches(RUN, skin_of(PATCH), 2.0).merged is None


def test_a_running_suture_is_one_thread_and_a_mattress_one_for_each_place() -> None:
    (thread,) = sutures(replace(RUN, pattern="running", bite=3.0, thread="nylon 5-0", drawn=1.0))
    assert (thread.name, thread.mode, thread.thread) == ("run/1", "thread", "nylon 5-0")
    assert len(thread.anchors) == 10 * 4
    # At each of ten places 2 mm down, 6 across and 2 up; and nine times askew over the wound to the next, 3 mm on.
    assert thread.length == pytest.approx(10 * 10.0 + 9 * np.hypot(3.0, 6.0), abs=0.01)
    mattress = sutures(replace(RUN, pattern="verticalMattress"))
    assert len(mattress) == 10
    assert {len(suture.anchors) for suture in mattress} == {9}


def test_a_pattern_is_sewn_on_the_skin_over_interrupted_deep_stitches() -> None:
    layers = (SutureLayer("deep", 2.5), SutureLayer("skin"))
    found = sutures(replace(RUN, pattern="horizontalMattress", layers=layers))
    assert {suture.mode for suture in found if suture.name.startswith("run/deep/")} == {"exact"}
    assert {len(suture.anchors) for suture in found if suture.name.startswith("run/skin/")} == {9}


def test_on_curved_skin_bites_lie_at_their_depth_below_it() -> None:
    dome = dome_scalp()
    skin = skin_of(dome)
    on_skin = [tuple(skin.at((x, 0.0, 100.0))[0][0]) for x in np.linspace(-8.0, 8.0, 17)]
    run = SutureRun("run", (tuple(on_skin), tuple(on_skin)), 2.0, spacing=2.0, layers=(SutureLayer("deep", 1.5),))
    points = np.array([suture.anchors for suture in run_stitches(run, skin, 0.0).sutures]).reshape(-1, 3)
    np.testing.assert_allclose(skin.surface.query(points)[2], 1.5, atol=0.05)


def test_a_procedure_gets_the_stitches_in_the_place_of_its_run() -> None:
    cut = Incision("cut", 2.0, CUT)
    stitch = Suture("stitch", ((0.0, 5.0, TOP), (0.0, -5.0, TOP)), 3.0)
    procedure = Procedure(PATCH, events=(cut, RUN, stitch), end_time=12.0)
    single = with_single_sutures(procedure)
    assert [event.name for event in single.events] == ["cut", *(f"run/{k}" for k in range(1, 11)), "stitch"]
    assert with_single_sutures(single) is single


def test_a_run_is_edited_moved_in_time_and_undone_like_any_event() -> None:
    history = History(Procedure(PATCH, events=(RUN,), end_time=12.0))
    history.do(retime_event("run", 2.0))
    moved = history.procedure.event("run")
    assert isinstance(moved, SutureRun)
    assert (moved.start, moved.edges) == (6.0, RUN.edges)
    history.do(replace_event("run", replace(moved, spacing=5.0)))
    assert len(with_single_sutures(history.procedure).events) == 6
    history.undo()
    assert len(with_single_sutures(history.procedure).events) == 10
    assert add_event(RUN).label == "Add sutures run"


@pytest.mark.parametrize("off", [-1e-15, 0.0, 1e-15])
def test_the_direction_at_a_point_of_an_edge_does_not_depend_on_the_rounding_of_lengths(off: float) -> None:
    turn = np.linspace(0.0, 1.0, 11)
    arc = 20.0 * np.stack([np.cos(turn), np.sin(turn), np.zeros(11)], axis=1)
    np.testing.assert_array_equal(on_edge(arc, 0.5 + off).along, arc[7] - arc[4])
