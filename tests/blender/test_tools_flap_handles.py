"""The handles of laid flaps in the viewport: where they are, what dragging one does, and the panel's values."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from event_patch import patch_scene
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Excision
from lappet_blender.events.add_events import add_landmark
from lappet_blender.files.export_usd import write_scene
from lappet_blender.files.import_usd import look_into, read_into
from lappet_blender.model.laid_flaps import active_flap, events_of
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.tools import flap_gizmos, skin_modal
from lappet_blender.tools.flap_edit_tool import OPERATORS, _FlapEdit
from lappet_blender.tools.plan_lines import LineSet, add_event_lines
from lappet_blender.tools.preview import clear_preview, preview_of
from lappet_blender.tools.shown_surface import shown_surface
from refusals import refusal_code

TOP = 4.0
ops = bpy.ops.lappet


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A scene in mm with a patch of 140 x 120 x 4 mm."""
    patch_scene(scene, (140.0, 120.0, TOP), 40, resolution=10.0)
    return scene


@pytest.fixture
def laid(patch: bpy.types.Scene) -> bpy.types.Scene:
    """A Limberg flap of side 10 at (-20, 10), laid by an operator."""
    assert ops.flap_limberg(side=10.0, at=(-20.0, 10.0, TOP), lines="X", time=1) == {"FINISHED"}
    return patch


def flap_of(scene: bpy.types.Scene) -> Any:
    procedure = read_scene(scene).procedure
    assert procedure is not None
    return procedure.flaps[0]


def seed_of(scene: bpy.types.Scene) -> tuple[float, ...]:
    procedure = read_scene(scene).procedure
    assert procedure is not None
    return next(event.seeds[0] for event in procedure.events if isinstance(event, Excision))


def test_a_flap_remembers_its_events_and_comes_back_from_a_file(laid: bpy.types.Scene, tmp_path: Any) -> None:
    before = flap_of(laid)
    assert (before.design, dict(before.measures), before.at) == ("limberg", {"side": 10.0}, (-20.0, 10.0, TOP))
    assert set(before.events) == {event.name for event in laid.lappet.events}
    write_scene(laid, tmp_path / "flap.usda")
    read_into(laid, look_into(tmp_path / "flap.usda"))
    assert flap_of(laid) == before


def test_the_panel_of_the_last_operation_gives_a_flap_other_measures_and_a_new_place(laid: bpy.types.Scene) -> None:
    names = events_of(laid, "limberg")
    assert ops.flap_edit_limberg(flap="limberg", side=14.0, at=(0.0, 0.0, TOP)) == {"FINISHED"}
    assert dict(flap_of(laid).measures) == {"side": 14.0}
    assert seed_of(laid) == pytest.approx((0.0, 0.0, TOP), abs=1e-3)
    assert sorted(events_of(laid, "limberg")) == sorted(names)
    assert ops.flap_edit_limberg(flap="limberg", turned=np.pi / 2) == {"FINISHED"}
    assert flap_of(laid).direction == pytest.approx((0.0, 1.0, 0.0), abs=1e-5)
    assert ops.flap_edit_limberg(flap="limberg", mirrored=True) == {"FINISHED"}
    assert flap_of(laid).mirrored
    assert flap_of(laid).direction == pytest.approx((0.0, 1.0, 0.0), abs=1e-5)


def test_an_edit_is_one_step_of_undo(laid: bpy.types.Scene) -> None:
    bpy.ops.ed.undo_push(message="laid")
    assert ops.flap_edit_limberg("EXEC_DEFAULT", True, flap="limberg", side=15.0) == {"FINISHED"}
    assert dict(flap_of(bpy.context.scene).measures) == {"side": 15.0}
    bpy.ops.ed.undo()
    assert dict(flap_of(bpy.context.scene).measures) == {"side": 10.0}
    assert len(bpy.context.scene.lappet.events) == len(events_of(bpy.context.scene, "limberg"))


def test_an_edit_that_does_not_fit_changes_nothing(laid: bpy.types.Scene) -> None:
    before = read_scene(laid).procedure
    code = refusal_code(lambda: ops.flap_edit_limberg(flap="limberg", at=(55.0, 0.0, TOP), side=30.0))
    assert code == ProblemCode.DESIGN_OFF_SKIN
    assert read_scene(laid).procedure == before
    assert refusal_code(lambda: ops.flap_edit_limberg(flap="bilobed")) == ProblemCode.FLAP_UNKNOWN
    assert refusal_code(lambda: ops.flap_edit_bilobed(flap="limberg")) == ProblemCode.DESIGN_UNKNOWN


def test_what_was_changed_by_hand_is_named_when_the_flap_is_laid_anew(
    laid: bpy.types.Scene, capfd: pytest.CaptureFixture
) -> None:
    laid.lappet.events["limbs"].kerf = 0.3
    assert ops.flap_edit_limberg(flap="limberg", side=11.0) == {"FINISHED"}
    assert "by hand to limbs" in capfd.readouterr().out


def test_a_flap_is_removed_with_its_events_and_nothing_else(laid: bpy.types.Scene) -> None:
    add_landmark(laid, [(5, 5, TOP)], label="mole")
    assert ops.flap_remove(flap="limberg") == {"FINISHED"}
    assert [event.label for event in laid.lappet.events] == ["mole"]
    assert len(laid.lappet.flaps) == 0


def test_the_handles_are_shown_while_an_event_of_a_flap_is_active(laid: bpy.types.Scene) -> None:
    assert active_flap(laid) == "limberg"
    context = SimpleNamespace(scene=laid, mode="OBJECT", workspace=None)
    assert flap_gizmos.shows_handles(context)
    places = flap_gizmos.shown_places(laid, None)
    assert [handle.name for handle, _ in places] == ["place", "turn", "side"]
    assert tuple(places[0][1]) == pytest.approx((-20.0, 10.0, TOP), abs=1e-3)
    assert flap_gizmos.handles_of_active(laid) is flap_gizmos.handles_of_active(laid)
    tool = SimpleNamespace(idname="lappet.cutting.incision")
    drawing = SimpleNamespace(tools=SimpleNamespace(from_space_view3d_mode=lambda *_, **__: tool))
    assert not flap_gizmos.shows_handles(SimpleNamespace(scene=laid, mode="OBJECT", workspace=drawing))
    add_landmark(laid, [(5, 5, TOP)], label="mole")
    assert not flap_gizmos.shows_handles(context)
    assert flap_gizmos.handles_of_active(laid) == ()


def test_each_design_has_an_operator_and_the_group_has_gizmos_enough() -> None:
    assert all(len(each.design.parameters) + 2 <= flap_gizmos.MOST + 1 for each in OPERATORS)
    assert bpy.types.GizmoGroup.bl_rna_get_subclass_py("LAPPET_GGT_flap") is flap_gizmos.LAPPET_GGT_flap


class Drag(_FlapEdit):
    """The operator that edits a Limberg flap, without Blender's operator around it."""

    design = next(each.design for each in OPERATORS if each.design.name == "limberg")

    def __init__(self, context: Any, handle: str) -> None:
        self.flap, self.handle, self._begun = "limberg", handle, False
        self._scene = context.scene.name
        self._take(context)

    def execute(self, context: Any) -> set[str]:
        return ops.flap_edit_limberg(
            flap=self.flap, at=self.at, direction=self.direction, lines=self.lines, side=self.side
        )


class FromAbove:
    """A view from straight above, 10 pixels a millimetre."""

    def __init__(self, x: float, y: float) -> None:
        self.mouse = (10.0 * x, 10.0 * y)

    def pick(self, _scene: bpy.types.Scene) -> Any:
        return SimpleNamespace(rest=(self.mouse[0] / 10.0, self.mouse[1] / 10.0, TOP))


def dragged(scene: bpy.types.Scene, handle: str, *way: tuple[float, float]) -> set[str] | None:
    """What a press at the first place, moves and a release at the last do."""
    context = SimpleNamespace(scene=scene)
    drag = Drag(context, handle)
    assert drag.pressed(context, FromAbove(*way[0])) is None
    for place in way[1:]:
        assert drag.moved(context, FromAbove(*place)) is None
    shown = preview_of(scene)
    assert len(way) == 1 or (shown is not None and len(shown.lines) == 2)
    clear_preview()
    return drag.released(context, FromAbove(*way[-1]))


def test_a_drag_of_a_handle_lays_the_flap_where_the_mouse_let_it_go(
    laid: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(skin_modal, "redraw", lambda: None)
    assert dragged(laid, "place", (-20.0, 10.0), (-10.0, 10.0), (0.0, 5.0)) == {"FINISHED"}
    assert flap_of(laid).at == pytest.approx((0.0, 5.0, TOP))
    assert dragged(laid, "turn", (20.0, 5.0), (0.0, -20.0)) == {"FINISHED"}
    assert flap_of(laid).direction == pytest.approx((0.0, -1.0, 0.0), abs=1e-5)
    corner = next(np.array(handle.point) for handle, _ in flap_gizmos.shown_places(laid, None) if handle.name == "side")
    middle = np.array([0.0, 5.0, TOP])
    there = (middle + 1.3 * (corner - middle))[:2]
    assert dragged(laid, "side", tuple(corner[:2]), tuple(there)) == {"FINISHED"}
    assert dict(flap_of(laid).measures)["side"] == pytest.approx(13.0, abs=0.03)
    assert flap_of(laid).direction == pytest.approx((0.0, -1.0, 0.0), abs=1e-5)


def test_a_click_on_a_handle_without_a_drag_changes_nothing(laid: bpy.types.Scene) -> None:
    before = read_scene(laid).procedure
    assert dragged(laid, "side", (-20.0, 10.0)) == {"CANCELLED"}
    assert read_scene(laid).procedure == before


def test_a_landmark_that_follows_an_edge_has_one_label_while_it_is_active_and_none_else(laid: bpy.types.Scene) -> None:
    """A design measures its edges at dozens of points: their labels would hide the plan and the handles."""
    surface = shown_surface(laid)
    assert surface is not None
    edge = laid.lappet.events["near_wound_edge"]
    assert len(edge.points) > 4
    for active, wanted in ((False, []), (True, ["near wound edge"])):
        lines = LineSet()
        add_event_lines(lines, surface, edge, 1.0, active)
        assert [text for _, text, _ in lines.labels] == wanted
    corner = LineSet()
    add_event_lines(corner, surface, laid.lappet.events["tip_flap_corner"], 1.0, False)
    assert [text for _, text, _ in corner.labels] == ["tip flap"]
