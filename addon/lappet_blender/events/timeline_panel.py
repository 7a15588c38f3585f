"""The timeline panel: the events in order of time, and the fields of the active one."""

from __future__ import annotations

import math
from typing import Any

import bpy

from lappet.core.value_with_error import with_error
from lappet.designs.library import DESIGNS

from ..interface.said import said
from ..interface.sidebar_panel import SidebarPanel, draw_presets, with_fields
from ..model.event_kinds import CUT_KINDS, HOLD_KINDS, KINDS
from ..model.event_list import event_end, event_time, sorted_events
from ..model.event_target import is_there
from ..model.laid_flaps import active_flap, design_of
from ..solving.frames import frame_state, pull_of, pulls_of_run
from .flap_assets import DESIGN
from .flap_thumbnails import thumbnail
from .run_preview import stitches_of

ICONS = {kind[0]: kind[3] for kind in KINDS}
STATES = {"solved": "CHECKMARK", "stale": "FILE_REFRESH", "failed": "ERROR", "missing": "BLANK1"}
_WIDE = 300  # pixels at a scale of 1; a sidebar as it opens is narrower
# The tool that places an event of each kind.
TOOLS = {
    "INCISION": "lappet.cutting.incision",
    "EXCISION": "lappet.excise",
    "UNDERMINE": "lappet.cutting.undermining",
    "THIN": "lappet.cutting.thinning",
    "HOOK": "lappet.hook",
    "RETRACTOR": "lappet.retractor",
    "SUTURE": "lappet.suture",
    "SUTURE_RUN": "lappet.suture",
    "LANDMARK": "lappet.landmark",
}


def time_order(scene: bpy.types.Scene) -> list[int]:
    """For each event its row in the list."""
    rows = [0] * len(scene.lappet.events)
    for row, index in enumerate(sorted_events(scene)):
        rows[index] = row
    return rows


def state_of(scene: bpy.types.Scene, event: Any) -> str:
    """Whether the first frame of an event is solved, stale, failed or missing."""
    return str(frame_state(scene, max(math.ceil(event_time(event)), scene.frame_start)))


def _is_wide(context: bpy.types.Context) -> bool:
    """Whether the sidebar has room for when events end; names come first."""
    return context.region is None or context.region.width > _WIDE * (context.preferences.system.ui_scale or 1.0)


class LAPPET_UL_events(bpy.types.UIList):
    """Events in order of time."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
        _index: int = 0,
        _flag: int = 0,
    ) -> None:
        row = layout.row(align=True)
        row.active = item.enabled
        row.prop(item, "enabled", text="")
        row.operator("lappet.event_jump", text="", icon=ICONS[item.kind], emboss=False).event = item.uid
        row.prop(item, "title", text="", emboss=False)  # takes what the others leave of a narrow sidebar
        if item.kind != "LANDMARK":
            time = row.row(align=True)
            time.ui_units_x = 2.3
            time.prop(item, "moment", text="", emboss=False)
            if _is_wide(context):
                until = row.row(align=True)
                until.ui_units_x = 1.9
                end = event_end(item)
                until.label(text=f"– {end:g}" if end > event_time(item) else "")
            row.label(text="", icon=STATES[state_of(context.scene, item)])

    def filter_items(self, context: bpy.types.Context, _data: Any, _property: str) -> tuple[list[int], list[int]]:
        events = context.scene.lappet.events
        shown: list[int] = []
        if self.filter_name:
            shown = bpy.types.UI_UL_list.filter_items_by_name(self.filter_name, self.bitflag_filter_item, events)
        return shown, time_order(context.scene)


class LAPPET_MT_event_add(bpy.types.Menu):
    """Switch to the tool that places an event."""

    bl_label = "Add Event"

    def draw(self, _context: bpy.types.Context) -> None:
        for kind, name, _, icon, _ in KINDS:
            self.layout.operator("wm.tool_set_by_id", text=name, icon=icon).name = TOOLS[kind]


class LAPPET_PT_timeline(SidebarPanel, bpy.types.Panel):
    """The events of the operation and when they happen."""

    bl_label = "Timeline"
    bl_order = 20

    def draw(self, context: bpy.types.Context) -> None:
        layout, data = self.layout, context.scene.lappet
        row = layout.row()
        row.template_list("LAPPET_UL_events", "", data, "events", data, "active_event", rows=5)
        side = row.column(align=True)
        side.menu("LAPPET_MT_event_add", text="", icon="ADD")
        side.operator("lappet.event_duplicate", text="", icon="DUPLICATE")
        side.operator("lappet.event_remove", text="", icon="REMOVE")
        side.separator()
        side.operator("lappet.event_select", text="", icon="RESTRICT_SELECT_OFF")
        layout.popover("VIEW3D_PT_lappet_flaps", text="Flap Library", icon="ASSET_MANAGER")
        if context.object is not None and DESIGN in context.object:
            layout.operator("lappet.flap_from_plan", icon="CHECKMARK")
        if not len(data.events):
            layout.label(text="Draw an incision to start.", icon="INFO")
            return
        if 0 <= data.active_event < len(data.events):
            draw_flap(layout, context.scene)
            draw_fields(layout, context.scene, data.events[data.active_event])


def draw_flap(layout: Any, scene: bpy.types.Scene) -> None:
    """The laid flap that the active event belongs to."""
    flap = active_flap(scene)
    design = DESIGNS.get(design_of(scene, flap))
    if design is None:
        return
    row = layout.row(align=True)
    row.label(text=flap, icon_value=thumbnail(design.name))
    edit = row.operator(f"lappet.flap_edit_{design.name.replace('-', '_')}", text="Edit", icon="GREASEPENCIL")
    edit.flap = flap
    row.operator("lappet.flap_remove", text="", icon="X").flap = flap


def draw_fields(layout: Any, scene: bpy.types.Scene, event: Any) -> None:
    """The fields that count for the kind of an event."""
    fields = with_fields(layout.column())
    fields.prop(event, "title")
    if event.kind != "LANDMARK":
        row = fields.row(align=True)
        row.prop(event, "moment")
        for text, shift in (("−1", -1.0), ("+1", 1.0)):
            part = row.row(align=True)
            part.ui_units_x = 1.2
            step = part.operator("lappet.event_retime", text=text)
            step.event, step.shift = event.uid, shift
    if event.kind in HOLD_KINDS:
        fields.prop(event, "end")
        fields.prop(event, "target")
        if not is_there(scene, event.target):
            fields.label(text="The target is not in the scene.", icon="ERROR")
    match event.kind:
        case "INCISION":
            fields.prop(event, "through")
            deep = fields.column()
            deep.active = not event.through
            deep.prop(event, "depth")
            fields.prop(event, "kerf")
            fields.prop(event, "direction")
            fields.prop(event, "closed")
        case "THIN":
            for name in ("thickness", "dressing", "duration"):
                fields.prop(event, name)
        case "HOOK":
            fields.prop(event, "stiffness")
        case "RETRACTOR":
            fields.prop(event, "grip")
        case "SUTURE":
            fields.prop(event, "duration")
            row = fields.row(align=True)
            row.prop(event, "mode")
            draw_presets(row, "LAPPET_PT_thread_presets")
            if event.mode == "THREAD":
                fields.prop(event, "thread")
                if event.thread == "NONE":
                    fields.prop(event, "stiffness")
                fields.prop(event, "length")
                fields.prop(event, "tension")
            fields.prop(event, "pull_through")
        case "SUTURE_RUN":
            draw_run(fields, scene, event)
        case "LANDMARK":
            fields.prop(event, "label")
    if event.kind in CUT_KINDS and event.kind != "EXCISION":
        fields.prop(event, "basis")
        fields.label(text=said("Points: {count}", count=len(event.points)))
    if event.kind in ("HOOK", "SUTURE"):
        _draw_pull(layout, scene, event)
    elif event.kind == "SUTURE_RUN":
        _draw_pulls(layout, scene, event)


def _draw_pull(layout: Any, scene: bpy.types.Scene, event: Any) -> None:
    """What a hook or a suture pulls with in the frame that is shown, with its estimated error."""
    pull = pull_of(scene, scene.frame_current, event.name)
    if pull is None:
        return
    if pull.resolved:
        layout.label(text=said("Pulls with {force} mN in this frame", force=with_error(pull.force_mn, pull.error_mn)))
    else:
        layout.label(text="The lattice does not part its ends: no force", icon="ERROR")


def draw_run(fields: Any, scene: bpy.types.Scene, event: Any) -> None:
    """The fields of a suture run."""
    for name in ("duration", "spacing", "pattern", "order", "margin", "bite"):
        fields.prop(event, name)
    if event.pattern == "INTERRUPTED":
        fields.prop(event, "mode")
    else:
        fields.prop(event, "pass_depth")
    if event.pattern != "INTERRUPTED" or event.mode == "THREAD":
        fields.prop(event, "thread")
        if event.thread == "NONE":
            fields.prop(event, "stiffness")
        fields.prop(event, "drawn")
        fields.prop(event, "tension")
    fields.prop(event, "pull_through")
    fields.prop(event, "sewn_in")
    for layer in event.layers:
        row = fields.row(align=True)
        row.prop(layer, "depth", text=layer.name.capitalize())
        row.prop(layer, "between", text="", icon="ALIGN_JUSTIFY")
    count = len(stitches_of(scene, event))
    fields.label(text=said("Stitches: {count}", count=count) if count else "It cannot be sewn as it is", icon="INFO")


def _draw_pulls(layout: Any, scene: bpy.types.Scene, event: Any) -> None:
    """What the stitches of a run pull with in the frame that is shown: in all, and the strongest of them."""
    pulls = pulls_of_run(scene, scene.frame_current, event.name)
    if pulls:
        most = max(pulls, key=lambda each: each.force_mn)
        total = f"{sum(each.force_mn for each in pulls):.3g}"
        layout.label(text=said("Pulls with {force} mN in all in this frame", force=total))
        name = most.event.partition("/")[2]
        layout.label(text=said("Most: {force} mN at {name}", force=with_error(most.force_mn, most.error_mn), name=name))


CLASSES = (LAPPET_UL_events, LAPPET_MT_event_add, LAPPET_PT_timeline)
