"""Operator: look for what is wrong with the tissue and show it on the mesh."""

import bpy
from bpy.props import IntProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..interface.operator_base import NO_UNDO
from ..model.units import to_world
from .tissue_check import check_tissue, last_check
from .tissue_operator import OnTissue


class LAPPET_OT_tissue_check(OnTissue, bpy.types.Operator):
    """Look for holes, self-intersections, thin places and other problems, and show them on the mesh"""

    bl_label = "Check"
    bl_options = NO_UNDO

    def run(self, context: bpy.types.Context) -> str:
        problems = check_tissue(context.scene).problems()
        errors = sum(each.severity == "error" for each in problems)
        if not problems:
            return "No problems found."
        warnings = len(problems) - errors
        return (
            f"{errors} problem{'s' * (errors != 1)}, {warnings} warning{'s' * (warnings != 1)}: {problems[0].message}"
        )


class LAPPET_OT_tissue_show_problem(OnTissue, bpy.types.Operator):
    """Move the 3D cursor to the problem and look there"""

    bl_label = "Show Problem"

    index: IntProperty(name="Problem", default=0, min=0)

    def run(self, context: bpy.types.Context) -> None:
        found = last_check(context.scene)
        if found is None or self.index >= len(found.places):
            raise refused(ProblemCode.PROBLEM_UNKNOWN, "", self.index, count=0 if found is None else len(found.places))
        middle = found.places[self.index].middle()
        if middle is None:
            raise refused(ProblemCode.PROBLEM_NOWHERE)
        context.scene.cursor.location = to_world(context.scene, middle.tolist())
        if context.region_data is not None:
            context.region_data.view_location = context.scene.cursor.location


CLASSES = (LAPPET_OT_tissue_check, LAPPET_OT_tissue_show_problem)
