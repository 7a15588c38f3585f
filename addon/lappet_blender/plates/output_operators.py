"""Operators that write plates, films and files for other programs in the background."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.export.formats import EXPORTERS, check_options, exporter_of
from lappet.export.simplify_target import SimplifyTarget
from lappet.plates.film_file import SUFFIXES as FILM_SUFFIXES

from ..interface.operator_base import NO_UNDO, OperatorBase
from ..model.plate_properties import STYLES
from .output_jobs import begin_output, cancel_output, last_job, state_line
from .plate_edits import chosen_plate

PLATE_SUFFIXES = (".svg", ".pdf", ".png", ".tif", ".tiff")
_WAIT = 3600.0  # seconds that a script waits at most
_SIZES = (
    ("1920x1080", "1920 × 1080", "Full HD"),
    ("3840x2160", "3840 × 2160", "4K"),
    ("1280x720", "1280 × 720", "HD"),
)


def target_of(operator: Any, known: Sequence[str]) -> Path:
    """The file that an operator writes; raises RefusedError where its suffix is none of those known."""
    path = Path(bpy.path.abspath(operator.filepath))
    if path.suffix.lower() not in known:
        raise refused(ProblemCode.OUTPUT_SUFFIX, path.name, path.suffix, known=", ".join(known))
    return path


class _Output(OperatorBase, ExportHelper):
    """Mixed into an operator that begins a job; the operator has `begin`."""

    check_extension = None

    def begin(self, context: bpy.types.Context) -> None:
        """Begin the job."""
        raise NotImplementedError

    def run(self, context: bpy.types.Context) -> str:
        self.begin(context)
        job = last_job()
        if self.wait and job is not None:
            job.join(_WAIT)
            if job.problem is not None:
                raise RefusedError([job.problem])
        return state_line()


def _wait() -> Any:
    return BoolProperty(name="Wait", description="Return when it is written, for scripts", options={"SKIP_SAVE"})


class LAPPET_OT_plate_write(_Output, bpy.types.Operator):
    """Draw the chosen plate to a file in the background: SVG, PDF, PNG or TIFF; needs an installed `lappet`"""

    bl_label = "Write Plate"
    bl_options = NO_UNDO

    filename_ext = ".pdf"
    filter_glob: StringProperty(default=";".join(f"*{each}" for each in PLATE_SUFFIXES), options={"HIDDEN"})
    style: EnumProperty(name="Style", items=(("PLATE", "As the Plate", "As the plate has it"), *STYLES))
    dpi: IntProperty(name="DPI", description="Pixels per inch of what is no line", default=300, min=72, max=2400)
    transparent: BoolProperty(name="Transparent", description="Leave the paper out")
    wait: _wait()

    def begin(self, context: bpy.types.Context) -> None:
        plate = chosen_plate(context.scene)
        target = target_of(self, PLATE_SUFFIXES)
        more = ["--plate", str(plate.name), "--dpi", str(self.dpi)]
        more += [] if self.style == "PLATE" else ["--style", self.style]
        more += ["--transparent"] if self.transparent else []
        begin_output(context.scene, target, lambda cache: ["plate", str(cache), "-o", str(target), *more])


class LAPPET_OT_film_write(_Output, bpy.types.Operator):
    """Draw all solved frames as a film in the background: MP4, WebM, GIF, WebP or PNG; needs an installed `lappet`"""

    bl_label = "Write Film"
    bl_options = NO_UNDO

    filename_ext = ".mp4"
    filter_glob: StringProperty(default=";".join(f"*{each}" for each in FILM_SUFFIXES), options={"HIDDEN"})
    style: EnumProperty(name="Style", items=STYLES, default="schematic")
    size: EnumProperty(name="Size", items=_SIZES)
    fps: FloatProperty(name="Frames", description="Solved frames per second", default=8.0, min=0.1, max=60.0)
    pause: FloatProperty(name="Pause", description="Seconds on each step", default=2.0, min=0.0, max=60.0)
    wait: _wait()

    def begin(self, context: bpy.types.Context) -> None:
        target = target_of(self, FILM_SUFFIXES)
        more = ["--style", self.style, "--size", self.size, "--fps", f"{self.fps:g}", "--pause", f"{self.pause:g}"]
        begin_output(context.scene, target, lambda cache: ["film", str(cache), "-o", str(target), *more])


class LAPPET_OT_export_result(_Output, bpy.types.Operator):
    """Write the solved frames for other programs in the background; needs an installed `lappet`"""

    bl_label = "Export Lappet Result"
    bl_options = NO_UNDO

    filename_ext = ".html"
    filter_glob: StringProperty(default=";".join(f"*{each.suffix}" for each in EXPORTERS), options={"HIDDEN"})
    suffix: StringProperty(name="Suffix", default=".html", options={"HIDDEN", "SKIP_SAVE"})
    every_frame: BoolProperty(name="Every Frame", description="A mesh for every frame, numbered", default=False)
    simplify: StringProperty(
        name="Simplify",
        description="Leave triangles out: how many may stay (20000), or how far it may be off (0.2mm); empty for none",
    )
    wait: _wait()

    def draw(self, _context: bpy.types.Context) -> None:
        """Show the options that the format has."""
        path = Path(self.filepath)
        known = next((each.options for each in EXPORTERS if each.suffix == path.suffix.lower()), frozenset())
        self.layout.use_property_split = True
        for name in ("every_frame", "simplify"):
            if name in known:
                self.layout.prop(self, name)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        blend = Path(bpy.data.filepath or "operation.blend")
        self.filepath = str(blend.with_suffix(self.suffix))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def begin(self, context: bpy.types.Context) -> None:
        target = Path(bpy.path.abspath(self.filepath))
        exporter = exporter_of(target)
        more = ["--every-frame"] if self.every_frame and "every_frame" in exporter.options else []
        wanted = self.simplify.strip()
        if wanted:
            check_options(target, ["simplify"])
            SimplifyTarget.of(wanted)
            more += ["--simplify", wanted]
        begin_output(context.scene, target, lambda cache: ["export", str(cache), "-o", str(target), *more])


class LAPPET_OT_output_cancel(OperatorBase, bpy.types.Operator):
    """Stop writing the file"""

    bl_label = "Cancel"
    bl_options = NO_UNDO

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Only while there is something to cancel."""
        job = last_job()
        return job is not None and job.running

    def execute(self, _context: bpy.types.Context) -> set[str]:
        return {"FINISHED"} if cancel_output() else {"CANCELLED"}


CLASSES = (LAPPET_OT_plate_write, LAPPET_OT_film_write, LAPPET_OT_export_result, LAPPET_OT_output_cancel)
