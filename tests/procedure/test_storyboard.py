"""The storyboard: what `repr(procedure)` and `lappet inspect` print."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    Bone,
    Hook,
    Incision,
    Landmark,
    Material,
    Pressure,
    Procedure,
    Region,
    Retractor,
    Section,
    Suture,
    Traction,
    Undermine,
)
from lappet.procedure.event_text import describe
from lappet.procedure.scene_profile import measured_costs, profile_lines, scene_profile, scene_reasons
from lappet.procedure.storyboard import inspection
from lappet.tissue.patch import flat_patch
from refusals import refuses

STILL = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
TURNED = (0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3.0, 0.0, 4.0, 1.0)
BOARD = Procedure(flat_patch((60, 40, 4), 4.0), (Material(),), end_time=20.0).with_events(
    Suture("stitch", ((0, -3, 4), (0, 1, 4)), 10.0, 2.0),
    Landmark("tip", ((0, 1, 4),), "tip of the flap"),
    Hook("hook", (0, 1, 4), ((5.0, (0, 1, 4)), (9.0, (0, 4, 8))), 5.0, 10.0, 250.0),
    Retractor("pull", "fixed", ((4.0, STILL), (9.0, TURNED)), 4.0, 9.0),
    Incision("cut", 2.0, ((-3, 0, 4), (0, 4, 4), (3, 0, 4)), 1.5),
)


def test_a_thread_says_how_stiff_it_is_and_how_it_is_drawn() -> None:
    ends = ((0, -3, 4), (0, 1, 4))
    own = Suture("own", ends, 10.0, stiffness=250.0, mode="thread", length=0.5)
    assert describe(own).endswith("4 mm apart at rest, 250 mN/mm, drawn to 0.5 mm")
    nylon = Suture("nylon", ends, 10.0, mode="thread", thread="nylon 5-0", tension=300.0)
    assert re.search(r"nylon 5-0, 767\d mN/mm, drawn to 0 mm with 300 mN at most$", describe(nylon))


def test_loads_and_sections_say_where_they_act_and_how_much() -> None:
    push = Traction("push", "flap", ((1.0, (0, 0, 0)), (3.0, (0, -2, 0)), (5.0, (0, -1, 0))), 1.0, 5.0)
    assert describe(push) == "(0, -2, 0) kPa at most on 'flap'"
    assert describe(Pressure("air", "flap", ((1.0, 0.5), (2.0, -3.0)), 1.0, 5.0)) == "-3 kPa at most on 'flap'"
    assert describe(Section("neck", (1, 2, 3), (0, 1, 0), "neck")) == "'neck' through (1, 2, 3) across (0, 1, 0)"


def test_the_storyboard_tells_the_events_in_time_order_with_their_units() -> None:
    lines = repr(BOARD).splitlines()
    assert lines[0] == "Procedure, time codes 1 to 20 at 24 per second, 20 frames"
    assert [re.split(r"  +", line.strip()) for line in lines[-5:]] == [
        ["2", "incision", "cut", "1.5 mm deep, 10 mm through 3 points, kerf 0.05 mm"],
        ["4 – 9", "retractor", "pull", "moves 'fixed' by 5 mm and turns it by 90° over 2 samples"],
        ["5 – 10", "hook", "hook", "(0, 1, 4) drawn 5 mm to (0, 4, 8), 250 mN/mm"],
        ["10 – 12", "suture", "stitch", "(0, -3, 4) to (0, 1, 4), 4 mm apart at rest, closed exactly"],
        ["always", "landmark", "tip", "'tip of the flap' at (0, 1, 4)"],
    ]
    assert "60 × 40 × 4 mm" in repr(BOARD)
    assert "E 50 kPa, ν 0.45" in repr(BOARD)


def test_the_profile_names_what_the_scene_needs_and_nothing_else() -> None:
    needed = {name for name, present in scene_profile(BOARD).items() if present}
    assert needed == {"fixed", "bed", "incisions", "hooks", "retractors", "sutures", "landmarks", "gravity"}
    weightless = replace(BOARD, tissue=replace(BOARD.tissue, gravity=0.0))
    assert needed - {name for name, present in scene_profile(weightless).items() if present} == {"gravity"}
    patch = flat_patch((10, 10, 2), 5.0)
    bone = Bone("skull", patch.points, patch.face_vertex_counts, patch.face_vertex_indices)
    skin = Material(fiber_k1=3.0, prestretch=(1.2, 1.0))
    rich = replace(
        BOARD,
        bones=(bone,),
        materials=(skin,),
    )
    rich = rich.with_events(Undermine("free", 3.0, ((0, 0, 4), (3, 0, 4), (3, 3, 4))))
    more = {name for name, present in scene_profile(rich).items() if present}
    assert more - needed == {"contact", "fibers", "prestretch", "undermining"}
    layered = _layered()
    assert {name for name, present in scene_profile(layered).items() if present} - needed == {"materials", "muscle"}
    unused = replace(layered, tissue=replace(layered.tissue, regions=()))
    assert scene_profile(unused) == scene_profile(BOARD)


def test_the_profile_says_which_prims_ask_for_a_feature() -> None:
    reasons = scene_reasons(_layered())
    assert reasons["muscle"] == "/Procedure/Materials/lip"
    assert reasons["materials"] == "/Procedure/Materials/skin, /Procedure/Materials/lip"
    assert reasons["sutures"] == "/Procedure/Timeline/stitch"
    assert reasons["fixed"] == f"{len(BOARD.tissue.subsets['fixed'])} faces in /Procedure/Tissue/fixed"
    assert reasons["contact"] == ""
    many = BOARD.with_events(*(Landmark(f"m{k}", ((0, 1, 4),), "") for k in range(5)))
    assert (
        scene_reasons(many)["landmarks"]
        == ", ".join(f"/Procedure/Timeline/{name}" for name in ("tip", "m0", "m1")) + " and 3 more"
    )


def test_the_profile_has_a_line_for_each_feature_that_is_on_and_one_for_all_that_are_off() -> None:
    lines = profile_lines(BOARD, {"hooks": "nothing to speak of"})
    needs = [line for line in lines if line.startswith("needs")]
    assert len(needs) == sum(scene_profile(BOARD).values())
    assert "needs    hooks: /Procedure/Timeline/hook; nothing to speak of" in needs
    (without,) = [line for line in lines if line.startswith("without")]
    off = without.removeprefix("without  ").split(", ")
    assert set(off) == {name for name, on in scene_profile(BOARD).items() if not on}
    assert "self_contact" in off
    kept_apart = replace(BOARD, tissue=replace(BOARD.tissue, self_contact=True))
    assert "needs    self_contact: /Procedure/Tissue" in profile_lines(kept_apart)


def test_costs_are_those_of_the_report_of_economy(tmp_path: Path) -> None:
    def row(feature: str, present: bool, instructions: int | None, seconds: float) -> dict[str, object]:
        return {"feature": feature, "present": present, "instructions": instructions, "seconds": seconds, "bytes": 1}

    rows = [row("fibers", False, 100, 1.0), row("fibers", True, 125, 9.0)]
    rows += [
        row("heterogeneity", False, None, 1.0),
        row("heterogeneity", True, None, 1.5),
        row("followers", False, 1, 1),
    ]
    file = tmp_path / "economy.json"
    file.write_text(json.dumps({"rows": rows}))
    costs = measured_costs(file)
    assert set(costs) == {"fibers", "materials"}
    assert costs["fibers"].startswith("+25 % instructions")
    assert costs["materials"].startswith("+50 % seconds")
    file.write_text("[]")
    with refuses(ProblemCode.ECONOMY_FILE, str(file)):
        measured_costs(file)


def test_regions_and_muscles_are_told() -> None:
    text = repr(_layered())
    assert "  region     deeper than 2 mm below cheek is of lip" in text.splitlines()
    assert "muscle of 300 kPa along (0, 1, 0), active up to 0.75" in text
    ranges = {Region("a", "fat"): "all below a", Region("a", "fat", 0.5, 2.0): "0.5 to 2 mm below a is of fat"}
    for region, said in ranges.items():
        tissue = replace(BOARD.tissue, subsets={"a": [0]}, regions=(region,))
        assert said in repr(replace(BOARD, tissue=tissue))


def _layered() -> Procedure:
    muscle = Material(
        "lip", fiber_direction=(0, 1, 0), muscle_stress=300.0, muscle_activation=((1.0, 0.0), (4.0, 0.75))
    )
    tissue = replace(
        BOARD.tissue, subsets={**BOARD.tissue.subsets, "cheek": [0, 1]}, regions=(Region("cheek", "lip", 2.0),)
    )
    return replace(BOARD, materials=(Material(), muscle), tissue=tissue)


def test_the_inspection_holds_what_the_others_know() -> None:
    text = inspection(BOARD, ["epoch 0: frames 1 to 1"], ["epoch 0: 9600 cells"], ["It was in cm."])
    parts = text.split("\n\n")
    assert parts[0] == repr(BOARD)
    assert [part.splitlines()[0] for part in parts[1:]] == ["Epochs", "Scene profile", "Lattice", "Notes"]
    assert "  epoch 0: 9600 cells" in parts[3].splitlines()


def test_broken_procedures_have_a_storyboard_too() -> None:
    odd = replace(BOARD, start_time=float("nan"), tissue=replace(BOARD.tissue, points=BOARD.tissue.points[:0]))
    odd = odd.with_events(Hook("empty", (float("nan"), 0, 0), (), float("inf"), 0.0), Retractor("r", "", (), 0.0, 0.0))
    assert "0 frames" in repr(odd)
    assert "empty" in repr(odd)


def test_a_landmark_of_many_points_says_how_many_and_where_they_begin() -> None:
    few = Landmark("lips", ((1.0, 0.0, 0.0), (2.0, 0.0, 0.0)), "lips")
    assert describe(few) == "'lips' at (1, 0, 0) and (2, 0, 0)"
    many = Landmark("edge", tuple((float(k), 0.0, 0.0) for k in range(18)), "edge")
    assert describe(many) == "'edge' at 18 points from (0, 0, 0)"
