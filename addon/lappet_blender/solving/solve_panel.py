"""The panel that solves: button, progress, state in plain words, what is wrong, settings."""

import textwrap

import bpy

from ..model.scene_problem import SceneProblem
from .controller import controller_of
from .frames import failure_of, notes_of, problems_of, progress_of
from .select_problem import problem_event

_LETTER = 6.5  # pixels of a letter at a scale of 1, about
_MOST_PROBLEMS = 6
_CLOSED = {"DEFAULT_CLOSED"}


class LAPPET_PT_solve(bpy.types.Panel):
    """Solve the procedure and see how far it is."""

    bl_label = "Solve"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Lappet"
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
        lines(layout, context, progress.line if ready else "Make a mesh the tissue first.")

        row = layout.row()
        row.enabled = ready and not progress.running
        row.operator("lappet.live", icon="REC", depress=progress.live)

        failure = failure_of(scene)
        if failure is not None:
            box = layout.box()
            if failure.time is not None:
                box.operator("lappet.failure_show", text=f"Frame {failure.time} failed", icon="ERROR")
            lines(box, context, failure.sentence)
        if ready:
            _problems(layout, context)
        for note in notes_of(scene):
            lines(layout, context, note, icon="INFO")


class LAPPET_PT_solve_settings(bpy.types.Panel):
    """How exactly to solve and where frames are kept."""

    bl_label = "Settings"
    bl_parent_id = "LAPPET_PT_solve"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Lappet"
    bl_options = _CLOSED

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        solving = context.scene.lappet.solving
        for name in ("tolerance", "precision", "quadrature", "threads"):
            layout.prop(solving, name)
        row = layout.row()
        row.enabled = bool(bpy.data.filepath) or solving.beside_file
        row.prop(solving, "beside_file")
        lines(layout, context, str(controller_of(context.scene).store.folder), icon="FILE_FOLDER")
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
        if isinstance(problem, SceneProblem) and problem.operator:
            remedy = row.operator(problem.operator, text="Repair", icon="TOOL_SETTINGS")
            for key, value in problem.arguments:
                setattr(remedy, key, value)
        lines(box, context, f"{problem.message} {problem.remedy}")
    more = len(problems) - _MOST_PROBLEMS
    if more > 0:
        layout.label(text=f"and {more} more")


def _bar(layout: bpy.types.UILayout, factor: float, text: str) -> None:
    if hasattr(layout, "progress"):
        layout.progress(factor=factor, text=text)
    else:
        layout.label(text=text)


def lines(layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str = "NONE") -> None:
    """A sentence over as many rows as the panel's width needs."""
    scale = context.preferences.system.ui_scale or 1.0  # 0 without a window
    width = context.region.width if context.region is not None else 260
    column = layout.column(align=True)
    column.scale_y = 0.8
    for index, line in enumerate(textwrap.wrap(text, max(16, int(width / (_LETTER * scale)) - 6))):
        column.label(text=line, icon=icon if index == 0 else "BLANK1" if icon != "NONE" else "NONE")


CLASSES = (LAPPET_PT_solve, LAPPET_PT_solve_settings)
