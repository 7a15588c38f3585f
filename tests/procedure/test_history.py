"""Commands on a procedure: undo and redo are exact, whatever was done."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Bone, Hook, Incision, Landmark, Material, Procedure, Region, Retractor, Suture
from lappet.procedure.history import (
    AddEvent,
    Command,
    Edit,
    History,
    MoveEvent,
    RemoveBone,
    RemoveEvent,
    RemoveMaterial,
    RemoveRegion,
    ReplaceEvent,
    Retime,
    SetBone,
    SetMaterial,
    SetRegion,
    SetTimeline,
    SetTissue,
    Together,
)
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
commands: st.SearchStrategy[Command] = st.one_of(
    st.builds(AddEvent, some_events, st.none() | st.integers(-4, 4)),
    st.builds(RemoveEvent, names),
    st.builds(ReplaceEvent, names, some_events),
    st.builds(MoveEvent, names, st.integers(-4, 4)),
    st.builds(Retime, names, shifts),
    st.builds(SetMaterial, st.builds(Material, st.sampled_from(["skin", "fat"]), youngs_modulus=st.just(20.0))),
    st.builds(RemoveMaterial, st.sampled_from(["skin", "fat"])),
    st.builds(SetRegion, st.builds(Region, st.sampled_from(["bed", "fixed", "lip"]), st.sampled_from(["skin", "fat"]))),
    st.builds(RemoveRegion, st.sampled_from(["bed", "fixed"])),
    st.builds(SetTissue, st.sampled_from([PATCH, replace(PATCH, spacing=0.5)])),
    st.builds(SetBone, bones),
    st.builds(RemoveBone, names),
    st.builds(SetTimeline, st.none() | shifts, st.none() | shifts),
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(commands | st.sampled_from(["undo", "redo"]), max_size=25))
def test_undo_and_redo_return_every_state_exactly(steps: list[Command | str]) -> None:
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


def test_each_command_does_what_its_name_says() -> None:
    history = History(START)
    stitch = Suture("stitch", ((0, -1, 2), (0, 1, 2)), 6.0)
    assert history.do(AddEvent(stitch, 1)).events == (CUT, stitch, HOOK, TIP)
    assert history.do(MoveEvent("cut", 3)).events == (stitch, HOOK, TIP, CUT)
    assert history.do(RemoveEvent("hook")).events == (stitch, TIP, CUT)
    renamed = replace(stitch, name="thread")
    assert history.do(ReplaceEvent("stitch", renamed)).events == (renamed, TIP, CUT)
    assert history.undo_label == "Edit stitch"
    assert history.do(SetMaterial(Material("fat"))).materials == (Material(), Material("fat"))
    assert history.do(SetMaterial(Material(youngs_modulus=9.0))).materials == (
        Material(youngs_modulus=9.0),
        Material("fat"),
    )
    assert history.do(RemoveMaterial("fat")).materials == (Material(youngs_modulus=9.0),)
    assert history.do(SetTimeline(end_time=40.0, fps=25.0)).end_time == 40.0
    assert history.procedure.fps == 25.0
    both = Together((RemoveEvent("tip"), RemoveEvent("cut")), "Remove two")
    assert history.do(both).events == (renamed,)
    assert history.undo().events == (renamed, TIP, CUT)
    assert history.do(Edit(lambda old: replace(old, events=()), "Clear")).events == ()


def test_a_region_is_set_replaced_and_removed_and_keeps_its_material() -> None:
    history = History(START)
    history.do(SetMaterial(Material("fat")))
    assert history.do(SetRegion(Region("bed", "fat", 1.0))).tissue.regions == (Region("bed", "fat", 1.0),)
    assert history.do(SetRegion(Region("fixed", "skin"))).tissue.regions[0].faces == "fixed"  # the subsets' order
    assert history.do(SetRegion(Region("bed", "fat", 2.0))).tissue.regions[1].depth_from == 2.0
    with refuses(ProblemCode.MATERIAL_IN_USE, "/Procedure/Materials/fat"):
        history.do(RemoveMaterial("fat"))
    with refuses(ProblemCode.REGION_NO_SUBSET, "/Procedure/Tissue/lip"):
        history.do(SetRegion(Region("lip", "fat")))
    assert history.do(RemoveRegion("bed")).tissue.regions == (Region("fixed", "skin"),)
    with refuses(ProblemCode.REGION_UNKNOWN, "/Procedure/Tissue/bed"):
        history.do(RemoveRegion("bed"))
    assert history.do(RemoveMaterial("fat")).materials == (Material(),)


def test_retiming_moves_every_sample() -> None:
    pull = Retractor("pull", "fixed", ((3.0, STILL), (5.0, STILL)), 3.0, 6.0)
    history = History(START.with_events(pull))
    history.do(Retime("hook", 2.5))
    after = history.do(Retime("pull", -1.0))
    assert after.event("hook") == replace(
        HOOK, start=5.5, release=8.5, targets=((5.5, HOOK.targets[0][1]), (7.5, HOOK.targets[1][1]))
    )
    assert after.event("pull") == replace(pull, start=2.0, release=5.0, motion=((2.0, STILL), (4.0, STILL)))


@pytest.mark.parametrize(
    ("command", "code", "prim"),
    [
        (AddEvent(CUT), ProblemCode.NAME_TAKEN, "Timeline/cut"),
        (RemoveEvent("nerve"), ProblemCode.NAME_UNKNOWN, "Timeline/nerve"),
        (ReplaceEvent("cut", replace(CUT, name="tip")), ProblemCode.NAME_TAKEN, "Timeline/tip"),
        (Retime("tip", 1.0), ProblemCode.LANDMARK_RETIMED, "Timeline/tip"),
        (RemoveMaterial("skin"), ProblemCode.MATERIAL_IN_USE, "Materials/skin"),
        (SetTimeline(end_time=0.0), ProblemCode.TIMELINE_REVERSED, ""),
        (Together((RemoveEvent("cut"), RemoveEvent("cut")), "Twice"), ProblemCode.NAME_UNKNOWN, "Timeline/cut"),
    ],
)
def test_an_edit_that_makes_no_sense_is_refused_and_changes_nothing(
    command: Command, code: ProblemCode, prim: str
) -> None:
    history = History(START)
    with refuses(code, f"/Procedure/{prim}".rstrip("/")):
        history.do(command)
    assert history.procedure is START
    assert history.undo_label is None
