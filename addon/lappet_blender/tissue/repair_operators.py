"""Operators that repair what a problem of tissue or bone names."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from lappet.checks.validation import MEMORY_BUDGET
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..interface.problem_repairs import REPAIRS
from ..model.decimals import decimal
from ..model.scene_procedure import read_scene
from ..model.tissue_size import tissue_size
from . import repair_mesh, repair_object
from .tissue_objects import tissue_object
from .tissue_operator import OnTissue, TissueOperator


class _OnObject(TissueOperator):
    """An operator on a named object: by default the tissue."""

    object: StringProperty(name="Object", description="Name of the object; empty = the tissue")

    def meant(self, context: bpy.types.Context) -> bpy.types.Object:
        """The object meant. Raises RefusedError where it is not there or no mesh."""
        name = self.object
        if not name:
            return tissue_object(context.scene)
        procedure = context.scene.lappet
        own = [procedure.tissue.object, *(bone.object for bone in procedure.bones)]
        obj = next((each for each in own if each is not None and each.name == name), bpy.data.objects.get(name))
        if obj is None:
            raise refused(ProblemCode.OBJECT_UNKNOWN, "", name)
        if obj.type != "MESH":
            raise refused(ProblemCode.OBJECT_NOT_A_MESH, name, obj.type.lower(), role="object")
        return obj


class LAPPET_OT_tissue_apply_scale(_OnObject, bpy.types.Operator):
    """Apply the object's scale to its mesh, which keeps its place and shape"""

    bl_label = "Apply Scale"

    def run(self, context: bpy.types.Context) -> None:
        repair_object.apply_scale(self.meant(context))


class LAPPET_OT_tissue_apply_modifiers(_OnObject, bpy.types.Operator):
    """Apply the modifiers and the current mix of shape keys to the mesh"""

    bl_label = "Apply Modifiers and Shape Keys"

    def run(self, context: bpy.types.Context) -> str:
        return repair_object.apply_shape(context, self.meant(context))


class LAPPET_OT_tissue_make_local(_OnObject, bpy.types.Operator):
    """Copy a linked mesh into this file; the library's file stays as it is"""

    bl_label = "Make Local"

    def run(self, context: bpy.types.Context) -> None:
        repair_object.make_local(self.meant(context))


class LAPPET_OT_tissue_fix_place(_OnObject, bpy.types.Operator):
    """Keep the object where it is, without keyframes, drivers, constraints and parent"""

    bl_label = "Fix in Place"

    def run(self, context: bpy.types.Context) -> None:
        repair_object.fix_place(self.meant(context))


class LAPPET_OT_tissue_restore(_OnObject, bpy.types.Operator):
    """Link the object into the scene again"""

    bl_label = "Restore to Scene"

    def run(self, context: bpy.types.Context) -> None:
        repair_object.restore(context.scene, self.meant(context))


class LAPPET_OT_tissue_repair(OnTissue, bpy.types.Operator):
    """Repair the mesh of the tissue"""

    bl_label = "Repair Tissue"

    kind: EnumProperty(name="Repair", items=REPAIRS, default="WELD")
    everything: BoolProperty(name="All holes", description="Fill holes of any size", default=False)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return next(text for key, _, text in REPAIRS if key == properties.kind)

    def run(self, context: bpy.types.Context) -> str | None:
        scene = context.scene
        obj = tissue_object(scene)
        settings = scene.lappet.tissue
        match self.kind:
            case "HOLES":
                return repair_mesh.fill_holes(scene, obj, settings.thicken, self.everything)
            case "WELD":
                return repair_mesh.weld(obj)
            case "ORIENT":
                return repair_mesh.turn_alike(scene, obj)
            case "LOOSE":
                return repair_mesh.remove_loose(obj)
            case "THICKEN":
                settings.thicken = not settings.thicken
                return None
            case _:
                settings.spacing = fitting_spacing(scene)
                return f"The lattice spacing is {settings.spacing:.3g} mm."


def fitting_spacing(scene: bpy.types.Scene) -> float:
    """A spacing, mm, at which a cell is no larger than the tissue is thick and the lattice fits the memory."""
    procedure = read_scene(scene).procedure
    if procedure is None:
        raise refused(ProblemCode.TISSUE_UNREAD)
    settings, tissue = scene.lappet.tissue, procedure.tissue
    measure = tissue_size(tissue).measure
    thin = decimal(settings.thickness) if settings.thicken else float(measure.size.min())
    least = measure.least_spacing(MEMORY_BUDGET)
    return max(least, min(tissue.spacing, thin))


CLASSES = (
    LAPPET_OT_tissue_apply_scale,
    LAPPET_OT_tissue_apply_modifiers,
    LAPPET_OT_tissue_make_local,
    LAPPET_OT_tissue_fix_place,
    LAPPET_OT_tissue_restore,
    LAPPET_OT_tissue_repair,
)
