"""The usual stitches: where their bites are, and how long their threads are when the wound is closed."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from lappet.procedure.stitches import (
    Station,
    Stitch,
    deep_dermal,
    figure_of_eight,
    half_buried_mattress,
    horizontal_mattress,
    running,
    simple,
    vertical_mattress,
)

TOP = 3.0
AT = Station((0.0, 0.0, TOP), (0.0, 2.0, 0.0), gap=1.0)

LOOPS: dict[str, Callable[[Station], Stitch]] = {
    "simple": lambda at: simple(at, 4.0, 2.0),
    "vertical": lambda at: vertical_mattress(at, 2.0, far=6.0, near=1.5, shallow=1.0),
    "horizontal": lambda at: horizontal_mattress(at, 2.0, bite=6.0, along=6.0),
    "half buried": lambda at: half_buried_mattress(at, 2.0, bite=6.0, along=6.0),
    "dermal": lambda at: deep_dermal(at, 2.5, 1.0, 4.0),
    "eight": lambda at: figure_of_eight(at, 2.0, bite=4.0, along=6.0),
}

# By hand, of a closed wound.
LENGTHS = {
    "simple": 2.0 * (8.0 + 2.0),
    "vertical": (12.0 + 2 * 2.0) + 4.5 + (3.0 + 2 * 1.0) + 4.5,
    "horizontal": 2 * (12.0 + 2 * 2.0) + 2 * 6.0,
    "half buried": 2 * (12.0 + 2.0) + 2 * 6.0,
    "dermal": 2 * (8.0 + 1.5),
    "eight": 2 * (8.0 + 2 * 2.0) + 2 * math.hypot(8.0, 6.0),
}


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_is_tied_where_it_begins_and_as_long_as_it_is_in_the_closed_wound(name: str) -> None:
    stitch = LOOPS[name](AT)
    assert stitch.bites[0] == stitch.bites[-1]
    assert stitch.length == pytest.approx(LENGTHS[name])
    closed = LOOPS[name](Station(AT.spot, AT.across))
    assert sum(math.dist(a, b) for a, b in pairwise(closed.bites)) == pytest.approx(stitch.length)
    # Open, each point is half the gap farther out.
    apart = np.abs(np.array(stitch.bites) - np.array(closed.bites))
    assert np.allclose(apart, (0.0, 0.5, 0.0))


def test_a_vertical_mattress_goes_far_far_near_near() -> None:
    bites = np.array(vertical_mattress(AT, 2.0, far=6.0, near=1.5, shallow=1.0).bites)
    assert bites[:, 1].tolist() == [-6.5, -6.5, 6.5, 6.5, 2.0, 2.0, -2.0, -2.0, -6.5]
    assert (TOP - bites[:, 2]).tolist() == [0.0, 2.0, 2.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]


def test_a_half_buried_mattress_does_not_come_out_behind_the_wound() -> None:
    bites = np.array(half_buried_mattress(AT, 2.0).bites)
    assert set(bites[bites[:, 1] > 0.0, 2].tolist()) == {TOP - 2.0}
    assert TOP in bites[bites[:, 1] < 0.0, 2]


def test_a_buried_stitch_lies_in_the_tissue_and_is_tied_below() -> None:
    depths = TOP - np.array(deep_dermal(AT, 2.5, 1.0).bites)[:, 2]
    assert depths.tolist() == [2.5, 1.0, 1.0, 2.5, 2.5]


def test_the_threads_of_a_figure_of_eight_cross_above_the_wound() -> None:
    bites = np.array(figure_of_eight(AT, 2.0).bites)
    over = [(a, b) for a, b in pairwise(bites) if a[2] == b[2] == TOP]
    assert len(over) == 2
    for a, b in over:
        assert np.allclose(0.5 * (a + b), AT.spot)


def test_on_the_skin_a_simple_stitch_has_two_bites_and_closes_by_the_gap() -> None:
    stitch = simple(AT, 4.0)
    assert stitch.bites == ((0.0, -4.5, TOP), (0.0, 4.5, TOP))
    assert stitch.length == 8.0


@pytest.mark.parametrize(("depth", "each"), [(0.0, 8.0), (2.0, 12.0)])
def test_a_running_suture_goes_from_place_to_place_and_is_open(depth: float, each: float) -> None:
    stations = [Station((x, 0.0, TOP), (0.0, 1.0, 0.0), gap=gap) for x, gap in ((0.0, 1.0), (6.0, 3.0), (12.0, 1.0))]
    stitch = running(stations, 4.0, depth)
    assert len(stitch.bites) == 3 * (2 if depth == 0.0 else 4)
    assert stitch.bites[0] != stitch.bites[-1]
    assert stitch.length == pytest.approx(3 * each + 2 * math.hypot(8.0, 6.0))


def test_a_stitch_stands_on_the_skin_whatever_its_direction_and_length() -> None:
    outward = np.array([1.0, 2.0, 2.0]) / 3.0
    across = np.array([3.0, -1.0, 5.0])  # not tangential
    at = Station((1.0, 2.0, 3.0), tuple(across.tolist()), tuple((7.0 * outward).tolist()))
    for bite, depth in zip(simple(at, 4.0, 2.0).bites, (0.0, 2.0, 2.0, 0.0, 0.0), strict=True):
        assert (np.array(bite) - at.spot) @ outward == pytest.approx(-depth)
        assert np.linalg.norm(np.array(bite) - at.spot) == pytest.approx(math.hypot(4.0, depth))


def test_the_event_is_a_thread_that_is_drawn_to_a_share_of_the_length() -> None:
    stitch = simple(AT, 4.0, 2.0)
    suture = stitch.suture("stitch", 3.0, 0.8, thread="nylon 5-0", duration=2.0)
    assert (suture.mode, suture.anchors, suture.start, suture.duration) == ("thread", stitch.bites, 3.0, 2.0)
    assert suture.length == pytest.approx(0.8 * 20.0)
    # E A of 2500 MPa and 0.125 mm over the thread in the open wound
    assert suture.axial_stiffness == pytest.approx(2.5e6 * math.pi * 0.125**2 / 4.0 / 22.0)
