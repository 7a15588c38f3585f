"""Sutures that pair the wrong partners are told; those that close what designs open are not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.designs import Row, Schedule, Technique, flap_operation, limberg
from lappet.procedure import Excision, Hook, Incision, Procedure, Suture
from lappet.procedure.stitches import (
    Station,
    deep_dermal,
    figure_of_eight,
    half_buried_mattress,
    horizontal_mattress,
    running,
    simple,
    vertical_mattress,
)
from lappet.program.compile import compile_program
from lappet.tissue.dome import dome_scalp, draped
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_sheet import SkinSheet

TOP = 4.0
AT = (-12.0, -6.0, 0.0, 6.0, 12.0)


def suture(name: str, first: tuple[float, float], second: tuple[float, float]) -> Suture:
    """A suture on the skin of the patch."""
    return Suture(name, ((*first, TOP), (*second, TOP)), 3.0)


def told(sutures: list[Suture], *cuts: Incision | Excision) -> list[Problem]:
    """What is told of sutures on a patch with these cuts."""
    tissue = flat_patch((80.0, 60.0, TOP), resolution=4.0, spacing=2.0)
    procedure = Procedure(tissue, events=(*cuts, *sutures), end_time=4.0)
    return list(compile_program(procedure).notes)


SLIT = Incision("slit", 2.0, ((-20.0, 0.0, TOP), (20.0, 0.0, TOP)))


def row(partner: list[int], inset: float = 1.0) -> list[Suture]:
    """Sutures of a slit whose other ends are at these places of the row."""
    return [suture(f"s{i}", (x, inset), (AT[partner[i]], -inset)) for i, x in enumerate(AT)]


@pytest.mark.parametrize("inset", [0.05, 1.0, 3.0])
def test_sutures_that_close_a_slit_in_order_are_not_told(inset: float) -> None:
    assert told(row([0, 1, 2, 3, 4], inset), SLIT) == []


def test_two_sutures_with_each_others_partners_are_told_once_with_their_places() -> None:
    (found,) = told(row([0, 2, 1, 3, 4]), SLIT)
    assert (found.code, found.severity) == (ProblemCode.SUTURES_CROSSED, "warning")
    assert {found.prim.rpartition("/")[2], found.value} == {"s1", "s2"}
    assert found.place is not None
    assert np.array(found.place.points) == pytest.approx(
        np.array([(-6, 1, TOP), (0, -1, TOP), (0, 1, TOP), (-6, -1, TOP)]), abs=1e-6
    )


def test_one_suture_that_crosses_all_others_is_the_one_that_is_told() -> None:
    crossing = suture("astray", (-16.0, 1.0), (16.0, -1.0))
    (found,) = told([*row([0, 1, 2, 3, 4]), crossing], SLIT)
    assert found.prim.endswith("/astray")
    assert "and 2 more" in found.value


def stations(places: Sequence[float]) -> list[Station]:
    return [Station((x, 0.0, TOP), (0.0, 1.0, 0.0)) for x in places]


def threads(depth: float) -> dict[str, Suture]:
    """The usual stitches at x = 0, and a running suture along the slit."""
    (at,) = stations([0.0])
    made = {
        "simple": simple(at, 2.0, depth),
        "vertical": vertical_mattress(at, 2.0 * depth),
        "horizontal": horizontal_mattress(at, depth),
        "half": half_buried_mattress(at, depth),
        "dermal": deep_dermal(at, 2.0 * depth),
        "eight": figure_of_eight(at, depth),
    }
    return {name: stitch.suture(name, 3.0) for name, stitch in made.items()}


@pytest.mark.parametrize("name", ["simple", "vertical", "horizontal", "half", "dermal", "eight"])
def test_a_stitch_of_many_bites_between_others_in_order_is_not_told_and_one_that_crosses_them_is(name: str) -> None:
    thread = threads(1.5)[name]
    assert told([*row([0, 1, 2, 3, 4])[:2], thread, *row([0, 1, 2, 3, 4])[3:]], SLIT) == []
    askew = [suture("one", (-16.0, 1.0), (16.0, -1.0)), suture("other", (18.5, 1.0), (18.5, -1.0))]
    (found,) = told([*askew, thread], SLIT)
    assert {found.prim.rpartition("/")[2], found.value} == {"one", name}


@pytest.mark.parametrize("depth", [0.0, 1.5])
def test_a_running_suture_is_not_told_with_others_between_its_passes_and_is_with_one_across_them(depth: float) -> None:
    thread = running(stations(AT), 2.0, depth).suture("running", 3.0)
    between = [suture(f"s{k}", (x, 1.0), (x, -1.0)) for k, x in enumerate((-9.0, 3.0))]
    assert told([thread, *between], SLIT) == []
    (found,) = told([thread, suture("astray", (-9.0, 1.0), (9.0, -1.0))], SLIT)
    assert {found.prim.rpartition("/")[2], found.value} == {"running", "astray"}


def test_a_cut_that_parts_the_patch_has_the_same_order() -> None:
    through = replace(SLIT, points=((-50.0, 0.0, TOP), (50.0, 0.0, TOP)))
    assert told(row([0, 1, 2, 3, 4]), through) == []
    assert [each.code for each in told(row([0, 2, 1, 3, 4]), through)] == [ProblemCode.SUTURES_CROSSED]


def test_an_island_is_sewn_back_around_but_not_with_two_partners_exchanged() -> None:
    turn = 2.0 * np.pi * (np.arange(6) + 0.5) / 6
    ring = 12.0 * np.stack([np.cos(turn - 0.3), np.sin(turn - 0.3)], axis=1)
    island = Incision("island", 2.0, tuple((x, y, TOP) for x, y in ring.tolist()), closed=True)
    out, into = (r * np.stack([np.cos(turn), np.sin(turn)], axis=1) for r in (13.5, 9.5))

    def sewn(partner: list[int]) -> list[Suture]:
        return [suture(f"s{i}", tuple(out[i]), tuple(into[partner[i]])) for i in range(6)]

    assert told(sewn([0, 1, 2, 3, 4, 5]), island) == []
    assert told(sewn([2, 3, 4, 5, 0, 1]), island) == [], "turned by a third"
    (found,) = told(sewn([0, 2, 1, 3, 4, 5]), island)
    assert {found.prim.rpartition("/")[2], found.value} == {"s1", "s2"}


def test_sutures_away_from_any_wound_are_not_told() -> None:
    tacking = [suture("one", (-10.0, 20.0), (10.0, 25.0)), suture("two", (-10.0, 25.0), (10.0, 20.0))]
    assert told(tacking, SLIT) == []


def test_the_rows_of_a_flap_on_curved_skin_hold_their_own_edges_however_deep() -> None:
    tissue = dome_scalp(90.0, 40.0, 6.0, resolution=4.0, spacing=2.0)
    how = Technique(beyond=8.0, apart=3.0, rows=(Row("galea", 4.7), Row("skin", 0.0)))
    design = limberg((0.0, 0.0, 90.0), (1.0, 0.0, 0.0), 12.0, project=draped(90.0))
    events = flap_operation(design, SkinSheet.of(tissue), Schedule(), how)
    procedure = Procedure(tissue, events=tuple(e for e in events if not isinstance(e, Hook)), end_time=Schedule().end)
    epochs = build_epochs(procedure)
    assert compile_program(procedure, epochs).notes == ()
    sutures = {event.name: event for event in events if isinstance(event, Suture)}
    one, other = sutures["galea_near_1"], sutures["galea_near_3"]
    wrong = (
        replace(one, anchors=(one.anchors[0], other.anchors[1])),
        replace(other, anchors=(other.anchors[0], one.anchors[1])),
    )
    crossed = replace(procedure, events=tuple({e.name: e for e in wrong}.get(e.name, e) for e in procedure.events))
    codes = {each.code for each in compile_program(crossed, epochs).notes}
    assert codes == {ProblemCode.SUTURES_CROSSED}
