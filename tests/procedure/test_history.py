"""Edits of a procedure: undo and redo are exact, whatever was done."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    DEFAULT_SKIN,
    Bone,
    Hook,
    Incision,
    Landmark,
    Material,
    Procedure,
    Region,
    Retractor,
    Suture,
)
from lappet.procedure.edits import (
    add_event,
    move_event,
    remove_bone,
    remove_event,
    remove_material,
    remove_region,
    replace_event,
    retime_event,
    set_bone,
    set_material,
    set_region,
    set_timeline,
    set_tissue,
    together,
)
from lappet.procedure.history import Edit, History
from lappet.tissue.patch import flat_patch
from refusals import refuses

STILL = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
PATCH = flat_patch((10, 10, 2), 5.0)
CUT = Incision("cut", 2.0, ((-1, 0, 2), (1, 0, 2)))
HOOK = Hook("hook", (0, 1, 2), ((3.0, (0, 1, 2)), (5.0, (0, 2, 4))), 3.0, 6.0)
TIP = Landmark("tip", ((0, 1, 2),), "tip")
START = Procedure(PATCH, end_time=20.0).with_events(CUT, HOOK, TIP)

names = st.sampled_from(["cut", "hook", "tip", "new", "other"])
shifts = st.integers(-5, 5).map(float)
some_events = st.one_of(
    st.builds(Incision, names, shifts, st.just(CUT.points)),
    st.builds(Hook, names, st.just(HOOK.anchor), st.just(HOOK.targets), shifts, shifts),
    st.builds(Landmark, names, st.just(TIP.points), names),
)
bones = names.map(lambda name: Bone(name, PATCH.points, PATCH.face_vertex_counts, PATCH.face_vertex_indices))
edits: st.SearchStrategy[Edit] = st.one_of(
    st.builds(add_event, some_events, st.none() | st.integers(-4, 4)),
    st.builds(remove_event, names),
    st.builds(replace_event, names, some_events),
    st.builds(move_event, names, st.integers(-4, 4)),
    st.builds(retime_event, names, shifts),
    st.builds(set_material, st.builds(Material, st.sampled_from(["skin", "fat"]), youngs_modulus=st.just(20.0))),
    st.builds(remove_material, st.sampled_from(["skin", "fat"])),
    st.builds(
        set_region, st.builds(Region, st.sampled_from(["bed", "fixed", "lip"]), st.sampled_from(["skin", "fat"]))
    ),
    st.builds(remove_region, st.sampled_from(["bed", "fixed"])),
    st.builds(set_tissue, st.sampled_from([PATCH, replace(PATCH, spacing=0.5)])),
    st.builds(set_bone, bones),
    st.builds(remove_bone, names),
    st.builds(set_timeline, st.none() | shifts, st.none() | shifts),
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(edits | st.sampled_from(["undo", "redo"]), max_size=25))
def test_undo_and_redo_return_every_state_exactly(steps: list[Edit | str]) -> None:
    history = History(START)
    past, future = [START], []  # an independent model: two stacks
    for step in steps:
        if step == "undo":
            if len(past) == 1:
                with pytest.raises(IndexError, match="nothing to undo"):
                    history.undo()
            else:
                future.append(past.pop())
                assert history.undo() == past[-1]
        elif step == "redo":
            if not future:
                with pytest.raises(IndexError, match="nothing to redo"):
                    history.redo()
            else:
                past.append(future.pop())
                assert history.redo() == past[-1]
        else:
            assert not isinstance(step, str)
            with contextlib.suppress(RefusedError):
                past.append(history.do(step))
                future.clear()
        assert history.procedure == past[-1]
        assert (history.undo_label is None) == (len(past) == 1)
        assert (history.redo_label is None) == (not future)
    while history.undo_label:
        past.pop()
        assert history.undo() == past[-1]
    assert history.procedure is START


def test_each_edit_does_what_its_name_says() -> None:
    history = History(START)
    stitch = Suture("stitch", ((0, -1, 2), (0, 1, 2)), 6.0)
    assert history.do(add_event(stitch, 1)).events == (CUT, stitch, HOOK, TIP)
    assert history.do(move_event("cut", 3)).events == (stitch, HOOK, TIP, CUT)
    assert history.do(remove_event("hook")).events == (stitch, TIP, CUT)
    renamed = replace(stitch, name="thread")
    assert history.do(replace_event("stitch", renamed)).events == (renamed, TIP, CUT)
    assert history.undo_label == "Edit stitch"
    assert history.do(set_material(Material("fat"))).materials == (DEFAULT_SKIN, Material("fat"))
    assert history.do(set_material(Material(youngs_modulus=9.0))).materials == (
        Material(youngs_modulus=9.0),
        Material("fat"),
    )
    assert history.do(remove_material("fat")).materials == (Material(youngs_modulus=9.0),)
    assert history.do(set_timeline(end_time=40.0, fps=25.0)).end_time == 40.0
    assert history.procedure.fps == 25.0
    both = together((remove_event("tip"), remove_event("cut")), "Remove two")
    assert history.do(both).events == (renamed,)
    assert history.undo().events == (renamed, TIP, CUT)
    assert history.do(Edit("Clear", lambda old: replace(old, events=()))).events == ()


def test_a_region_is_set_replaced_and_removed_and_keeps_its_material() -> None:
    history = History(START)
    history.do(set_material(Material("fat")))
    assert history.do(set_region(Region("bed", "fat", 1.0))).tissue.regions == (Region("bed", "fat", 1.0),)
    assert history.do(set_region(Region("fixed", "skin"))).tissue.regions[0].faces == "fixed"  # the subsets' order
    assert history.do(set_region(Region("bed", "fat", 2.0))).tissue.regions[1].depth_from == 2.0
    with refuses(ProblemCode.MATERIAL_IN_USE, "/Procedure/Materials/fat"):
        history.do(remove_material("fat"))
    with refuses(ProblemCode.REGION_NO_SUBSET, "/Procedure/Tissue/lip"):
        history.do(set_region(Region("lip", "fat")))
    assert history.do(remove_region("bed")).tissue.regions == (Region("fixed", "skin"),)
    with refuses(ProblemCode.REGION_UNKNOWN, "/Procedure/Tissue/bed"):
        history.do(remove_region("bed"))
    assert history.do(remove_material("fat")).materials == (DEFAULT_SKIN,)


def test_retiming_moves_every_sample() -> None:
    pull = Retractor("pull", "fixed", ((3.0, STILL), (5.0, STILL)), 3.0, 6.0)
    history = History(START.with_events(pull))
    history.do(retime_event("hook", 2.5))
    after = history.do(retime_event("pull", -1.0))
    assert after.event("hook") == replace(
        HOOK, start=5.5, release=8.5, targets=((5.5, HOOK.targets[0][1]), (7.5, HOOK.targets[1][1]))
    )
    assert after.event("pull") == replace(pull, start=2.0, release=5.0, motion=((2.0, STILL), (4.0, STILL)))


@pytest.mark.parametrize(
    ("edit", "code", "prim"),
    [
        (add_event(CUT), ProblemCode.NAME_TAKEN, "Timeline/cut"),
        (remove_event("nerve"), ProblemCode.NAME_UNKNOWN, "Timeline/nerve"),
        (replace_event("cut", replace(CUT, name="tip")), ProblemCode.NAME_TAKEN, "Timeline/tip"),
        (retime_event("tip", 1.0), ProblemCode.LANDMARK_RETIMED, "Timeline/tip"),
        (remove_material("skin"), ProblemCode.MATERIAL_IN_USE, "Materials/skin"),
        (set_timeline(end_time=0.0), ProblemCode.TIMELINE_REVERSED, ""),
        (together((remove_event("cut"), remove_event("cut")), "Twice"), ProblemCode.NAME_UNKNOWN, "Timeline/cut"),
    ],
)
def test_an_edit_that_makes_no_sense_is_refused_and_changes_nothing(edit: Edit, code: ProblemCode, prim: str) -> None:
    history = History(START)
    with refuses(code, f"/Procedure/{prim}".rstrip("/")):
        history.do(edit)
    assert history.procedure is START
    assert history.undo_label is None
