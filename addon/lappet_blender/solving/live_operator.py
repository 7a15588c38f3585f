"""The operator of live mode: starts it, ends it on Return or Esc, and leaves every other key and the mouse alone."""

import bpy
from bpy.props import StringProperty

from lappet.core.problem import RefusedError

from .controller import controller_of, find_controller
from .frames import announce
from .live_hook import start_live, stop_live
from .scene_watch import reading

_OPTIONS = {"REGISTER"}


def _stop(scene: bpy.types.Scene) -> None:
    """Ends live mode; a keyframe that this sets is an act of its own to undo."""
    controller = controller_of(scene)
    keyed = stop_live(scene, controller)
    announce(scene, controller)
    if keyed:
        bpy.ops.ed.undo_push(message="Drag Hook")


class LAPPET_OT_live(bpy.types.Operator):
    """Drag the target of the active hook and see the skin follow; again, Return or Esc ends it"""

    bl_idname = "lappet.live"
    bl_label = "Live"
    bl_options = _OPTIONS

    hook: StringProperty(name="Hook", description="Its name; empty = the active event", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Without a window it only switches: the timer follows the target."""
        scene = context.scene
        controller = controller_of(scene)
        if controller.live is not None:
            _stop(scene)
            return {"FINISHED"}
        try:
            with reading():
                start_live(scene, self.hook)
        except RefusedError as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        announce(scene, controller)
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """In a window it runs until a key ends it."""
        done = self.execute(context)
        if done != {"FINISHED"} or controller_of(context.scene).live is None:
            return done
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set("Live: drag the hook's target   |   Return, Esc: end")
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        scene = context.scene
        controller = find_controller(scene)
        if controller is not None and controller.live is not None:
            if event.type not in {"ESC", "RET", "NUMPAD_ENTER"} or event.value != "PRESS":
                return {"PASS_THROUGH"}
            _stop(scene)
        context.workspace.status_text_set(None)
        return {"FINISHED"}


CLASSES = (LAPPET_OT_live,)
