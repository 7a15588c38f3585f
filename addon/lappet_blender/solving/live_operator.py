"""The operator of live mode: starts it, ends it on Return or Esc, and leaves every other key and the mouse alone."""

import bpy
from bpy.props import StringProperty

from ..interface.operator_base import NO_UNDO, OperatorBase
from ..interface.said import said
from .controller import controller_of, find_controller
from .frames import notify_listeners
from .live_drag import start_live, stop_live
from .scene_watch import reading


def _stop(scene: bpy.types.Scene) -> None:
    """End live mode; a keyframe that this sets is an act of its own to undo."""
    controller = controller_of(scene)
    keyed = stop_live(scene, controller)
    notify_listeners(scene, controller)
    if keyed:
        bpy.ops.ed.undo_push(message="Drag Target")


class LAPPET_OT_live(OperatorBase, bpy.types.Operator):
    """Drag the target of the active hook or retractor and watch the skin follow; press again, Return or Esc to end"""

    bl_label = "Live"
    bl_options = NO_UNDO

    hook: StringProperty(
        name="Hook", description="Name of the hook or retractor; empty = the active event", options={"SKIP_SAVE"}
    )

    def run(self, context: bpy.types.Context) -> None:
        """Without a window it only switches: the timer follows the target."""
        scene = context.scene
        controller = controller_of(scene)
        if controller.live is not None:
            _stop(scene)
            return
        with reading():
            start_live(scene, self.hook)
        notify_listeners(scene, controller)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """In a window it runs until a key ends it."""
        done = self.execute(context)
        if done != {"FINISHED"} or controller_of(context.scene).live is None:
            return done
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(said("Live: drag the target   |   Return, Esc: end"))
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
