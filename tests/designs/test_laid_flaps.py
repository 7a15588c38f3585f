"""Tests of laid flaps: what is remembered of them, and how they are changed afterwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.designs.flap_handles import HandledFlap
from lappet.designs.laid_flaps import by_hand, changed_flap, laid_flap, relay
from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import add_flap
from lappet.procedure import LaidFlap, Landmark, Material, Procedure, SutureRun
from lappet.tissue import flat_patch
from lappet.tissue.dome import dome_scalp
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import read_procedure, write_procedure

TOP = 4.0


@pytest.fixture(scope="module")
def limberg() -> Procedure:
    patch = Procedure(flat_patch((120.0, 100.0, TOP), spacing=4.0), start_time=1, end_time=1)
    marked = patch.with_events(Landmark("mole", ((40.0, 40.0, TOP),), "mole"))
    return add_flap(marked, "limberg", (0.0, 0.0, TOP), (1.0, 0.0, 0.0), {"side": 12.0}, start=1)


@pytest.fixture(scope="module")
def wide() -> Procedure:
    return Procedure(flat_patch((400.0, 400.0, TOP), spacing=20.0))


def test_a_file_remembers_how_its_flaps_were_laid(limberg: Procedure, tmp_path: object) -> None:
    two = add_flap(
        limberg, "z-plasty", (-30.0, 15.0, TOP), (0.0, 1.0, 0.0), {"limb": 12.0}, mirrored=True, lines="across"
    )
    write_procedure(two, f"{tmp_path}/two.usda")
    back = read_procedure(f"{tmp_path}/two.usda")
    assert back == two
    first, second = back.flaps
    assert (first.name, first.design, dict(first.measures)) == ("limberg", "limberg", {"side": 12.0})
    assert (second.mirrored, second.lines) == (True, "across")
    assert {*first.events, *second.events, "mole"} == {event.name for event in back.events}


def test_a_flap_laid_anew_is_the_one_laid_so_from_the_start(limberg: Procedure) -> None:
    changed = changed_flap(limberg, laid_flap(limberg, "limberg"), at=(5.0, -8.0, TOP), measures={"side": 9.0})
    moved = relay(limberg, changed)
    patch = replace(limberg, events=limberg.events[:1], flaps=(), end_time=1.0)
    assert moved == add_flap(patch, "limberg", (5.0, -8.0, TOP), (1.0, 0.0, 0.0), {"side": 9.0}, start=1)
    assert by_hand(limberg, "limberg") == by_hand(moved, "limberg") == []


def test_the_second_flap_keeps_the_names_of_its_events_when_it_is_laid_anew(limberg: Procedure) -> None:
    two = add_flap(limberg, "limberg", (-35.0, 20.0, TOP), (0.0, 1.0, 0.0), {"side": 8.0}, start=41)
    assert [flap.name for flap in two.flaps] == ["limberg", "limberg_2"]
    moved = relay(two, changed_flap(two, laid_flap(two, "limberg_2"), at=(-35.0, -20.0, TOP)))
    assert [event.name for event in moved.events] == [event.name for event in two.events]
    labels = [event.label for event in moved.events if isinstance(event, Landmark)]
    assert labels == [event.label for event in two.events if isinstance(event, Landmark)]


def test_what_was_changed_by_hand_is_named_when_it_is_lost(limberg: Procedure) -> None:
    run = next(event for event in limberg.events if isinstance(event, SutureRun))
    events = tuple(replace(e, spacing=7.0) if e is run else e for e in limberg.events if e.name != "hook_tip")
    (found,) = by_hand(replace(limberg, events=events), "limberg")
    assert (found.code, found.severity) == (ProblemCode.FLAP_BY_HAND, "warning")
    assert set(found.value.split(", ")) == {run.name, "hook_tip"}


def test_a_flap_that_was_laid_along_skin_lines_follows_them_where_it_is_moved_to() -> None:
    tissue = dome_scalp(60.0, 45.0, 5.0, 4.0, spacing=4.0)
    lined = Material("lined", fiber_k1=10.0, fiber_direction=(0.0, 1.0, 0.0))
    bare = Procedure(replace(tissue, material="lined"), (lined,), start_time=1, end_time=1)
    skin = SkinSheet.of(tissue)
    top, side = (skin.at(place)[0][0] for place in ((0.0, 0.0, 70.0), (15.0, 10.0, 70.0)))
    laid = add_flap(bare, "limberg", top, (0.0, 1.0, 0.0), {"side": 6.0}, lines="along")
    flap = changed_flap(laid, laid.flaps[0], at=side)
    normal = skin.at(side)[1][0]
    assert abs(np.dot(flap.direction, normal)) < 1e-6
    assert flap.direction[1] > 0.9
    turned = changed_flap(laid, laid.flaps[0], at=side, direction=(1.0, 0.0, 0.0))
    assert (turned.lines, turned.direction) == ("", (1.0, 0.0, 0.0))


# Measures that move no corner of the plan: where a lip has no free border, a blade's direction, and a thickness.
WITHOUT_HANDLE = {"millard": {"drop", "blade_turn", "blade_lift", "undermined"}, "paramedian-forehead": {"thinned"}}


@pytest.mark.parametrize("name", DESIGNS)
def test_every_measure_but_a_count_has_a_handle_that_leaves_the_design_as_it_is_where_it_is(
    wide: Procedure, name: str
) -> None:
    measures = tuple(DESIGNS[name].values({}).items())
    laid = LaidFlap(name.replace("-", "_"), name, (0.0, 0.0, TOP), (1.0, 0.0, 0.0), measures)
    flap = HandledFlap(wide, laid)
    handles = flap.handles()
    without = WITHOUT_HANDLE.get(name, set())
    measured = [each for each in DESIGNS[name].parameters if not each.whole and each.name not in without]
    assert [handle.name for handle in handles] == ["place", "turn", *(each.name for each in measured)]
    points = np.array([handle.point for handle in handles])
    apart = np.linalg.norm(points[:, None] - points, axis=2)[~np.eye(len(points), dtype=bool)]
    assert apart.min() > 1.0
    last = handles[-1]
    assert dict(flap.move(last.name, last.point).measures) == pytest.approx(dict(laid.measures), rel=2e-3, abs=0.02)


def test_a_handle_that_is_dragged_by_some_millimetres_changes_its_measure_so_far(limberg: Procedure) -> None:
    """The handle of a rhombus's side is the corner that it moves most: by so much more is the side longer."""
    flap = HandledFlap(limberg, laid_flap(limberg, "limberg"))
    _, _, side = flap.handles()
    at = np.array(side.point)
    longer = dict(flap.move("side", at * 1.25).measures)  # the design lies at the origin
    assert longer["side"] == pytest.approx(15.0, abs=0.02)
    assert flap.handles()[2].point[:2] == pytest.approx((1.25 * at)[:2], abs=0.1)


def test_the_place_and_the_direction_follow_their_handles(limberg: Procedure) -> None:
    flap = HandledFlap(limberg, laid_flap(limberg, "limberg"))
    assert flap.move("place", (10.0, 5.0, TOP + 3.0)).at == pytest.approx((10.0, 5.0, TOP))
    assert flap.move("turn", (10.0, 35.0, TOP)).direction == pytest.approx((0.0, 1.0, 0.0), abs=1e-4)
    turn = flap.handles()[1].point
    assert (turn[0], turn[1] > 10.0) == (pytest.approx(10.0, abs=0.05), True)


def test_a_measure_stays_in_its_range_however_far_its_handle_is_dragged(limberg: Procedure) -> None:
    flap = HandledFlap(limberg, laid_flap(limberg, "limberg"))
    side = flap.handles()[2].point
    assert dict(flap.move("side", 0.01 * np.array(side)).measures)["side"] == DESIGNS["limberg"].parameters[0].least


def test_flaps_and_handles_that_are_not_there_are_refused(limberg: Procedure) -> None:
    with pytest.raises(RefusedError) as found:
        laid_flap(limberg, "bilobed")
    assert found.value.problems[0].code == ProblemCode.FLAP_UNKNOWN
    with pytest.raises(RefusedError) as found:
        HandledFlap(limberg, laid_flap(limberg, "limberg")).move("angle", (0.0, 0.0, TOP))
    assert found.value.problems[0].code == ProblemCode.FLAP_HANDLE
