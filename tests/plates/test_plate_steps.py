"""Panels of a second stage: a flap sewn in, and cut from its pedicle."""

from __future__ import annotations

from lappet.drawing.skin_source import StepEvent
from lappet.plates.plate_steps import StepKind, second_stage

FRAMES = [float(time) for time in range(1, 31)]
FIRST = (
    StepEvent("Incision", "flap", 2.0, 2.0),
    StepEvent("Hook", "carries", 4.0, 14.0),
    StepEvent("Hook", "holds", 4.0, 20.0),
    StepEvent("Suture", "inset", 10.0, 16.0),
)
DIVISION = (StepEvent("Incision", "division", 20.0, 20.0), StepEvent("Excision", "pedicle", 21.0, 21.0))


def test_a_cut_after_all_sutures_makes_a_panel_before_it_and_one_after_it() -> None:
    later = StepEvent("Suture", "rejoined", 24.0, 28.0)
    steps = second_stage(FRAMES, (*FIRST, *DIVISION, later))
    assert [(step.time, step.kind) for step in steps] == [(19.0, StepKind.ON_PEDICLE), (23.0, StepKind.DIVIDED)]
    steps = second_stage(FRAMES, (*FIRST, *DIVISION))
    assert [(step.time, step.kind) for step in steps] == [(19.0, StepKind.ON_PEDICLE), (29.0, StepKind.DIVIDED)]


def test_a_cut_while_sutures_are_drawn_or_where_no_hook_held_until_it_is_no_second_stage() -> None:
    drawn = StepEvent("Suture", "drawn", 18.0, 24.0)
    assert second_stage(FRAMES, (*FIRST, *DIVISION, drawn)) == []
    assert second_stage(FRAMES, FIRST) == []
    assert second_stage(FRAMES, (*FIRST[:2], FIRST[3], *DIVISION)) == []
