"""Variants of a procedure, targets that are sampled anew, and the panel."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import pytest

from event_patch import co, patch_scene
from lappet_blender.events.variant import copy_scene
from lappet_blender.model import target_samples
from lappet_blender.model.event_list import find_event
from lappet_blender.model.event_values import event_value
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.solving.controller import controller_of
from lappet_blender.solving.solve_timer import run_timer

TOP = 4.0
ops = bpy.ops.lappet


@pytest.fixture
def pulled(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A patch, cut and pulled by two hooks, one of which rides on the other's empty."""
    patch_scene(scene, (60.0, 40.0, TOP), 40)
    ops.incision_add(points=co([(-10, 0, TOP), (10, 0, TOP)]), time=3)
    ops.hook_add(anchor=(1, 1, TOP), target=(1, 8, 9), start=8, end=20)
    ops.hook_add(anchor=(-5, 1, TOP), target=(-5, 8, 9), start=8, end=20, arrive=0)
    scene.lappet.events["hook_2"].target.parent = scene.lappet.events["hook_1"].target
    bpy.context.view_layer.update()
    return scene


def test_a_variant_is_the_same_procedure_and_changing_it_leaves_the_original_alone(pulled: bpy.types.Scene) -> None:
    before = read_scene(pulled).procedure
    variant = copy_scene(pulled, "short flap")
    assert variant.name == "short flap"
    assert read_scene(variant).procedure == before
    assert variant.lappet.tissue.object == pulled.lappet.tissue.object
    own = {event.target.name for event in variant.lappet.events if event.target is not None}
    assert own.isdisjoint(event.target.name for event in pulled.lappet.events if event.target is not None)
    assert own <= set(variant.objects.keys())
    assert own.isdisjoint(pulled.objects.keys())
    assert variant.lappet.events["hook_2"].target.parent == variant.lappet.events["hook_1"].target

    variant.lappet.events["hook_1"].moment = 12.0
    variant.lappet.events["incision_1"].points[0].co = (-20, 0, TOP)
    with bpy.context.temp_override(scene=variant):
        ops.event_remove(event="hook_2")
    assert read_scene(pulled).procedure == before
    with bpy.context.temp_override(scene=variant):
        ops.event_remove(event="hook_1")
    assert read_scene(pulled).procedure == before


def test_a_scene_copied_by_blender_itself_copies_the_procedure(pulled: bpy.types.Scene) -> None:
    before = read_scene(pulled).procedure
    bpy.ops.scene.new(type="FULL_COPY")
    copied = bpy.context.scene
    assert copied != pulled
    assert read_scene(copied).procedure.events == before.events
    assert copied.lappet.events["hook_1"].target != pulled.lappet.events["hook_1"].target
    ops.event_retime(event="hook_1", time=11)
    assert event_value(pulled, find_event(pulled, "hook_1")) == before.event("hook_1")


def test_in_a_linked_copy_retiming_leaves_the_shared_keyframes_where_they_are(pulled: bpy.types.Scene) -> None:
    copied = pulled.copy()
    targets = event_value(pulled, find_event(pulled, "hook_1")).targets
    copied.lappet.events["hook_1"].moment = 12.0
    assert event_value(pulled, find_event(pulled, "hook_1")).targets == targets
    with bpy.context.temp_override(scene=copied):
        ops.event_remove(event="hook_1")
    assert event_value(pulled, find_event(pulled, "hook_1")).targets == targets


def test_reading_a_scene_again_and_again_samples_a_riding_target_once_until_something_moves(
    pulled: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller_of(pulled)  # from now on the solving side watches the scene too
    sampled = []
    matrices = target_samples._evaluate

    def counted(*arguments: object) -> object:
        sampled.append(pulled.frame_current)
        return matrices(*arguments)

    monkeypatch.setattr(target_samples, "_evaluate", counted)

    def idle(times: int) -> int:
        sampled.clear()
        for _ in range(times):
            bpy.context.view_layer.update()
            run_timer()
            read_scene(pulled)
        return len(sampled)

    idle(4)
    assert idle(12) == 0, "what sampling makes Blender do is taken for a change, without end"
    pulled.frame_set(15)
    idle(4)
    assert idle(12) == 0
    pulled.lappet.events["hook_1"].target.keyframe_insert("location", frame=18)
    assert 1 <= idle(4) <= 3
    assert idle(12) == 0
    pulled.lappet.events["hook_2"].target.location.x += 2.0
    assert 1 <= idle(4) <= 3
    assert idle(12) == 0


def test_a_hook_that_rides_on_a_moved_empty_is_sampled_anew(pulled: bpy.types.Scene) -> None:
    before = event_value(pulled, find_event(pulled, "hook_2")).targets
    assert len(before) == 13
    pulled.lappet.events["hook_1"].moment = 10.0
    bpy.context.view_layer.update()
    after = dict(event_value(pulled, find_event(pulled, "hook_2")).targets)
    for time, place in before:
        if time + 2.0 in after:
            assert after[time + 2.0] == pytest.approx(place, abs=1e-5)
    assert after[12.0] != pytest.approx(dict(before)[12.0], abs=1e-3)


class Drawn:
    """Stands in for a layout: keeps what is drawn, and refuses a property that the data has not."""

    def __init__(self, log: list[tuple[str, str]]) -> None:
        self.log = log
        self.active = self.use_property_split = self.use_property_decorate = True
        self.ui_units_x = 0.0

    def row(self, align: bool = False) -> Drawn:
        return Drawn(self.log)

    column = row

    def prop(self, data: object, name: str, **_: object) -> None:
        assert name in data.bl_rna.properties, name
        self.log.append(("prop", name))

    def label(self, text: str = "", icon: str = "NONE") -> None:
        assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
        self.log.append(("label", text))

    def operator(self, name: str, text: str = "", icon: str = "NONE", emboss: bool = True) -> Drawn:
        group, _, own = name.partition(".")
        assert getattr(getattr(bpy.ops, group), own).get_rna_type()
        assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
        self.log.append(("operator", name))
        return Drawn(self.log)

    def menu(self, name: str, **_: object) -> None:
        getattr(bpy.types, name).draw(SimpleNamespace(layout=self), bpy.context)

    def popover(self, name: str, text: str, icon: str) -> None:
        assert hasattr(bpy.types, name)
        assert icon in bpy.types.UILayout.bl_rna.functions["popover"].parameters["icon"].enum_items
        self.log.append(("popover", text))

    def template_list(self, *_: object, **__: object) -> None:
        self.log.append(("list", ""))

    def separator(self) -> None:
        pass


def test_the_panel_lists_events_in_order_of_time_with_the_fields_of_the_active_one(pulled: bpy.types.Scene) -> None:
    from lappet_blender.events import timeline_panel

    ops.suture_add(first=(0, 1, TOP), second=(0, -1, TOP), start=5, duration=4)
    ops.landmark_add(point=(5, 5, TOP), label="here")
    assert timeline_panel.time_order(pulled) == [1, 3, 4, 2, 0]
    edges = [[{"name": "", "co": (x, y, TOP)} for x in (-3, 3)] for y in (2, -2)]
    ops.suture_run(first_edge=edges[0], second_edge=edges[1], start=6, duration=4, spacing=2)
    expected = {
        "incision_1": {"moment", "through", "depth", "kerf", "closed", "basis", "direction"},
        "hook_1": {"moment", "end", "target", "stiffness"},
        "suture_1": {"moment", "duration", "mode", "pull_through"},
        "suture_run_1": {
            *("moment", "duration", "spacing", "pattern", "order", "margin", "bite", "mode", "pull_through", "sewn_in"),
            *("depth", "between"),
        },
        "landmark_1": {"label"},
    }
    for name, fields in expected.items():
        log: list[tuple[str, str]] = []
        pulled.lappet.active_event = pulled.lappet.events.find(name)
        panel = SimpleNamespace(layout=Drawn(log))
        timeline_panel.LAPPET_PT_timeline.draw(panel, bpy.context)
        assert {field for what, field in log if what == "prop"} == fields | {"title"}
        assert log.count(("operator", "wm.tool_set_by_id")) == 9, "a tool for every kind"
        row: list[tuple[str, str]] = []
        timeline_panel.LAPPET_UL_events.draw_item(
            SimpleNamespace(), bpy.context, Drawn(row), None, pulled.lappet.events[name], 0, None, ""
        )
        assert ("prop", "enabled") in row
