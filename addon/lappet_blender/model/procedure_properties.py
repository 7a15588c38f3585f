"""Property groups of a scene: `scene.lappet` holds the tissue, its materials, the timeline and how it looks."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from lappet.procedure import MODELS, VESSEL_KINDS, Material, Tissue, Vessel
from lappet.program.settings import SolverSettings

from .changes import property_changed
from .event_kinds import BASES
from .event_properties import LappetEvent, LappetPoint
from .plate_properties import LappetPlate
from .tracked_properties import choice, flag, number, pointer, text

VERSION = 2  # of these properties; `migrate.py` brings older files up to it

# What the menu says of a model; one that is not here shows its name.
MODEL_TEXTS = {
    "corotated": ("Corotated", "Linear elasticity that rotates with the tissue"),
    "neoHookean": ("Neo-Hookean", "Rubber-like: the usual choice for skin at small strains"),
    "stableNeoHookean": ("Stable neo-Hookean", "Stays finite even where cells are inverted"),
    "mooneyRivlin": ("Mooney–Rivlin", "Two moduli"),
}
MODEL_ITEMS = tuple((name, *MODEL_TEXTS.get(name, (name, ""))) for name in MODELS)
COLORS = (
    ("PLAIN", "Skin", "Plain skin"),
    ("GRID", "Grid", "A printed millimeter grid that shows how the skin moves"),
    ("CHECKER", "Checkerboard", "A 5 mm checkerboard that shows how the skin moves"),
    ("STRAIN", "Strain", "How far the skin is stretched"),
    ("STRESS", "Stress", "Von Mises stress in kPa"),
    ("TENSION", "Tension", "Tension along the skin"),
)


class LappetMaterial(bpy.types.PropertyGroup):
    """A material (`lappet.procedure.procedure.Material`); `name` is its name."""

    model: EnumProperty(name="Model", items=MODEL_ITEMS, default=Material.model, update=property_changed)
    youngs_modulus: FloatProperty(
        name="Young's modulus", description="kPa", default=Material.youngs_modulus, min=1e-6, update=property_changed
    )
    poissons_ratio: FloatProperty(
        name="Poisson's ratio",
        description="Below 0.5, which is incompressible",
        default=Material.poissons_ratio,
        min=-0.99,
        max=0.49999,
        precision=4,
        update=property_changed,
    )
    mooney_ratio: FloatProperty(
        name="Mooney ratio", description="The second modulus over the first", default=0.0, update=property_changed
    )
    fiber_k1: FloatProperty(
        name="Fiber stiffness", description="kPa; 0 = no fibers", default=0.0, min=0.0, update=property_changed
    )
    fiber_k2: FloatProperty(
        name="Fiber exponent", description="How fast fibers stiffen", default=0.0, min=0.0, update=property_changed
    )
    fiber_dispersion: FloatProperty(
        name="Dispersion",
        translation_context="Lappet",  # Blender's own word is that of optics
        description="0 = all fibers along the direction, 1/3 = equally in all directions",
        default=0.0,
        min=0.0,
        max=1.0 / 3.0,
        update=property_changed,
    )
    fiber_slack: FloatProperty(
        name="Slack",
        description="Stretch from which the fibers bear load",
        default=Material.fiber_slack,
        min=1.0,
        max=4.0,
        update=property_changed,
    )
    fiber_angle: FloatProperty(
        name="Angle",
        description="Degrees: half of the fibers and muscle run at it to the direction, to either side; 0 = one family",
        default=Material.fiber_angle,
        min=0.0,
        max=90.0,
        update=property_changed,
    )
    fiber_direction: FloatVectorProperty(
        name="Direction",
        description="Direction of fibers, muscle and prestretch: along the relaxed skin tension lines",
        size=3,
        default=(1.0, 0.0, 0.0),
        update=property_changed,
    )
    prestretch: FloatVectorProperty(
        name="Prestretch",
        description="In vivo, along and across the direction",
        size=2,
        default=(1.0, 1.0),
        min=0.5,
        max=2.0,
        update=property_changed,
    )
    density: FloatProperty(
        name="Density", description="kg/m³", default=Material.density, min=0.0, update=property_changed
    )
    muscle_stress: FloatProperty(
        name="Muscle", description="Maximum active stress in kPa; 0 = none", default=0.0, update=property_changed
    )
    activation: FloatProperty(
        name="Activation",
        description="Activation of the muscle, 0 to 1; can be keyframed",
        default=0.0,
        min=0.0,
        max=1.0,
        update=property_changed,
    )


class LappetRegion(bpy.types.PropertyGroup):
    """A part of the tissue that is of another material; `name` is the group of faces above it."""

    material: text(name="Material")
    depth_from: number(name="From", description="Depth below the skin, in mm", default=0.0, min=0.0)
    to_bottom: flag(name="To the bottom", default=True)
    depth_to: number(name="To", description="Depth below the skin, in mm", default=2.0, min=0.0)


class LappetBone(bpy.types.PropertyGroup):
    """A bone: any closed mesh."""

    object: pointer(name="Bone", type=bpy.types.Object)


class LappetTissue(bpy.types.PropertyGroup):
    """The tissue: a mesh object and what it is made of.

    Groups of its faces are Boolean face attributes of the mesh named "lappet_" + group: "fixed", "bed", those that
    retractors grip and those of regions.
    """

    object: PointerProperty(
        name="Tissue", description="The mesh to operate on", type=bpy.types.Object, update=property_changed
    )
    thicken: BoolProperty(
        name="Thicken",
        description="The mesh is only the outer surface; the tissue is a sheet of this thickness below it",
        default=False,
        update=property_changed,
    )
    thickness: FloatProperty(
        name="Thickness", description="mm", default=4.0, min=0.001, soft_max=20.0, update=property_changed
    )
    material: StringProperty(name="Material", default="skin", update=property_changed)
    spacing: FloatProperty(
        name="Lattice spacing",
        description="Edge of a cell in mm: half the spacing takes about ten times as long",
        default=Tissue.spacing,
        min=1e-6,
        soft_min=0.2,
        soft_max=5.0,
        precision=3,
        update=property_changed,
    )
    bed_stiffness: FloatProperty(
        name="Bed",
        description="Stiffness along its normal, kPa/mm",
        default=Tissue.bed_stiffness,
        min=0.0,
        update=property_changed,
    )
    bed_shear: FloatProperty(
        name="Bed in shear",
        description="Stiffness in its plane, kPa/mm: at most that along its normal",
        default=Tissue.bed_shear,
        min=0.0,
        precision=4,
        update=property_changed,
    )
    use_gravity: BoolProperty(name="Gravity", default=True, update=property_changed)
    gravity: FloatProperty(name="Gravity", description="m/s²", default=Tissue.gravity, min=0.0, update=property_changed)
    position: EnumProperty(
        name="Position",
        description="How the patient lies: x runs to the patient's right, y to the front, z to the top of the head",
        items=(
            ("UPRIGHT", "Upright", "Seated or standing; a flat patch lies on its bed"),
            ("SUPINE", "Supine", "On the back"),
            ("PRONE", "Prone", "On the belly"),
            ("LEFT_LATERAL", "Left lateral", "On the left side"),
            ("RIGHT_LATERAL", "Right lateral", "On the right side"),
            ("CUSTOM", "Other", "In another direction"),
        ),
        default="UPRIGHT",
        update=property_changed,
    )
    gravity_direction: FloatVectorProperty(
        name="Direction",
        description="Direction in which gravity pulls",
        size=3,
        default=Tissue.gravity_direction,
        update=property_changed,
    )


class LappetSkinLine(bpy.types.PropertyGroup):
    """A line of the skin, along which its fibers run; `name` is that of its prim."""

    points: CollectionProperty(type=LappetPoint)
    basis: EnumProperty(name="Curve", items=BASES, update=property_changed)
    use_tension: BoolProperty(name="Tension", default=False, update=property_changed)
    tension: FloatVectorProperty(
        name="Tension",
        description="In vivo, along and across the line, kPa",
        size=2,
        default=(20.0, 10.0),
        min=0.0,
        update=property_changed,
    )


class LappetVessel(bpy.types.PropertyGroup):
    """A vessel or nerve in the tissue; `name` is that of its prim."""

    points: CollectionProperty(type=LappetPoint)
    basis: EnumProperty(name="Curve", items=BASES, update=property_changed)
    kind: choice(name="Kind", items=tuple((kind.upper(), kind.capitalize(), "") for kind in VESSEL_KINDS))
    radius: number(
        name="Radius", description="Outer radius, mm", default=Vessel.radius, min=0.01, soft_max=3.0, precision=2
    )
    label: text(name="Label", description="Name in pictures and reports; empty = the vessel's name")
    typical_course: flag(
        name="Typical course", description="The course is that of a textbook, not this patient's", default=False
    )


class LappetFlap(bpy.types.PropertyGroup):
    """A laid flap of the library; `name` is that of its prim, `value` the rest of it (laid_flaps.py)."""

    value: StringProperty(options={"HIDDEN"})


class LappetSolving(bpy.types.PropertyGroup):
    """How the procedure is solved."""

    quadrature: choice(
        name="Quadrature",
        items=(("1", "1 point", "The default"), ("4", "4 points", ""), ("8", "8 points", "The slowest")),
        default=str(SolverSettings.quadrature),
    )
    precision: choice(
        name="Precision",
        translation_context="Lappet",
        items=(("float", "Single", "The default"), ("double", "Double", "For reference")),
        default=SolverSettings.precision,
    )
    tolerance: number(
        name="Tolerance",
        description="Residual relative to the force scale below which a frame is at rest",
        default=SolverSettings.tolerance,
        min=1e-8,
        max=0.1,
        precision=6,
    )
    self_contact: flag(
        name="Self-contact",
        description="Keep tissue from passing through tissue. Takes longer, and frames may fail that solve without",
        default=Tissue.self_contact,
    )
    friction: FloatProperty(
        name="Friction",
        description="Coefficient of friction where tissue presses on tissue, with self-contact; 0 is none",
        default=SolverSettings.friction,
        min=0.0,
        soft_max=1.0,
        max=9.9,
        precision=2,
        update=property_changed,
    )
    error_estimate: BoolProperty(
        name="Estimate the Error",
        description="Solve once more on a lattice of twice the spacing, to tell how far the skin may be off and where",
        default=True,
        update=property_changed,
    )
    threads: IntProperty(name="Threads", description="0 = all", default=SolverSettings.threads, min=0, max=256)
    live: BoolProperty(name="Live", description="The skin follows while the target of a hook is dragged", default=False)
    beside_file: flag(
        name="Beside the .blend",
        description="Keep solved frames in a folder beside the .blend file instead of the user's cache",
        default=False,
    )
    when_opened: BoolProperty(
        name="Solve When Opened",
        description="Solve what is not solved yet when this file is opened, as the files of the gallery do",
        default=False,
    )
    last_plan: StringProperty(
        name="Last manifest", description="Key of the manifest shown when the file was saved", options={"HIDDEN"}
    )


class LappetLook(bpy.types.PropertyGroup):
    """How the solved skin is shown. The display side subscribes to changes by `update` of its own operators."""

    color: choice(name="Color", items=COLORS, default="GRID")
    show_solved: flag(
        name="Solved skin", description="Show the solved skin instead of the tissue at rest", default=True
    )
    show_walls: flag(name="Wound walls", default=True)
    show_bone: flag(name="Bone", default=True)
    show_sutures: flag(name="Sutures", default=True)
    show_hooks: flag(name="Hooks", default=True)
    show_landmarks: flag(name="Landmarks", default=True)
    show_vessels: flag(name="Vessels", default=True)
    show_through: flag(
        name="Through the skin", description="Make the skin translucent, so that vessels show through it", default=False
    )
    show_legend: flag(name="Legend", description="Show the color scale beside the skin, also in renders", default=True)
    show_lattice: flag(name="Lattice", description="The cells of the lattice over the tissue", default=False)
    show_plan: flag(name="Plan", description="Lines and points of the events on the skin", default=True)


class LappetProcedure(bpy.types.PropertyGroup):
    """The procedure of a scene. Copying the scene copies it; Blender's undo undoes it."""

    version: IntProperty(default=0, options={"HIDDEN"})  # 0: nothing was made yet
    tissue: PointerProperty(type=LappetTissue)
    bones: CollectionProperty(type=LappetBone)
    materials: CollectionProperty(type=LappetMaterial)
    active_material: IntProperty(default=0)
    regions: CollectionProperty(type=LappetRegion)
    skin_lines: CollectionProperty(type=LappetSkinLine)
    vessels: CollectionProperty(type=LappetVessel)
    active_region: IntProperty(default=0)
    events: CollectionProperty(type=LappetEvent)
    active_event: IntProperty(name="Event", default=-1)
    show_strips: BoolProperty(
        name="Strips", description="Show the events as strips over the Timeline and the Dope Sheet", default=True
    )
    flaps: CollectionProperty(type=LappetFlap)
    pages: CollectionProperty(type=LappetPlate)
    active_page: IntProperty(name="Plate")
    show_page: BoolProperty(
        name="Preview", description="Show the chosen panel's annotations in viewports", default=True
    )
    plates: StringProperty(options={"HIDDEN"})  # those of version 1 (plate_values.py)
    kept: StringProperty(options={"HIDDEN"})  # what there are no tools for (kept_values.py)
    solving: PointerProperty(type=LappetSolving)
    look: PointerProperty(type=LappetLook)
    skin: PointerProperty(name="Skin", description="The object that shows the solved skin", type=bpy.types.Object)
    compare_with: pointer(
        name="Compare with", description="Another scene whose procedure is shown beside this one", type=bpy.types.Scene
    )
    compare_gap: number(name="Gap", description="Between the two skins, mm", default=10.0, soft_min=0.0)


CLASSES = (
    LappetMaterial,
    LappetRegion,
    LappetSkinLine,
    LappetVessel,
    LappetFlap,
    LappetBone,
    LappetTissue,
    LappetSolving,
    LappetLook,
    LappetProcedure,
)
