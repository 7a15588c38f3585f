"""What the Solve panel shows: drawn into a layout that writes down what it is given."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from fake_worker import Script
from lappet.background.assessment import Assessment, Pull, assessment_key
from lappet.core.problem import Place, Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure.prim_paths import TIMELINE
from lappet.solve.error_estimate import FrameErrorEstimate
from lappet_blender.events.timeline_panel import draw_fields
from lappet_blender.model.event_list import add_event, find_event
from lappet_blender.model.units import to_mm
from lappet_blender.solving import controller, frames, reconcile, speed_estimate
from lappet_blender.solving.solve_panel import LAPPET_PT_solve, LAPPET_PT_solve_settings
from lappet_blender.solving.solve_timer import run_timer
from solving_steps import QUIET, solve

pytest_plugins = ("solving_fixtures",)


class Layout:
    """Takes what a panel's layout takes and keeps it; refuses operators and properties that do not exist."""

    def __init__(self, drawn: list[tuple[str, str]]) -> None:
        self.drawn = drawn

    def row(self, **_: Any) -> Layout:
        return Layout(self.drawn)

    column = box = row

    def label(self, text: str = "", icon: str = "NONE") -> None:
        self.drawn.append(("label", text))

    def progress(self, factor: float, text: str) -> None:
        assert 0.0 <= factor <= 1.0
        self.drawn.append(("bar", text))

    def operator(self, name: str, text: str = "", **_: Any) -> SimpleNamespace:
        part, _, operator = name.partition(".")
        getattr(getattr(bpy.ops, part), operator).get_rna_type()
        self.drawn.append(("operator", name))
        return SimpleNamespace()

    def prop(self, owner: Any, name: str, **_: Any) -> None:
        getattr(owner, name)
        self.drawn.append(("property", name))

    def popover(self, panel: str, **_: Any) -> None:
        assert hasattr(bpy.types, panel)
        self.drawn.append(("popover", panel))


def draw(panel: Any) -> tuple[str, list[str]]:
    """(all text in a row, operators)"""
    drawn: list[tuple[str, str]] = []
    panel.draw(SimpleNamespace(layout=Layout(drawn)), bpy.context)
    words = " ".join(text for kind, text in drawn if kind in ("label", "bar"))
    return words, [name for kind, name in drawn if kind == "operator"]


def test_without_tissue_it_says_what_to_do(scene: bpy.types.Scene, script: Script) -> None:
    words, _ = draw(LAPPET_PT_solve)
    assert "Make a mesh the tissue first." in words


def test_it_offers_to_solve_then_to_cancel_and_counts(patch: bpy.types.Scene, script: Script) -> None:
    run_timer(QUIET)
    words, operators = draw(LAPPET_PT_solve)
    assert "0 / 8" in words
    assert "0 of 8 frames solved" in words
    assert operators == ["lappet.solve", "lappet.live"]
    bpy.ops.lappet.solve()
    for _ in range(6):
        run_timer()
    words, operators = draw(LAPPET_PT_solve)
    assert operators[0] == "lappet.solve_cancel"
    done = frames.progress_of(patch).done
    assert done > 0
    assert f"{done} / 8" in words
    assert " left" in words
    run_timer(QUIET)
    assert "8 of 8 frames solved" in draw(LAPPET_PT_solve)[0]


def test_stale_frames_are_counted_with_the_time_that_they_will_take(patch: bpy.types.Scene, script: Script) -> None:
    solve(patch)
    find_event(patch, "hook_1").stiffness = 10.0
    run_timer(QUIET)
    assert speed_estimate.speed_estimate().known
    assert "3 of 8 frames solved, 5 stale; about 3 s" in draw(LAPPET_PT_solve)[0], "0.6 s for each of 5 frames"


def test_a_failure_is_a_sentence_and_a_button_that_goes_there_and_undo_keeps_it(
    patch: bpy.types.Scene, script: Script
) -> None:
    script.failing[6] = "The hook tears the skin."
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.lappet.solve()
    run_timer(QUIET)
    words, operators = draw(LAPPET_PT_solve)
    assert "lappet.failure_show" in operators
    assert "The hook tears the skin." in words
    find_event(patch, "hook_1").stiffness = 10.0
    bpy.ops.ed.undo_push(message="softer")
    run_timer(QUIET)
    assert "lappet.failure_show" not in draw(LAPPET_PT_solve)[1]
    bpy.ops.ed.undo()
    assert "The hook tears the skin." in draw(LAPPET_PT_solve)[0]


def test_problems_are_shown_with_what_selects_and_what_mends_them(patch: bpy.types.Scene, script: Script) -> None:
    script.refusal = (
        Problem(ProblemCode.EVENT_OFF_TISSUE, "/Procedure/Timeline/hook_1", "", "It is off the skin.", "Move it."),
    )
    run_timer(QUIET)
    words, operators = draw(LAPPET_PT_solve)
    assert "It is off the skin. Move it." in words
    assert "lappet.problem_show" in operators


def test_an_installation_without_solver_is_named_by_the_panel_and_by_the_button(
    patch: bpy.types.Scene, script: Script, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> str:
        raise RefusedError([Problem(ProblemCode.DAEMON_MISSING, "", "", "There is no lappet-solverd.", "")])

    monkeypatch.setattr(reconcile, "identity", missing)
    run_timer(QUIET)
    assert "There is no lappet-solverd" in draw(LAPPET_PT_solve)[0]
    with pytest.raises(RuntimeError, match="There is no lappet-solverd"):
        bpy.ops.lappet.solve(wait=True)
    assert script.asked == []


def test_the_settings_name_the_folder_and_every_setting(patch: bpy.types.Scene, script: Script) -> None:
    words, operators = draw(LAPPET_PT_solve_settings)
    assert "store" in words.replace(" ", "")
    assert operators == ["lappet.reload_frames", "lappet.clear_frames"]


FAR = Problem(
    ProblemCode.HOOK_TARGET_FAR,
    "/Procedure/Timeline/hook_1",
    "996",
    "The target is far.",
    "Move it nearer.",
    "warning",
    Place.at((1.0, 2.0, 1000.0)),
)
DOUBTED = Problem(
    ProblemCode.ERROR_LARGE,
    "Frame 6",
    "9",
    "Not to be trusted.",
    "Use a smaller spacing.",
    "warning",
    Place.at((3, 4, 5)),
)
RESTED = Problem(ProblemCode.FRAMES_FROM_REST, "Frame 5", "1", "Solved from rest.", "Make smaller steps.", "note")


def test_what_is_suspicious_is_shown_with_its_place_and_stops_no_solve(patch: bpy.types.Scene, script: Script) -> None:
    script.suspicious = (FAR,)
    run_timer(QUIET)
    words, operators = draw(LAPPET_PT_solve)
    assert "The target is far. Move it nearer." in words
    assert operators.count("lappet.problem_show") == 1
    assert frames.problems_of(patch) == (FAR,)
    solve(patch)
    assert "8 of 8 frames solved" in draw(LAPPET_PT_solve)[0]
    bpy.ops.lappet.problem_show(index=0)
    assert patch.lappet.events[patch.lappet.active_event].name == "hook_1"
    assert tuple(to_mm(patch, patch.cursor.location)) == pytest.approx((1.0, 2.0, 1000.0), rel=1e-6)


def test_a_frame_that_is_not_to_be_trusted_says_so_and_what_was_done_otherwise_is_told(
    patch: bpy.types.Scene, script: Script
) -> None:
    good = FrameErrorEstimate(0.125, 0.1, 0.0, 0.0, 0.125, 0.1)
    script.assessment = Assessment((RESTED, DOUBTED), (good,) * 5 + (replace(good, greatest=9.0, is_trusted=False),))
    run_timer(QUIET)
    assert "Estimated error" not in draw(LAPPET_PT_solve)[0]
    bpy.ops.lappet.solve()
    run_timer(QUIET)
    assert frames.problems_of(patch) == (DOUBTED,)
    assert frames.notes_of(patch) == (RESTED,)
    words, _ = draw(LAPPET_PT_solve)
    assert "Not to be trusted." in words
    assert "Solved from rest." in words
    patch.frame_set(5)
    assert "Estimated error of this frame: 0.12 mm at most" in draw(LAPPET_PT_solve)[0]
    patch.frame_set(6)
    assert "This frame is not to be trusted: its estimated error is 9 mm" in draw(LAPPET_PT_solve)[0]
    patch.frame_set(8)
    assert "stimated error" not in draw(LAPPET_PT_solve)[0]
    assert "not estimated" not in draw(LAPPET_PT_solve)[0], "the estimate was tried"
    controller.manifests.assessments.clear()
    assert "The error of this frame is not estimated; Solve does it" in draw(LAPPET_PT_solve)[0]
    patch.lappet.solving.error_estimate = False
    assert "not estimated" not in draw(LAPPET_PT_solve)[0], "nobody wants it"
    patch.lappet.solving.error_estimate = True
    controller.manifests.assessments[controller.controller_of(patch).key] = script.assessment
    bpy.ops.lappet.problem_show(index=0)
    assert tuple(to_mm(patch, patch.cursor.location)) == pytest.approx((3.0, 4.0, 5.0))
    known = controller.controller_of(patch)
    key = assessment_key([frame.key for frame in known.manifest.frames], True, known.procedure)
    find_event(patch, "hook_1").stiffness = 10.0
    run_timer(QUIET)
    assert frames.problems_of(patch) == (), "they were of the frames before the change"
    known.store.put(key, script.assessment)
    controller.manifests.assessments.clear()
    find_event(patch, "hook_1").stiffness = 100.0
    run_timer(QUIET)
    assert frames.problems_of(patch) == (DOUBTED,), "found in the store, as after the file is opened again"


def test_a_suture_that_may_cut_through_is_shown_and_its_event_is_found(patch: bpy.types.Scene, script: Script) -> None:
    prim = f"{TIMELINE}/suture_1"
    place = Place.at((1.0, 2.0, 3.0))
    torn = problem(ProblemCode.SUTURE_PULLS_THROUGH, prim, "7000", place=place, time=8.0, limit=6000.0)
    script.assessment = Assessment((torn,))
    run_timer(QUIET)
    bpy.ops.lappet.solve()
    run_timer(QUIET)
    assert frames.problems_of(patch) == (torn,)
    words, operators = draw(LAPPET_PT_solve)
    assert torn.message in words
    assert operators.count("lappet.problem_show") == 1
    bpy.ops.lappet.problem_show(index=0)
    assert tuple(to_mm(patch, patch.cursor.location)) == pytest.approx((1.0, 2.0, 3.0))


def test_a_suture_and_a_hook_say_what_they_pull_with_in_the_frame_that_is_shown(
    patch: bpy.types.Scene, script: Script
) -> None:
    ends = Pull("suture_1", 351.0, None, resolved=False), Pull("suture_1", 238.6, 41.3)
    script.assessment = Assessment(pulls=((), (), (), (), (ends[0], Pull("hook_1", 12.34, None)), (ends[1],)))
    add_event(patch, "SUTURE", start=5, duration=1, points=[(2, -1, 2.0), (2, 1, 2.0)])
    run_timer(QUIET)
    bpy.ops.lappet.solve()
    run_timer(QUIET)

    def said(name: str, time: int) -> list[str]:
        patch.frame_set(time)
        drawn: list[tuple[str, str]] = []
        draw_fields(Layout(drawn), patch, find_event(patch, name))
        return [text for kind, text in drawn if kind == "label"]

    assert said("suture_1", 4) == []
    assert said("suture_1", 5) == ["The lattice does not part its ends: no force"]
    assert said("suture_1", 6) == ["Pulls with 240 ± 40 mN in this frame"]
    assert said("hook_1", 5) == ["Pulls with 12.3 mN in this frame"]
    assert said("hook_1", 6) == []
    find_event(patch, "hook_1").stiffness = 10.0
    run_timer(QUIET)
    assert said("suture_1", 6) == [], "it was of the frames before the change"
