"""The panel that solves: button, progress, state in plain words, what is wrong, settings."""

import bpy

from ..interface.problem_sentence import problem_sentence
from ..interface.repair_button import draw_repair
from ..interface.said import said
from ..interface.sentence_lines import draw_sentence
from ..interface.sidebar_panel import CLOSED, SidebarPanel, with_fields
from .controller import controller_of
from .frames import error_of, failure_of, frame_state, is_assessed, notes_of, problems_of, progress_of
from .select_problem import problem_event

_MOST_PROBLEMS = 6


class LAPPET_PT_solve(SidebarPanel, bpy.types.Panel):
    """Solve the procedure and follow its progress."""

    bl_label = "Solve"
    bl_order = 30

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        scene = context.scene
        progress = progress_of(scene)
        ready = scene.lappet.tissue.object is not None

        row = layout.row(align=True)
        row.scale_y = 1.4
        if progress.running:
            row.operator("lappet.solve_cancel", icon="CANCEL")
        else:
            row.enabled = ready and not progress.live
            row.operator("lappet.solve", icon="PLAY")
        if progress.running or progress.total:
            _bar(layout, progress.done / max(progress.total, 1), f"{progress.done} / {progress.total}")
        draw_sentence(layout, context, progress.line if ready else said("Make a mesh the tissue first."))

        _error(layout, context)

        row = layout.row()
        row.enabled = ready and not progress.running
        row.operator("lappet.live", icon="REC", depress=progress.live)

        failure = failure_of(scene)
        if failure is not None:
            box = layout.box()
            if failure.time is not None:
                box.operator("lappet.failure_show", text=said("Frame {frame} failed", frame=failure.time), icon="ERROR")
            draw_sentence(box, context, problem_sentence(failure.problem))
        if ready:
            _problems(layout, context)
        for note in notes_of(scene):
            draw_sentence(layout, context, problem_sentence(note), "INFO")


class LAPPET_PT_solve_settings(SidebarPanel, bpy.types.Panel):
    """The accuracy of solving and the folder of solved frames."""

    bl_label = "Settings"
    bl_parent_id = "LAPPET_PT_solve"
    bl_options = CLOSED

    def draw(self, context: bpy.types.Context) -> None:
        layout = with_fields(self.layout)
        solving = context.scene.lappet.solving
        for name in ("tolerance", "precision", "quadrature", "self_contact"):
            layout.prop(solving, name)
        row = layout.row()
        row.enabled = solving.self_contact
        row.prop(solving, "friction")
        for name in ("error_estimate", "threads", "when_opened"):
            layout.prop(solving, name)
        row = layout.row()
        row.enabled = bool(bpy.data.filepath) or solving.beside_file
        row.prop(solving, "beside_file")
        draw_sentence(layout, context, str(controller_of(context.scene).store.folder), "FILE_FOLDER")
        row = layout.row(align=True)
        row.operator("lappet.reload_frames", text="Reload", icon="FILE_REFRESH")
        row.operator("lappet.clear_frames", text="Clear", icon="TRASH")


def _problems(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    problems = problems_of(context.scene)
    for index, problem in enumerate(problems[:_MOST_PROBLEMS]):
        box = layout.box()
        row = box.row(align=True)
        event = problem_event(context.scene, problem)
        name = context.scene.lappet.events[event].name if event >= 0 else problem.prim
        icon = "ERROR" if problem.severity == "error" else "INFO"
        row.operator("lappet.problem_show", text=name, icon=icon, emboss=False).index = index
        draw_repair(row, problem)
        draw_sentence(box, context, f"{problem.message} {problem.remedy}".rstrip())
    more = len(problems) - _MOST_PROBLEMS
    if more > 0:
        layout.label(text=said("and {count} more", count=more))


def _error(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """What is known of the error of the frame that is shown."""
    scene = context.scene
    error = error_of(scene, scene.frame_current)
    if error is None:
        unknown = scene.lappet.solving.error_estimate and not progress_of(scene).running and not is_assessed(scene)
        if unknown and frame_state(scene, scene.frame_current) == "solved":
            draw_sentence(layout, context, said("The error of this frame is not estimated; Solve does it"), "INFO")
        return
    greatest = f"{error.greatest:.2g}"
    if error.is_trusted:
        draw_sentence(layout, context, said("Estimated error of this frame: {error} mm at most", error=greatest))
    else:
        doubt = said("This frame is not to be trusted: its estimated error is {error} mm", error=greatest)
        draw_sentence(layout, context, doubt, "ERROR")


def _bar(layout: bpy.types.UILayout, factor: float, text: str) -> None:
    if hasattr(layout, "progress"):
        layout.progress(factor=factor, text=text)
    else:
        layout.label(text=text)


CLASSES = (LAPPET_PT_solve, LAPPET_PT_solve_settings)
