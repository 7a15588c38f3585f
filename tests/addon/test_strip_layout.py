"""Strips in rows, what is under the mouse, and what a drag makes of them: no Blender, no window."""

from __future__ import annotations

import random
from itertools import combinations

import pytest

from lappet_blender.strips.step_names import proposed_steps
from lappet_blender.strips.strip import Part, Step, Strip, steps_of, strips_of_step
from lappet_blender.strips.strip_drag import Span, dragged, grabbed_edges, snap_targets, snapped
from lappet_blender.strips.strip_layout import HEADER, NAMED, Hit, StripView, hit, strip_picture, strip_rows

CUT = Strip("c", "incision_1", "INCISION", 2.0, 2.0)
PULL = Strip("h", "hook_1", "HOOK", 5.0, 25.0)
SEW = Strip("s", "suture_1", "SUTURE", 20.0, 24.0)
ALL = (CUT, PULL, SEW)
VIEW = StripView(left=-10.0, scale=10.0, top=200.0, bottom=20.0)


def many(seed: int, count: int = 60) -> list[Strip]:
    """Strips of all kinds, at random."""
    dice = random.Random(seed)
    kinds = ("INCISION", "HOOK", "SUTURE", "SUTURE_RUN", "RETRACTOR", "UNDERMINE")
    made = []
    for k in range(count):
        kind, start = dice.choice(kinds), float(dice.randint(1, 60))
        length = 0.0 if kind in ("INCISION", "UNDERMINE") else float(dice.randint(1, 20))
        made.append(Strip(f"u{k}", f"{kind.lower()}_{k}", kind, start, start + length))
    return made


@pytest.mark.parametrize("seed", range(8))
def test_strips_of_one_row_never_overlap_and_lanes_lie_in_order(seed: int) -> None:
    strips = many(seed)
    rows = strip_rows(strips)
    for a, b in combinations(strips, 2):
        if rows[a.uid] == rows[b.uid]:
            assert a.end <= b.start or b.end <= a.start
            assert a.start != b.start
        if a.lane < b.lane:
            assert rows[a.uid] < rows[b.uid]


@pytest.mark.parametrize("seed", range(4))
def test_a_lane_has_as_many_rows_as_strips_of_it_overlap_at_most(seed: int) -> None:
    strips = many(seed)
    rows = strip_rows(strips)
    for lane in range(3):
        members = [s for s in strips if s.lane == lane]
        deepest = max(sum(o.start <= s.start < max(o.end, o.start + 1e-6) for o in members) for s in members)
        assert len({rows[s.uid] for s in members}) == deepest


@pytest.mark.parametrize("height", [60.0, 150.0, 400.0])
def test_boxes_of_a_picture_do_not_overlap_and_stay_in_the_view(height: float) -> None:
    view = StripView(-1.0, 8.0, 20.0 + height, 20.0)
    picture = strip_picture(many(1), (), view)
    for a, b in combinations(picture.boxes, 2):
        assert a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
    assert max(box.y1 for box in picture.boxes) <= view.top
    if picture.row_height > 5.0:
        assert picture.bottom >= view.bottom - 1e-6


def test_names_beside_cuts_ask_for_room_only_where_rows_are_tall_enough_to_show_them() -> None:
    cuts = [Strip(f"c{k}", f"incision_{k}", "INCISION", 2.0 + k, 2.0 + k) for k in range(12)]
    tall = strip_picture(cuts, (), StripView(0.0, 10.0, 400.0, 0.0))
    assert tall.row_height >= NAMED
    assert len({box.y0 for box in tall.boxes}) > 1
    low = strip_picture(cuts, (), StripView(0.0, 10.0, 40.0, 0.0))
    assert len({box.y0 for box in low.boxes}) == 1


def box_of(uid: str, strips: tuple[Strip, ...] = ALL) -> tuple[float, float, float, float]:
    """The box of a strip in VIEW: x0, x1 and y0, y1."""
    box = next(each for each in strip_picture(strips, (), VIEW).boxes if each.strip.uid == uid)
    return box.x0, box.x1, box.y0, box.y1


def test_the_mouse_takes_the_ends_of_a_hook_and_its_body_between_them() -> None:
    picture = strip_picture(ALL, (), VIEW)
    x0, x1, y0, y1 = box_of("h")
    middle = 0.5 * (y0 + y1)
    assert (x0, x1) == (VIEW.x(5.0), VIEW.x(25.0))
    assert hit(picture, x0 + 1, middle) == Hit(Part.START, "h")
    assert hit(picture, x1 - 1, middle) == Hit(Part.END, "h")
    assert hit(picture, 0.5 * (x0 + x1), middle) == Hit(Part.BODY, "h")
    assert hit(picture, 0.5 * (x0 + x1), y1 + 1.0) != Hit(Part.BODY, "h")
    assert hit(picture, x1 + 60, middle) is None


def test_a_cut_is_taken_as_a_whole_wherever_it_is_pressed() -> None:
    picture = strip_picture(ALL, (), VIEW)
    x0, x1, y0, y1 = box_of("c")
    assert {hit(picture, x, 0.5 * (y0 + y1)) for x in (x0 + 0.5, 0.5 * (x0 + x1), x1 - 0.5)} == {Hit(Part.BODY, "c")}


def test_even_the_shortest_strip_has_a_body_to_be_dragged_by() -> None:
    short = (Strip("s", "suture_1", "SUTURE", 20.0, 20.5),)
    picture = strip_picture(short, (), VIEW)
    x0, x1, y0, y1 = box_of("s", short)
    assert hit(picture, 0.5 * (x0 + x1), 0.5 * (y0 + y1)) == Hit(Part.BODY, "s")
    assert hit(picture, x1, 0.5 * (y0 + y1)) == Hit(Part.END, "s")


def test_a_press_on_the_name_of_a_step_takes_the_step() -> None:
    steps = steps_of([("Incised", 2.0), ("Raised", 5.0)], 40.0)
    picture = strip_picture(ALL, steps, VIEW)
    found = hit(picture, VIEW.x(3.0), VIEW.top - 0.5 * HEADER)
    assert found is not None
    assert (found.part, found.step) == (Part.STEP, steps[0])
    assert max(box.y1 for box in picture.boxes) <= VIEW.top - HEADER


def test_pixels_and_frames_are_inverse() -> None:
    for frame in (-3.0, 0.0, 12.5, 99.0):
        assert VIEW.frame(VIEW.x(frame)) == pytest.approx(frame)


def test_markers_part_the_events_into_steps_without_gaps() -> None:
    steps = steps_of([("Sutured", 20.0), ("Incised", 1.0), ("Raised", 5.0), ("Also raised", 5.0)], 40.0)
    assert [(s.name, s.start, s.end) for s in steps] == [
        ("Incised", 1.0, 5.0),
        ("Also raised", 5.0, 20.0),
        ("Sutured", 20.0, 41.0),
    ]
    assert [strips_of_step(step, ALL) for step in steps] == [["c"], ["h"], ["s"]]
    assert steps_of([], 40.0) == ()


def test_a_body_takes_both_ends_along_and_an_end_only_itself() -> None:
    assert dragged(ALL, Part.BODY, 3.0) == {"c": Span(5.0, 5.0), "h": Span(8.0, 28.0), "s": Span(23.0, 27.0)}
    assert dragged(ALL, Part.END, 2.0) == {"c": Span(2.0, 2.0), "h": Span(5.0, 27.0), "s": Span(20.0, 26.0)}
    assert dragged(ALL, Part.START, -2.0) == {"c": Span(2.0, 2.0), "h": Span(3.0, 25.0), "s": Span(18.0, 24.0)}


def test_an_end_stops_at_the_other_and_a_hook_keeps_a_frame() -> None:
    assert dragged([PULL], Part.END, -50.0) == {"h": Span(5.0, 6.0)}
    assert dragged([PULL], Part.START, 50.0) == {"h": Span(24.0, 25.0)}
    assert dragged([SEW], Part.END, -50.0) == {"s": Span(20.0, 20.0)}
    short = Strip("q", "hook_2", "HOOK", 5.0, 5.5)  # shorter than that already: it does not jump
    assert dragged([short], Part.END, -3.0) == {"q": Span(5.0, 5.5)}
    assert dragged([short], Part.START, 3.0) == {"q": Span(5.0, 5.5)}


def test_a_drag_snaps_to_the_nearest_frame_of_another_strip_else_to_whole_frames() -> None:
    targets = snap_targets(ALL, {"h"}, steps_of([("Sutured", 30.0)], 40.0), (12.25,))
    assert targets == (2.0, 12.25, 20.0, 24.0, 30.0)
    edges = grabbed_edges(PULL, Part.BODY)
    assert edges == (5.0, 25.0)
    assert snapped(4.8, edges, targets, 0.5) == (5.0, 30.0)  # its end to the step
    assert snapped(7.1, edges, targets, 0.5) == (7.25, 12.25)  # its start to the playhead
    assert snapped(9.4, edges, targets, 0.1) == (9.0, None)
    assert snapped(0.6, (5.5,), (), 0.5) == (0.5, None)  # a begin between frames goes to a whole one


def test_steps_follow_the_runs_of_cuts_pulls_and_sutures() -> None:
    assert proposed_steps(ALL, 1, 40) == [
        ("step.plan", 1),
        ("step.incised", 2),
        ("step.raised", 5),
        ("step.sutured", 20),
        ("step.result", 25),
    ]


def test_steps_of_an_excision_in_two_stages_and_events_that_are_off() -> None:
    strips = [
        Strip("e", "e", "EXCISION", 1.0, 1.0),
        Strip("i", "i", "INCISION", 1.0, 1.0),
        Strip("u", "u", "UNDERMINE", 3.0, 3.0),
        Strip("r", "r", "RETRACTOR", 4.0, 9.0),
        Strip("off", "off", "SUTURE", 5.0, 6.0, enabled=False),
        Strip("i2", "i2", "INCISION", 10.0, 10.0),
        Strip("s", "s", "SUTURE_RUN", 12.0, 30.0),
    ]
    assert proposed_steps(strips, 1, 30) == [
        ("step.excised-undermined", 1),
        ("step.retracted", 4),
        ("step.incised", 10),
        ("step.sutured", 12),
        ("step.result", 30),
    ]
    assert proposed_steps([], 1, 30) == []
    assert proposed_steps([strips[4]], 1, 30) == []


def test_a_step_holds_what_begins_in_it() -> None:
    step = Step("Raised", 5.0, 20.0)
    assert step.holds(PULL)
    assert not step.holds(CUT)
    assert not step.holds(SEW)
