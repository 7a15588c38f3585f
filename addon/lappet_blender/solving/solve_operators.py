"""Operators that solve, manifest and cancel, and those about solved frames."""

import bpy
from bpy.props import BoolProperty, IntProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..interface.operator_base import NO_UNDO, OperatorBase
from .frames import failure_of, problems_of, progress_of
from .scene_watch import reading
from .select_problem import select_problem, show_place
from .solve_jobs import cancel_solve, clear_frames, reload_frames, start_manifest, start_solve
from .wait_for_solve import wait_for_manifest, wait_for_solve


class LAPPET_OT_solve(OperatorBase, bpy.types.Operator):
    """Solve all frames that are not solved yet, in the background"""

    bl_label = "Solve"
    bl_options = NO_UNDO

    wait: BoolProperty(
        name="Wait", description="Return when solving is done, for scripts; Ctrl-C cancels", options={"SKIP_SAVE"}
    )
    until: IntProperty(
        name="Until", description="The last frame to solve; -1 = all", default=-1, min=-1, options={"SKIP_SAVE"}
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        done = super().execute(context)
        if "FINISHED" in done and self.cancelled:
            self.report({"WARNING"}, "The solve was cancelled; the frames solved so far are kept.")
            return {"CANCELLED"}
        return done

    def run(self, context: bpy.types.Context) -> None:
        self.cancelled = False
        with reading():
            start_solve(context.scene, None if self.until < 0 else self.until)
        if self.wait:
            self.cancelled = not wait_for_solve(context.scene)


class LAPPET_OT_solve_cancel(OperatorBase, bpy.types.Operator):
    """Stop solving; the frames solved so far are kept"""

    bl_label = "Cancel"
    bl_options = NO_UNDO

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only while there is something to cancel."""
        return bool(progress_of(context.scene).running)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return {"FINISHED"} if cancel_solve(context.scene) else {"CANCELLED"}


class LAPPET_OT_plan_now(OperatorBase, bpy.types.Operator):
    """Cut the tissue at rest and find out which frames are solved; nothing is solved"""

    bl_label = "Prepare Cuts"
    bl_options = NO_UNDO

    wait: BoolProperty(name="Wait", description="Return when it is done", default=True, options={"SKIP_SAVE"})

    def run(self, context: bpy.types.Context) -> None:
        with reading():
            start_manifest(context.scene)
        if self.wait:
            wait_for_manifest(context.scene)


class LAPPET_OT_clear_frames(OperatorBase, bpy.types.Operator):
    """Delete the solved frames of this procedure, also for copies of the scene; this cannot be undone"""

    bl_label = "Clear Solved Frames"
    bl_options = NO_UNDO

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_confirm(self, event)

    def run(self, context: bpy.types.Context) -> str:
        with reading():
            count = clear_frames(context.scene)
        return f"{count} solved frame{'' if count == 1 else 's'} cleared."


class LAPPET_OT_reload_frames(OperatorBase, bpy.types.Operator):
    """Check again which frames are solved: another program may have solved some"""

    bl_label = "Reload Frames"
    bl_options = NO_UNDO

    def run(self, context: bpy.types.Context) -> None:
        with reading():
            reload_frames(context.scene)


class LAPPET_OT_failure_show(OperatorBase, bpy.types.Operator):
    """Go to the frame at which the solve stopped"""

    bl_label = "Go to the Failed Frame"
    bl_options = NO_UNDO

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only where a frame failed."""
        failure = failure_of(context.scene)
        return failure is not None and failure.time is not None

    def run(self, context: bpy.types.Context) -> None:
        failure = failure_of(context.scene)
        if failure is not None and failure.time is not None:
            context.scene.frame_set(failure.time)


class LAPPET_OT_problem_show(OperatorBase, bpy.types.Operator):
    """Select what this problem is about, and look there"""

    bl_label = "Show"

    index: IntProperty(name="Problem", default=0, min=0, options={"SKIP_SAVE"})

    def run(self, context: bpy.types.Context) -> str | None:
        problems = problems_of(context.scene)
        if self.index >= len(problems):
            raise refused(ProblemCode.PROBLEM_UNKNOWN, "", self.index, count=len(problems))
        found = problems[self.index]
        placed = show_place(context, found)
        if not select_problem(context.scene, context.view_layer, found) and not placed:
            return f"{found.prim} is nothing in the scene that could be selected."
        return None


CLASSES = (
    LAPPET_OT_solve,
    LAPPET_OT_solve_cancel,
    LAPPET_OT_plan_now,
    LAPPET_OT_clear_frames,
    LAPPET_OT_reload_frames,
    LAPPET_OT_failure_show,
    LAPPET_OT_problem_show,
)
