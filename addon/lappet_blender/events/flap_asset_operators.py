"""Operators on plans of flaps from the asset browser."""

from pathlib import Path

import bpy
import numpy as np
from bpy.props import StringProperty

from lappet.checks.narrow_flaps import narrow_flaps
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.library import library_design
from lappet.designs.library_operation import add_flap

from ..interface.operator_base import NO_UNDO, OperatorBase
from ..interface.problem_sentence import problem_sentence
from ..model.units import mm_per_unit, to_mm
from .flap_assets import DESIGN, LIBRARY, register_library, size_of, write_library
from .flap_relay import put_flap, scene_procedure


class LAPPET_OT_flap_assets(OperatorBase, bpy.types.Operator):
    """Show the plans of all flaps in the asset browser, in this scene's unit. Drag one onto the skin, then lay it"""

    bl_label = "Flaps in Asset Browser"
    bl_options = NO_UNDO

    directory: StringProperty(
        name="Folder", description="Where the library is written; empty = the user's folder", subtype="DIR_PATH"
    )

    def run(self, context: bpy.types.Context) -> str:
        folder = self.directory or bpy.utils.user_resource("DATAFILES", path="lappet_flaps", create=True)
        write_library(Path(folder), mm_per_unit(context.scene))
        register_library(context.preferences, Path(folder))
        return f"The asset browser has them as {LIBRARY}."


class LAPPET_OT_flap_from_plan(OperatorBase, bpy.types.Operator):
    """Lay the flap of the plan that is the active object: where it lies, along its x axis, as large as it is scaled"""

    bl_label = "Lay Flap"
    edits_procedure = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "OBJECT" and context.object is not None and DESIGN in context.object

    def run(self, context: bpy.types.Context) -> str:
        scene, plan = context.scene, context.object
        design = library_design(str(plan[DESIGN]))
        context.view_layer.update()
        size, matrix = size_of(scene, plan), plan.matrix_world
        if not size > 0.0:
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, design.name, f"{size:g}", name="scale")
        lengths = {each.name: round(size * each.default, 3) for each in design.parameters if each.unit == "mm"}
        before = scene_procedure(scene)
        after = add_flap(
            before,
            design.name,
            to_mm(scene, matrix.translation),
            np.array(matrix.col[0].xyz.normalized(), np.float64),
            lengths,
            mirrored=matrix.determinant() < 0.0,
            start=float(scene.frame_current),
        )
        count = put_flap(scene, before, after)
        curve = plan.data
        bpy.data.objects.remove(plan)
        if curve is not None and not curve.users:
            bpy.data.curves.remove(curve)
        for found in narrow_flaps(after, set()):
            self.report({"WARNING"}, problem_sentence(found))
        return f"{design.title}: {count} events."


CLASSES = (LAPPET_OT_flap_assets, LAPPET_OT_flap_from_plan)
