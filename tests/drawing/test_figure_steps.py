"""Which frames a figure shows, and what it says of them."""

from __future__ import annotations

from itertools import pairwise
from typing import cast

import numpy as np

import synthetic_skin_cache as synthetic
from lappet.drawing.figure_steps import MOST_PANELS, hook_height, step_captions, story_steps
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SkinSource, StepEvent, Strands


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
    assert steps[1].detail == "1 incision"
    assert steps[4].detail == "4 sutures"


def test_a_flap_is_transposed_into_what_was_excised_and_the_edges_of_a_mere_excision_are_advanced() -> None:
    hook, closing = StepEvent("Hook", "tip", 6, 14), StepEvent("Suture", "corner", 12, 16)
    excision = [StepEvent("Incision", "defect", 2, 2), StepEvent("Excision", "defect", 4, 4)]
    frames = [float(t) for t in range(1, 18)]
    for cuts, word in ((excision, "Advanced"), ([*excision, StepEvent("Incision", "limbs", 2, 2)], "Laid in place")):
        captions = [step.caption for step in story_steps([*cuts, hook, closing], frames, lambda t: -abs(t - 8.0))]
        assert captions == ["Before", "Excised", "Lifted with hooks", word, "Sutured", "Final result"]


def test_a_flap_on_the_side_of_a_head_is_lifted_most_where_it_stands_out_most_from_the_skin_there() -> None:
    class Sideways:
        """A hook that rises along x, up to frame 9, while it goes along z; another one that is never active."""

        def hooks(self, time: float) -> Strands:
            held = [[8.0 - abs(time - 9.0), 0.0, -100.0 + 3.0 * time], [0.0, 0.0, 0.0]]
            ends = np.repeat(np.array(held, np.float32)[:, None], 2, axis=1)
            return Strands(ends, np.array([6 <= time < 14, False]))

    height = hook_height(cast(SkinSource, Sideways()), np.array([1.0, 0.0, 0.0]))
    assert height(5.0) == -np.inf
    hook, closing = StepEvent("Hook", "tip", 6, 14), StepEvent("Suture", "corner", 12, 16)
    steps = story_steps([StepEvent("Incision", "limb", 2, 2), hook, closing], [float(t) for t in range(1, 18)], height)
    assert [step.frame for step in steps if step.caption == "Lifted with hooks"] == [9.0]


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
        "1 incision; dashed: undermined",
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


def test_a_flap_that_is_divided_later_is_shown_sewn_in_on_its_pedicle_and_cut_from_it() -> None:
    events = [
        StepEvent("Incision", "limbs", 2, 2),
        StepEvent("Undermine", "around", 4, 4),
        StepEvent("Hook", "tip", 5, 9),
        StepEvent("Hook", "pedicle", 5, 14),
        *[StepEvent("Suture", f"s{k}", 8, 12) for k in range(3)],
        StepEvent("Incision", "division", 14, 14),
        StepEvent("Excision", "pedicle", 14, 14),
        *[StepEvent("Suture", f"r{k}", 15, 18) for k in range(2)],
    ]
    steps = story_steps(events, [float(t) for t in range(1, 21)], lambda t: -abs(t - 6.0))
    assert [(s.caption, s.frame) for s in steps] == [
        ("Before", 1),
        ("Incised and undermined", 4),
        ("Lifted with hooks", 6),
        ("Sewn in", 13),
        ("Pedicle divided", 14),
        ("Final result", 20),
    ]
    thinned = story_steps([*events, StepEvent("Thin", "thin", 18, 19)], [float(t) for t in range(1, 21)])
    assert (len(thinned), thinned[-1].caption, thinned[-1].detail) == (MOST_PANELS, "Final result", "the flap thinned")
    alone = story_steps([StepEvent("Thin", "thin", 4, 7)], [float(t) for t in range(1, 11)])
    assert [(s.caption, s.frame) for s in alone] == [("Before", 1), ("Flap thinned", 7), ("Final result", 10)]


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
    assert [(s.caption, s.detail) for s in steps] == [("Frame 1", ""), ("Frame 5", "incised"), ("Frame 8", "sutured")]


def test_no_caption_holds_the_name_of_an_event() -> None:
    events = [
        StepEvent("Incision", "limb_7", 2, 2),
        StepEvent("Hook", "tip_7", 4, 8),
        StepEvent("Suture", "s_7", 9, 11),
    ]
    frames = [float(t) for t in range(1, 15)]
    told = [*story_steps(events, frames, lambda time: -abs(time - 6.0)), *step_captions(events, frames)]
    assert not any("7" in f"{step.caption.removeprefix(f'Frame {step.frame:g}')} {step.detail}" for step in told)
