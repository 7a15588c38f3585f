"""Operators: make an object the tissue, and let go of it."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from lappet.tissue.presets import PRESETS

from ..model.mesh_values import mesh_values
from ..model.surface_border import open_edge_count
from ..model.units import to_mm
from .face_choice import chosen_faces, named_faces
from .set_tissue import set_tissue
from .take_field import take_field
from .tissue_objects import named_object
from .tissue_operator import OnTissue, TissueOperator

PRESET_ITEMS = tuple(
    (name.upper(), name.capitalize().replace("_", " "), preset.source) for name, preset in PRESETS.items()
)
_OPEN_THICKNESS = 4.0  # mm, proposed for an open surface


class LAPPET_OT_tissue_set(TissueOperator, bpy.types.Operator):
    """Make the active mesh the tissue to operate on"""

    bl_label = "Make Tissue"

    object: StringProperty(name="Object", description="Name of the object; empty = the active object")
    thickness: FloatProperty(
        name="Thickness",
        description="Thickness of the sheet below an open surface, in mm; 0 for a closed surface",
        default=0.0,
        min=0.0,
        soft_max=20.0,
    )
    spacing: FloatProperty(
        name="Lattice spacing",
        description="In mm; 0 = about 40 000 cells",
        default=0.0,
        min=0.0,
        precision=3,
    )
    preset: EnumProperty(name="Material", items=PRESET_ITEMS, default="SKIN")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = context.active_object
        if not self.properties.is_property_set("thickness") and obj is not None and obj.type == "MESH":
            self.thickness = _OPEN_THICKNESS if open_edge_count(mesh_values(context.scene, obj)) else 0.0
        return self.execute(context)

    def run(self, context: bpy.types.Context) -> str | None:
        obj = named_object(context, self.object)
        return set_tissue(context.scene, obj, self.thickness, self.spacing, self.preset.lower())


class LAPPET_OT_tissue_take_field(TissueOperator, bpy.types.Operator):
    """Make tissue of the active mesh's skin around the 3D cursor, or of marked faces; the mesh stays and is hidden"""

    bl_label = "Take Skin"

    object: StringProperty(name="Object", description="Name of the object; empty = the active object")
    point: FloatVectorProperty(
        name="Point",
        description="Middle of the field, in mm; the closest point of the skin counts. The 3D cursor if left out",
        size=3,
        precision=2,
        options={"SKIP_SAVE"},
    )
    radius: FloatProperty(
        name="Radius", description="In mm, along the skin", default=40.0, min=0.1, soft_min=5.0, soft_max=150.0
    )
    thickness: FloatProperty(
        name="Thickness",
        description="Of the sheet, in mm; less where the mesh leaves no room for it",
        default=_OPEN_THICKNESS,
        min=0.01,
        soft_max=20.0,
    )
    selection: BoolProperty(
        name="Selected Faces",
        description="Take the selected faces instead of what lies around the point",
        options={"SKIP_SAVE"},
    )
    region: StringProperty(
        name="Region",
        description="Take what is marked so: a vertex group, as painted weights make it, a group of faces or a face "
        "attribute",
        options={"SKIP_SAVE"},
    )
    resolution: FloatProperty(
        name="Resolution", description="Edges are divided down to this, in mm; 0 = the thickness", default=0.0, min=0.0
    )
    preset: EnumProperty(name="Material", items=PRESET_ITEMS, default="SKIN")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context: bpy.types.Context) -> str:
        obj = named_object(context, self.object)
        given = self.properties.is_property_set("point")
        point = tuple(self.point) if given else to_mm(context.scene, context.scene.cursor.location)
        faces = named_faces(obj, self.region) if self.region and obj.type == "MESH" else None
        if self.selection and obj.type == "MESH":
            faces = chosen_faces(context.scene, obj, "", "SELECTED")
        of = (point, self.radius, self.thickness, self.resolution, self.preset.lower())
        return take_field(context, obj, *of, faces=faces)


class LAPPET_OT_tissue_clear(OnTissue, bpy.types.Operator):
    """Remove the tissue from the scene's procedure; the mesh, its groups and the events stay"""

    bl_label = "Remove Tissue"

    def run(self, context: bpy.types.Context) -> None:
        context.scene.lappet.tissue.object = None


CLASSES = (LAPPET_OT_tissue_set, LAPPET_OT_tissue_take_field, LAPPET_OT_tissue_clear)
