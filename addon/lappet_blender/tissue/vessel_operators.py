"""Operators on vessels and nerves, which are drawn with Blender's own curves."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Vessel, VesselKind

from ..model.vessel_values import KIND_ITEMS, KIND_OF, set_vessel
from .drawn_curves import drawn_curves
from .tissue_operator import OnTissue


class LAPPET_OT_vessels_add(OnTissue, bpy.types.Operator):
    """Let curves that were drawn in the tissue or on it be vessels or nerves, which move with it"""

    bl_label = "Vessels from Curves"

    object: StringProperty(name="Object", description="Name of the curve; empty = the selected curves")
    kind: EnumProperty(name="Kind", items=KIND_ITEMS)
    radius: FloatProperty(name="Radius", description="Outer radius, mm", default=Vessel.radius, min=0.01, soft_max=3.0)
    label: StringProperty(name="Label", description="Name in pictures and reports; empty = that of the curve")
    typical_course: BoolProperty(
        name="Typical course", description="The course is that of a textbook, not this patient's", default=False
    )

    def run(self, context: bpy.types.Context) -> None:
        vessels = context.scene.lappet.vessels
        taken = {vessel.name for vessel in vessels}
        kind: VesselKind = KIND_OF[self.kind]
        for drawn in drawn_curves(context, self.object, taken):
            value = Vessel(drawn.name, drawn.points, kind, self.radius, self.label, self.typical_course)
            set_vessel(vessels.add(), value)


class LAPPET_OT_vessel_remove(OnTissue, bpy.types.Operator):
    """Remove a vessel; a curve that it was drawn as stays"""

    bl_label = "Remove Vessel"

    name: StringProperty(name="Name")

    def run(self, context: bpy.types.Context) -> None:
        vessels = context.scene.lappet.vessels
        index = vessels.find(self.name)
        if index < 0:
            known = ", ".join(vessel.name for vessel in vessels) or "none"
            raise refused(ProblemCode.VESSEL_UNKNOWN, "", self.name, known=known)
        vessels.remove(index)


CLASSES = (LAPPET_OT_vessels_add, LAPPET_OT_vessel_remove)
