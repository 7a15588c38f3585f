"""A procedure as a USD layer: standard prims, Lappet's applied schemas, every value authored.

Values that Lappet 0.1 did not know are authored where they are not the default, so that files stay as it reads them.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lappet.core.problem import RefusedError
from lappet.procedure import Material, Procedure, Region, Roller, SkinLine, Tissue, Vessel
from lappet.procedure.prim_names import name_problems
from lappet.procedure.prim_paths import (
    ANATOMY,
    BONE,
    FLAPS,
    MATERIALS,
    MUSCLES,
    PLATES,
    ROOT,
    SCENERY,
    SKIN_LINES,
    TIMELINE,
    TISSUE,
)
from lappet.procedure.vessel import VESSEL_COLORS
from lappet.usd.authoring import Values, curve_prim, mesh_prim
from lappet.usd.event_prims import write_event
from lappet.usd.flap_prims import write_flap
from lappet.usd.muscle_prims import write_muscle
from lappet.usd.plate_prims import write_plate

FAMILY = "lappet"


def layer(procedure: Procedure, usd: Any) -> Any:
    """Make an anonymous layer that holds a procedure.

    Parameters
    ----------
    procedure
        The procedure.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.

    Returns
    -------
    Any
        The layer.

    Raises
    ------
    RefusedError
        If a name cannot be the name of a prim or is used twice.
    """
    problems = name_problems(procedure)
    if problems:
        raise RefusedError(problems)
    fresh = usd.Sdf.Layer.CreateAnonymous(".usda")  # the layer outlives the stage
    stage = usd.Usd.Stage.Open(fresh)
    stage.SetMetadata("metersPerUnit", 0.001)
    stage.SetMetadata("upAxis", "Z")
    stage.SetStartTimeCode(float(procedure.start_time))
    stage.SetEndTimeCode(float(procedure.end_time))
    stage.SetTimeCodesPerSecond(float(procedure.fps))
    stage.SetFramesPerSecond(float(procedure.fps))
    stage.SetDefaultPrim(usd.UsdGeom.Xform.Define(stage, ROOT).GetPrim())
    _tissue(stage, usd, procedure.tissue)
    if procedure.bones:
        usd.UsdGeom.Scope.Define(stage, BONE)
    for bone in procedure.bones:
        prim = mesh_prim(stage, usd, f"{BONE}/{bone.name}", bone)
        prim.AddAppliedSchema("LappetBoneAPI")
        if bone.motion:
            transform = usd.UsdGeom.Xformable(prim).AddTransformOp(usd.UsdGeom.XformOp.PrecisionDouble)
            for time, matrix in bone.motion:
                transform.Set(usd.Gf.Matrix4d(*matrix), time)
    usd.UsdGeom.Scope.Define(stage, MATERIALS)
    for material in procedure.materials:
        _material(stage, usd, material)
    if procedure.skin_lines:
        usd.UsdGeom.Scope.Define(stage, SKIN_LINES)
    for line in procedure.skin_lines:
        _skin_line(stage, usd, line)
    if procedure.vessels:
        usd.UsdGeom.Scope.Define(stage, ANATOMY)
    for vessel in procedure.vessels:
        _vessel(stage, usd, vessel)
    if procedure.muscles:
        usd.UsdGeom.Scope.Define(stage, MUSCLES)
    for muscle in procedure.muscles:
        write_muscle(stage, usd, muscle)
    if procedure.scenery:
        usd.UsdGeom.Scope.Define(stage, SCENERY)
    for each in procedure.scenery:
        prim = mesh_prim(stage, usd, f"{SCENERY}/{each.name}", each)
        prim.AddAppliedSchema("LappetSceneryAPI")
        Values(prim, usd).author("kind", usd.Sdf.ValueTypeNames.Token, each.kind)
    usd.UsdGeom.Scope.Define(stage, TIMELINE)
    for event in procedure.events:
        write_event(stage, usd, event)
    if procedure.flaps:
        usd.UsdGeom.Scope.Define(stage, FLAPS)
    for flap in procedure.flaps:
        write_flap(stage, usd, flap)
    if procedure.plates:
        usd.UsdGeom.Scope.Define(stage, PLATES)
    for plate in procedure.plates:
        write_plate(stage, usd, plate)
    return fresh


def _tissue(stage: Any, usd: Any, tissue: Tissue) -> None:
    prim = mesh_prim(stage, usd, TISSUE, tissue)
    prim.AddAppliedSchema("LappetTissueAPI")
    if tissue.uv is not None:
        primvars = usd.UsdGeom.PrimvarsAPI(prim)
        kind = usd.Sdf.ValueTypeNames.TexCoord2fArray
        st = primvars.CreatePrimvar("st", kind, usd.UsdGeom.Tokens.faceVarying)
        st.Set(usd.Vt.Vec2fArray.FromNumpy(np.array(tissue.uv, np.float32)))
    values = Values(prim, usd)
    if tissue.material:
        values.relate("material", f"{MATERIALS}/{tissue.material}")
    values.double("spacing", tissue.spacing)
    values.double("bedStiffness", tissue.bed_stiffness)
    if tissue.bed_shear != min(Tissue.bed_shear, tissue.bed_stiffness):
        values.double("bedShear", tissue.bed_shear)
    if tissue.self_contact:
        values.author("selfContact", usd.Sdf.ValueTypeNames.Bool, True)
    values.double("gravity", tissue.gravity)
    if tissue.gravity_direction != Tissue.gravity_direction:
        values.author("gravityDirection", usd.Sdf.ValueTypeNames.Double3, usd.Gf.Vec3d(*tissue.gravity_direction))
    regions = {region.faces: region for region in tissue.regions}
    rollers = {roller.faces: roller for roller in tissue.rollers}
    for name, faces in tissue.subsets.items():
        subset = usd.UsdGeom.Subset.Define(stage, f"{TISSUE}/{name}")
        subset.CreateElementTypeAttr(usd.UsdGeom.Tokens.face)
        subset.CreateFamilyNameAttr(FAMILY)
        subset.CreateIndicesAttr(usd.Vt.IntArray.FromNumpy(np.array(faces, np.int32)))
        if name in regions:
            _region(subset.GetPrim(), usd, regions[name])
        if name in rollers:
            _roller(subset.GetPrim(), usd, rollers[name])
    if tissue.subsets:
        imageable = usd.UsdGeom.Imageable(prim)
        usd.UsdGeom.Subset.SetFamilyType(imageable, FAMILY, usd.UsdGeom.Tokens.unrestricted)


def _region(prim: Any, usd: Any, region: Region) -> None:
    prim.AddAppliedSchema("LappetRegionAPI")
    values = Values(prim, usd)
    if region.material:
        values.relate("material", f"{MATERIALS}/{region.material}")
    values.double("depthFrom", region.depth_from)
    values.double("depthTo", region.depth_to)


def _roller(prim: Any, usd: Any, roller: Roller) -> None:
    prim.AddAppliedSchema("LappetRollerAPI")
    if roller.normal is not None:
        Values(prim, usd).author("normal", usd.Sdf.ValueTypeNames.Double3, usd.Gf.Vec3d(*roller.normal))


def _skin_line(stage: Any, usd: Any, line: SkinLine) -> None:
    prim = curve_prim(stage, usd, f"{SKIN_LINES}/{line.name}", line.points, line.basis, False)
    prim.AddAppliedSchema("LappetSkinLineAPI")
    if line.tension is not None:
        Values(prim, usd).author("tension", usd.Sdf.ValueTypeNames.Double2, usd.Gf.Vec2d(*line.tension))


def _vessel(stage: Any, usd: Any, vessel: Vessel) -> None:
    prim = curve_prim(stage, usd, f"{ANATOMY}/{vessel.name}", vessel.points, vessel.basis, False)
    curves = usd.UsdGeom.BasisCurves(prim)
    curves.GetWidthsAttr().Set(usd.Vt.FloatArray([2.0 * vessel.radius]))
    curves.CreateDisplayColorAttr([usd.Gf.Vec3f(*VESSEL_COLORS.get(vessel.kind, VESSEL_COLORS["nerve"]))])
    prim.AddAppliedSchema("LappetVesselAPI")
    values = Values(prim, usd)
    values.author("kind", usd.Sdf.ValueTypeNames.Token, vessel.kind)
    values.double("radius", vessel.radius)
    values.author("label", usd.Sdf.ValueTypeNames.String, vessel.label)
    values.author("typicalCourse", usd.Sdf.ValueTypeNames.Bool, vessel.typical_course)


def _material(stage: Any, usd: Any, material: Material) -> None:
    prim = usd.UsdShade.Material.Define(stage, f"{MATERIALS}/{material.name}").GetPrim()
    prim.AddAppliedSchema("LappetMaterialAPI")
    values = Values(prim, usd)
    values.author("model", usd.Sdf.ValueTypeNames.Token, material.model)
    values.double("youngsModulus", material.youngs_modulus)
    values.double("poissonsRatio", material.poissons_ratio)
    values.double("mooneyRatio", material.mooney_ratio)
    values.double("fiber:k1", material.fiber_k1)
    values.double("fiber:k2", material.fiber_k2)
    values.double("fiber:dispersion", material.fiber_dispersion)
    if material.fiber_slack != Material.fiber_slack:
        values.double("fiber:slack", material.fiber_slack)
    if material.fiber_angle != Material.fiber_angle:
        values.double("fiber:angle", material.fiber_angle)
    values.author("fiber:direction", usd.Sdf.ValueTypeNames.Double3, usd.Gf.Vec3d(*material.fiber_direction))
    values.author("prestretch", usd.Sdf.ValueTypeNames.Double2, usd.Gf.Vec2d(*material.prestretch))
    values.double("density", material.density)
    values.double("muscleStress", material.muscle_stress)
    values.samples("muscleActivation", material.muscle_activation)
