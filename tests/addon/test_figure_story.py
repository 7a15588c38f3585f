"""Which frames a figure shows, what it says of them, and how its panels lie on the sheet."""

from __future__ import annotations

from itertools import pairwise

import pytest

import synthetic_skin_cache as synthetic
from lappet_blender.figure.figure_steps import MOST_PANELS, step_captions, story_steps
from lappet_blender.figure.sheet_layout import columns_for, sheet_layout
from lappet_blender.look.skin_read import SkinCache
from lappet_blender.look.skin_source import StepEvent


def test_the_filmstrip_tells_the_operation_in_order(cache: SkinCache) -> None:
    steps = story_steps(cache.events, cache.frames, synthetic.lift)
    assert [s.caption for s in steps] == [
        "Before",
        "Incised",
        "Lifted with hooks",
        "Laid in place",
        "Sutured",
        "Final result",
    ]
    assert [s.frame for s in steps] == [1, 3, 6, 7, 11, 12]
    assert steps[3].frame == max(
        f for f in cache.frames if f < min(e.start for e in cache.events if e.kind == "Suture")
    )
    assert all(a.frame < b.frame for a, b in pairwise(steps))
    assert steps[1].detail == "central limb"
    assert steps[4].detail == "4 sutures"


def test_a_flap_is_transposed_into_what_was_excised_and_the_edges_of_a_mere_excision_are_advanced() -> None:
    hook, closing = StepEvent("Hook", "tip", 6, 14), StepEvent("Suture", "corner", 12, 16)
    excision = [StepEvent("Incision", "defect", 2, 2), StepEvent("Excision", "defect", 4, 4)]
    frames = [float(t) for t in range(1, 18)]
    for cuts, word in ((excision, "Advanced"), ([*excision, StepEvent("Incision", "limbs", 2, 2)], "Laid in place")):
        captions = [step.caption for step in story_steps([*cuts, hook, closing], frames, lambda t: -abs(t - 8.0))]
        assert captions == ["Before", "Excised", "Lifted with hooks", word, "Sutured", "Final result"]


def test_the_story_names_undermining_and_tells_buried_sutures_apart() -> None:
    events = [
        StepEvent("Incision", "limb", 2, 2),
        StepEvent("Undermine", "around", 4, 4),
        StepEvent("Hook", "tip", 6, 12),
        *[StepEvent("Suture", f"s{k}", 9, 11) for k in range(5)],
        StepEvent("Excision", "dog_ear", 13, 13),
    ]
    frames = [float(t) for t in range(1, 15)]
    steps = story_steps(events, frames, buried=2)
    assert (steps[1].caption, steps[1].detail, steps[1].frame) == (
        "Incised and undermined",
        "limb; dashed: undermined",
        5,
    )
    assert [(s.caption, s.frame) for s in steps[3:]] == [("Laid in place", 8), ("Sutured", 11), ("Final result", 14)]
    assert steps[4].detail == "skin sutures over buried ones"
    assert story_steps(events, frames, buried=5)[4].detail == "5 buried sutures"


def test_the_story_of_an_excision_shows_the_hooks_at_work_and_the_wound_drawn_together() -> None:
    events = [
        StepEvent("Incision", "ellipse", 2, 2),
        StepEvent("Excision", "lesion", 3, 3),
        StepEvent("Hook", "near", 5, 10),
        *[StepEvent("Suture", f"s{k}", 6, 18) for k in range(3)],
    ]
    frames = [float(t) for t in range(1, 21)]
    steps = story_steps(events, frames, lambda t: -abs(t - 8.0))
    assert [(s.caption, s.frame) for s in steps] == [
        ("Before", 1),
        ("Excised", 4),
        ("Lifted with hooks", 8),
        ("Drawn together", 12),
        ("Sutured", 18),
        ("Final result", 20),
    ]


def test_a_story_never_has_more_panels_than_the_sheet_nor_two_of_one_frame() -> None:
    many = [
        StepEvent(k, f"{k}_{i}", 1 + i, 3 + i) for i in range(9) for k in ("Incision", "Excision", "Hook", "Suture")
    ]
    for frames in ([1.0], [1.0, 2.0], [float(t) for t in range(1, 60)]):
        steps = story_steps(many, frames)
        assert 1 <= len(steps) <= MOST_PANELS
        assert len({s.frame for s in steps}) == len(steps)
        assert {s.frame for s in steps} <= set(frames)
    bare = story_steps([], [float(t) for t in range(1, 40)])
    assert len(bare) == MOST_PANELS
    assert bare[0].caption == "Before"


def test_chosen_frames_are_captioned_by_their_number_and_newest_event() -> None:
    events = [StepEvent("Incision", "upper_limb", 3, 3), StepEvent("Suture", "tip", 8, 9)]
    steps = step_captions(events, [1.0, 5.0, 8.0])
    assert [(s.caption, s.detail) for s in steps] == [("Frame 1", ""), ("Frame 5", "upper limb"), ("Frame 8", "tip")]


@pytest.mark.parametrize("count", range(1, 7))
def test_panels_of_a_sheet_lie_inside_it_and_do_not_overlap(count: int) -> None:
    (width, height), corners, caption = sheet_layout(count, (640, 480))
    assert len(corners) == count
    assert columns_for(count) <= 3
    for k, (x, y) in enumerate(corners):
        assert x >= 0
        assert x + 640 <= width
        assert y + 480 + caption <= height
        for u, v in corners[:k]:
            assert abs(x - u) >= 640 or abs(y - v) >= 480 + caption
