"""The paramedian forehead flap: its paddle fits the defect when it is turned, and its pedicle is divided later."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.designs import FlapDesign
from lappet.designs.flap_plan import flap_plan
from lappet.designs.flat_curves import length
from lappet.designs.library import library_design
from lappet.designs.library_operation import flap_on_patch
from lappet.procedure import Excision, Hook, Incision, SutureRun, Thin
from refusals import refuses

NAME = "paramedian-forehead"


def drawn(mirrored: bool = False, **values: float) -> FlapDesign:
    row = library_design(NAME)
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), mirrored=mirrored, **row.values(values))


def turned(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return points @ np.array([[cos, sin], [-sin, cos]])


@pytest.mark.parametrize("angle", [130.0, 180.0])
@pytest.mark.parametrize("mirrored", [False, True])
def test_turned_about_the_pivot_and_drawn_back_by_what_is_spare_the_paddle_lies_in_the_defect(
    angle: float, mirrored: bool
) -> None:
    design = drawn(mirrored, turn=angle, spare=5.0)
    by = -angle if mirrored else angle
    for seam in design.seams[:2]:
        own, bed = (np.array(edge.points)[:, :2] for edge in seam.edges)
        assert turned(own, by) + np.array([5.0, 0.0]) == pytest.approx(bed, abs=1e-9)


def test_what_the_first_stage_leaves_of_the_defects_rim_is_sewn_in_the_second() -> None:
    design = drawn(diameter=20.0)
    assert design.division is not None
    first = sum(length(np.array(seam.edges[1].points)) for seam in design.seams[:2])
    paddle = design.division.seams[0]
    own, rim = (length(np.array(edge.points)) for edge in paddle.edges)
    assert own == pytest.approx(10.0)  # the pedicle's width
    assert first + rim == pytest.approx(20.0 * np.pi, rel=0.01)


def test_the_pedicle_is_discarded_and_its_stump_goes_back_between_the_ends_of_the_donor_site() -> None:
    design = drawn()
    assert design.division is not None
    _, left, right = design.division.seams
    for seam, side in ((left, 1.0), (right, -1.0)):
        own, lip = (np.array(edge.points)[:, :2] for edge in seam.edges)
        assert own[0] == pytest.approx(lip[0])
        assert own[-1] == pytest.approx((8.0, 0.0))
        assert lip[-1] == pytest.approx((8.0, side * 5.0))
    procedure = flap_on_patch(NAME, spacing=2.0)
    # Cut; the defect is out; freed; the pedicle is cut at both ends and gone at once, as it would rest nowhere.
    # The paddle is an island then.
    assert [epoch.fragments for epoch in build_epochs(procedure)] == [1, 2, 1, 1, 2]


def test_the_second_stage_begins_when_the_first_is_sewn_and_the_pedicle_is_held_until_then() -> None:
    procedure = flap_on_patch(NAME, spacing=2.0)
    runs = {event.name: event for event in procedure.events if isinstance(event, SutureRun)}
    hooks = {event.name: event for event in procedure.events if isinstance(event, Hook)}
    cuts = [event.time for event in procedure.events if isinstance(event, Incision)]
    (pedicle,) = (each for each in procedure.events if isinstance(each, Excision) and each.name == "pedicle")
    inset, donor = runs["suture_flap"], runs["suture_donor"]
    divided = max(cuts)
    assert max(inset.start + inset.duration, donor.start + donor.duration) <= divided == pedicle.time
    later = [run for name, run in runs.items() if "rejoined" in name]
    assert len(later) == 3
    assert all(run.start > pedicle.time and run.start + run.duration <= procedure.end_time for run in later)
    assert hooks["hook_pedicle"].release == divided
    assert all(hook.release < divided for name, hook in hooks.items() if name != "hook_pedicle")
    thickness = 4.0
    assert hooks["hook_pedicle"].targets[-1][1][2] > 2.0 * thickness  # over the skin that it bridges


def test_a_third_stage_thins_the_paddle_after_the_second_and_leaves_the_rest() -> None:
    assert not any(isinstance(event, Thin) for event in flap_on_patch(NAME, spacing=2.0).events)
    procedure = flap_on_patch(NAME, {"thinned": 2.6, "diameter": 16.0}, spacing=2.0)
    (thin,) = [event for event in procedure.events if isinstance(event, Thin)]
    runs = [event for event in procedure.events if isinstance(event, SutureRun)]
    assert max(run.start + run.duration for run in runs) < thin.time
    assert thin.time + thin.duration <= procedure.end_time
    last = build_epochs(procedure)[-1]
    (gone,) = last.thinned
    chord = 8.0**2 * np.arcsin(5.0 / 8.0) - 5.0 * np.sqrt(8.0**2 - 5.0**2)  # of the pedicle, which is gone by then
    assert gone.volume == pytest.approx((np.pi * 8.0**2 - chord) * (4.0 - 2.6), rel=0.02)
    assert last.fragments == 2


def test_the_hooks_turn_it_one_way_however_far_their_corners_are_apart() -> None:
    hooks = [event for event in flap_on_patch(NAME, spacing=2.0).events if isinstance(event, Hook)]
    for hook in hooks:
        assert max(y for _, (_, y, _) in hook.targets) > 0.5 * abs(hook.anchor[0])
    plan = flap_plan(library_design(NAME), {"turn": 180.0})
    assert all(way[:, 1].max() > 0.9 * abs(way[0, 0]) for way in plan.ways)


def test_what_a_flap_turned_by_half_a_turn_asks_for_is_not_suspicious_but_for_its_length() -> None:
    assert [each.code for each in check(flap_on_patch(NAME, spacing=2.0))] == [ProblemCode.FLAP_NARROW_BASE]


@pytest.mark.parametrize(
    ("values", "wrong"),
    [
        ({"diameter": 10.9, "width": 10.0}, "10.9"),
        ({"diameter": 40.0, "distance": 29.0}, "29"),
        ({"distance": 30.0, "spare": 0.0, "stump": 14.0}, "14"),
    ],
)
def test_measures_that_contradict_each_other_are_refused(values: dict[str, float], wrong: str) -> None:
    with refuses(ProblemCode.DESIGN_RANGE, NAME) as found:
        drawn(**values)
    assert [each.value for each in found] == [wrong]
