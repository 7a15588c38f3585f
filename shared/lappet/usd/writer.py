"""A procedure as a USD layer: standard prims, Lappet's applied schemas, every value authored.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import RefusedError
from lappet.procedure import (
    Bone,
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Procedure,
    Region,
    Retractor,
    Suture,
    Tissue,
    Undermine,
)
from lappet.procedure.prim_names import name_problems
from lappet.procedure.prim_paths import BONE, MATERIALS, ROOT, TIMELINE, TISSUE

FAMILY = "lappet"
LINE_WIDTH = 0.4  # mm, how thick other viewers draw curves and points


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
        prim = _mesh(stage, usd, f"{BONE}/{bone.name}", bone)
        prim.AddAppliedSchema("LappetBoneAPI")
    usd.UsdGeom.Scope.Define(stage, MATERIALS)
    for material in procedure.materials:
        _material(stage, usd, material)
    usd.UsdGeom.Scope.Define(stage, TIMELINE)
    for event in procedure.events:
        _event(stage, usd, event)
    return fresh


def _tissue(stage: Any, usd: Any, tissue: Tissue) -> None:
    prim = _mesh(stage, usd, TISSUE, tissue)
    prim.AddAppliedSchema("LappetTissueAPI")
    if tissue.uv is not None:
        primvars = usd.UsdGeom.PrimvarsAPI(prim)
        kind = usd.Sdf.ValueTypeNames.TexCoord2fArray
        st = primvars.CreatePrimvar("st", kind, usd.UsdGeom.Tokens.faceVarying)
        st.Set(usd.Vt.Vec2fArray.FromNumpy(np.array(tissue.uv, np.float32)))
    values = _Values(prim, usd)
    if tissue.material:
        values.relate("material", f"{MATERIALS}/{tissue.material}")
    values.double("spacing", tissue.spacing)
    values.double("bedStiffness", tissue.bed_stiffness)
    if tissue.gravity is not None:
        values.double("gravity", tissue.gravity)
    regions = {region.faces: region for region in tissue.regions}
    for name, faces in tissue.subsets.items():
        subset = usd.UsdGeom.Subset.Define(stage, f"{TISSUE}/{name}")
        subset.CreateElementTypeAttr(usd.UsdGeom.Tokens.face)
        subset.CreateFamilyNameAttr(FAMILY)
        subset.CreateIndicesAttr(usd.Vt.IntArray.FromNumpy(np.array(faces, np.int32)))
        if name in regions:
            _region(subset.GetPrim(), usd, regions[name])
    if tissue.subsets:
        imageable = usd.UsdGeom.Imageable(prim)
        usd.UsdGeom.Subset.SetFamilyType(imageable, FAMILY, usd.UsdGeom.Tokens.unrestricted)


def _region(prim: Any, usd: Any, region: Region) -> None:
    prim.AddAppliedSchema("LappetRegionAPI")
    values = _Values(prim, usd)
    if region.material:
        values.relate("material", f"{MATERIALS}/{region.material}")
    values.double("depthFrom", region.depth_from)
    values.double("depthTo", region.depth_to)


def _material(stage: Any, usd: Any, material: Material) -> None:
    prim = usd.UsdShade.Material.Define(stage, f"{MATERIALS}/{material.name}").GetPrim()
    prim.AddAppliedSchema("LappetMaterialAPI")
    values = _Values(prim, usd)
    values.author("model", usd.Sdf.ValueTypeNames.Token, material.model)
    values.double("youngsModulus", material.youngs_modulus)
    values.double("poissonsRatio", material.poissons_ratio)
    values.double("mooneyRatio", material.mooney_ratio)
    values.double("fiber:k1", material.fiber_k1)
    values.double("fiber:k2", material.fiber_k2)
    values.double("fiber:dispersion", material.fiber_dispersion)
    values.author("fiber:direction", usd.Sdf.ValueTypeNames.Double3, usd.Gf.Vec3d(*material.fiber_direction))
    values.author("prestretch", usd.Sdf.ValueTypeNames.Double2, usd.Gf.Vec2d(*material.prestretch))
    values.double("density", material.density)
    values.double("muscleStress", material.muscle_stress)
    values.samples("muscleActivation", material.muscle_activation)


def _event(stage: Any, usd: Any, event: Event) -> None:
    path = f"{TIMELINE}/{event.name}"
    match event:
        case Incision():
            prim = _curve(stage, usd, path, event.points, event.basis, event.closed)
        case Undermine():
            prim = _curve(stage, usd, path, event.points, event.basis, True)
        case Suture():
            prim = _curve(stage, usd, path, event.anchors, "linear", False)
        case Excision():
            prim = _points(stage, usd, path, event.seeds)
        case Landmark():
            prim = _points(stage, usd, path, event.points)
        case Hook() | Retractor():
            prim = usd.UsdGeom.Xform.Define(stage, path).GetPrim()
    prim.AddAppliedSchema(f"Lappet{event.kind}API")
    values = _Values(prim, usd)
    match event:
        case Incision():
            values.time("time", event.time)
            values.author("through", usd.Sdf.ValueTypeNames.Bool, event.depth is None)
            values.double("depth", 0.0 if event.depth is None else event.depth)
            values.double("kerf", event.kerf)
        case Excision() | Undermine():
            values.time("time", event.time)
        case Hook():
            values.author("anchor", usd.Sdf.ValueTypeNames.Point3d, usd.Gf.Vec3d(*event.anchor))
            values.double("stiffness", event.stiffness)
            values.time("start", event.start)
            values.time("release", event.release)
            translate = usd.UsdGeom.Xformable(prim).AddTranslateOp(usd.UsdGeom.XformOp.PrecisionDouble)
            for time, target in event.targets:
                translate.Set(usd.Gf.Vec3d(*target), time)
        case Retractor():
            if event.grip:
                values.relate("grip", f"{TISSUE}/{event.grip}")
            values.time("start", event.start)
            values.time("release", event.release)
            transform = usd.UsdGeom.Xformable(prim).AddTransformOp(usd.UsdGeom.XformOp.PrecisionDouble)
            for time, matrix in event.motion:
                transform.Set(usd.Gf.Matrix4d(*matrix), time)
        case Suture():
            anchors = usd.Vt.Vec3dArray([usd.Gf.Vec3d(*anchor) for anchor in event.anchors])
            values.author("anchors", usd.Sdf.ValueTypeNames.Point3dArray, anchors)
            values.time("start", event.start)
            values.time("duration", event.duration)
            values.double("stiffness", event.stiffness)
        case Landmark():
            values.author("label", usd.Sdf.ValueTypeNames.String, event.label)


class _Values:
    """Author uniform attributes and relationships in the namespace `lappet:` of one prim."""

    def __init__(self, prim: Any, usd: Any) -> None:
        self._prim, self._usd = prim, usd

    def author(self, name: str, kind: Any, value: Any) -> None:
        uniform = self._usd.Sdf.VariabilityUniform
        self._prim.CreateAttribute(f"lappet:{name}", kind, custom=False, variability=uniform).Set(value)

    def double(self, name: str, value: float) -> None:
        self.author(name, self._usd.Sdf.ValueTypeNames.Double, float(value))

    def samples(self, name: str, samples: tuple[tuple[float, float], ...]) -> None:
        """A number that changes in time; nothing is authored without samples."""
        if samples:
            kind = self._usd.Sdf.ValueTypeNames.Double
            attribute = self._prim.CreateAttribute(f"lappet:{name}", kind, custom=False)
            for time, value in samples:
                attribute.Set(float(value), float(time))

    def time(self, name: str, value: float) -> None:
        # Not of the type timecode, of which .usda files keep only six digits.
        self.double(name, value)

    def relate(self, name: str, target: str) -> None:
        self._prim.CreateRelationship(f"lappet:{name}", custom=False).SetTargets([target])


def _mesh(stage: Any, usd: Any, path: str, mesh: Tissue | Bone) -> Any:
    prim = usd.UsdGeom.Mesh.Define(stage, path)
    prim.CreatePointsAttr(_vectors(usd, mesh.points))
    prim.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.array(mesh.face_vertex_counts, np.int32)))
    prim.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(np.array(mesh.face_vertex_indices, np.int32)))
    prim.CreateSubdivisionSchemeAttr(usd.UsdGeom.Tokens.none)
    _extent(usd, prim, mesh.points, 0.0)
    return prim.GetPrim()


def _curve(stage: Any, usd: Any, path: str, points: ArrayLike, basis: str, closed: bool) -> Any:
    tokens = usd.UsdGeom.Tokens
    prim = usd.UsdGeom.BasisCurves.Define(stage, path)
    vectors = _vectors(usd, points)
    prim.CreatePointsAttr(vectors)
    prim.CreateCurveVertexCountsAttr(usd.Vt.IntArray([len(vectors)]))
    prim.CreateTypeAttr(tokens.linear if basis == "linear" else tokens.cubic)
    if basis != "linear":
        prim.CreateBasisAttr(basis)
    prim.CreateWrapAttr(tokens.periodic if closed else tokens.nonperiodic)
    _widths(usd, prim)
    _extent(usd, prim, points, LINE_WIDTH / 2)
    return prim.GetPrim()


def _points(stage: Any, usd: Any, path: str, points: ArrayLike) -> Any:
    prim = usd.UsdGeom.Points.Define(stage, path)
    prim.CreatePointsAttr(_vectors(usd, points))
    _widths(usd, prim)
    _extent(usd, prim, points, LINE_WIDTH / 2)
    return prim.GetPrim()


def _widths(usd: Any, prim: Any) -> None:
    prim.CreateWidthsAttr(usd.Vt.FloatArray([LINE_WIDTH]))
    prim.SetWidthsInterpolation(usd.UsdGeom.Tokens.constant)


def _vectors(usd: Any, points: ArrayLike) -> Any:
    return usd.Vt.Vec3fArray.FromNumpy(np.array(points, np.float32).reshape(-1, 3))


def _extent(usd: Any, prim: Any, points: ArrayLike, margin: float) -> None:
    array = np.asarray(points, np.float32).reshape(-1, 3)
    if len(array):
        prim.CreateExtentAttr(_vectors(usd, [array.min(axis=0) - margin, array.max(axis=0) + margin]))
