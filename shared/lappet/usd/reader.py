"""A USD stage as a procedure: what carries Lappet's schemas, wherever it stands on the stage.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself. Only authored values count, so
a stage reads the same whether or not the schemas were registered in time.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    SCENERY_KINDS,
    Bone,
    Material,
    Point,
    Procedure,
    Region,
    Roller,
    Scenery,
    SkinLine,
    Tissue,
    Vessel,
    VesselKind,
)
from lappet.usd.event_prims import EVENT_PRIMS, read_curve, read_event
from lappet.usd.flap_prims import read_flap
from lappet.usd.muscle_prims import read_muscle
from lappet.usd.plate_prims import read_plates
from lappet.usd.values import Reader

PRIM_TYPES = {
    "LappetTissueAPI": "Mesh",
    "LappetRegionAPI": "GeomSubset",
    "LappetRollerAPI": "GeomSubset",
    "LappetBoneAPI": "Mesh",
    "LappetMaterialAPI": None,
    "LappetSkinLineAPI": "BasisCurves",
    "LappetVesselAPI": "BasisCurves",
    "LappetMuscleAPI": "BasisCurves",
    "LappetSceneryAPI": "Mesh",
    "LappetFlapAPI": "Scope",
    "LappetPlateAPI": "Scope",
    "LappetPanelAPI": "Scope",
    "LappetAnnotationAPI": "Points",
    **EVENT_PRIMS,
}


def read_what_can_be(stage: Any, usd: Any, notes: list[Problem]) -> tuple[Procedure | None, list[Problem]]:
    """Read the procedure on an open stage as far as possible.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    notes
        Gets a note of what was converted or left aside.

    Returns
    -------
    tuple[Procedure | None, list[Problem]]
        The procedure, or None without a tissue, and every problem that kept something from being read. A value that
        could not be read is NaN or empty in the procedure.
    """
    reader = Reader(stage, usd, notes)
    found = _find(reader)
    tissues = found["LappetTissueAPI"]
    if len(tissues) != 1:
        paths = ", ".join(str(prim.GetPath()) for prim in tissues) or "none"
        reader.problem(ProblemCode.STAGE_TISSUES, "/Procedure/Tissue", paths, count=len(tissues) or "no")
    tissue = _tissue(reader, tissues[0], found["LappetRegionAPI"], found["LappetRollerAPI"]) if tissues else None
    materials = tuple(_material(reader, prim) for prim in found["LappetMaterialAPI"])
    bones = tuple(_bone(reader, prim) for prim in found["LappetBoneAPI"])
    events = tuple(read_event(reader, prim, schema, tissues) for prim, schema in found["events"])
    start, end = float(stage.GetStartTimeCode()), float(stage.GetEndTimeCode())
    if not stage.HasAuthoredTimeCodeRange():
        reader.problem(ProblemCode.STAGE_NO_TIME_CODES, "/Procedure", "no value")
        start, end = -np.inf, np.inf
    if tissue is None:
        return None, reader.problems
    procedure = Procedure(
        tissue=tissue,
        materials=materials,
        events=events,
        bones=bones,
        skin_lines=tuple(_skin_line(reader, prim) for prim in found["LappetSkinLineAPI"]),
        vessels=tuple(_vessel(reader, prim) for prim in found["LappetVesselAPI"]),
        scenery=tuple(_scenery(reader, prim) for prim in found["LappetSceneryAPI"]),
        flaps=tuple(read_flap(reader, prim) for prim in found["LappetFlapAPI"]),
        plates=read_plates(reader, *(found[f"Lappet{each}API"] for each in ("Plate", "Panel", "Annotation"))),
        muscles=tuple(read_muscle(reader, prim) for prim in found["LappetMuscleAPI"]),
        start_time=start,
        end_time=end,
        fps=float(stage.GetTimeCodesPerSecond()),
    )
    return procedure, reader.problems


def _find(reader: Reader) -> dict[str, list[Any]]:
    """The prims by schema; "events" holds (prim, schema) of all kinds in the order of the stage."""
    found: dict[str, list[Any]] = {"LappetTissueAPI": [], "LappetMaterialAPI": [], "LappetBoneAPI": []}
    found |= {"LappetSkinLineAPI": [], "LappetVesselAPI": [], "LappetSceneryAPI": [], "LappetMuscleAPI": []}
    found |= {"LappetRegionAPI": [], "LappetRollerAPI": [], "LappetFlapAPI": [], "events": []}
    found |= {"LappetPlateAPI": [], "LappetPanelAPI": [], "LappetAnnotationAPI": []}
    for prim in reader.stage.Traverse():
        schemas = [str(s) for s in prim.GetPrimTypeInfo().GetAppliedAPISchemas() if str(s).startswith("Lappet")]
        for schema in schemas:
            if schema not in PRIM_TYPES:
                reader.problem(ProblemCode.SCHEMA_UNKNOWN, prim.GetPath(), schema)
        schemas = [schema for schema in schemas if schema in PRIM_TYPES]
        if len(schemas) > 1:
            code = ProblemCode.SCHEMA_SEVERAL
            reader.problem(code, prim.GetPath(), ", ".join(schemas), count=len(schemas))
        for schema in schemas[:1]:
            wanted, kind = PRIM_TYPES[schema], str(prim.GetTypeName())
            if wanted is not None and kind != wanted:
                shown = kind or "prim without a type"
                code = ProblemCode.SCHEMA_PRIM_TYPE
                reader.problem(code, prim.GetPath(), kind, schema=schema, kind=shown, wanted=wanted)
            elif schema in found:
                found[schema].append(prim)
            else:
                found["events"].append((prim, schema))
    return found


def _tissue(reader: Reader, prim: Any, regions: list[Any], rollers: list[Any]) -> Tissue:
    points, counts, indices, corners = _mesh(reader, prim)
    subsets: dict[str, NDArray[np.int32]] = {}
    for subset in reader.usd.UsdGeom.Subset.GetGeomSubsets(reader.usd.UsdGeom.Imageable(prim), "", "lappet"):
        child = subset.GetPrim()
        element = str(subset.GetElementTypeAttr().Get())
        if element != "face":
            reader.problem(ProblemCode.SUBSET_ELEMENT, child.GetPath(), element, name=child.GetName())
            continue
        subsets[child.GetName()] = reader.integers(child, "indices")
    material = reader.target(prim, "lappet:material")
    if not material:
        reader.problem(ProblemCode.TISSUE_NO_MATERIAL, prim.GetPath(), "no material")
    normal = reader.number(prim, "lappet:bedStiffness", Tissue.bed_stiffness)
    return Tissue(
        points=points,
        face_vertex_counts=counts,
        face_vertex_indices=indices,
        uv=_uv(reader, prim, indices, corners),
        subsets=subsets,
        material=material.rpartition("/")[2],
        spacing=reader.number(prim, "lappet:spacing", Tissue.spacing),
        gravity=reader.number(prim, "lappet:gravity", Tissue.gravity),
        gravity_direction=cast(Point, reader.vector(prim, "lappet:gravityDirection", 3, Tissue.gravity_direction)),
        bed_stiffness=normal,
        bed_shear=reader.number(prim, "lappet:bedShear", min(Tissue.bed_shear, normal)),
        self_contact=reader.flag(prim, "lappet:selfContact", Tissue.self_contact),
        regions=tuple(_region(reader, region, prim, subsets) for region in regions),
        rollers=tuple(_roller(reader, roller, prim, subsets) for roller in rollers),
    )


def _roller(reader: Reader, prim: Any, tissue: Any, subsets: dict[str, NDArray[np.int32]]) -> Roller:
    name = prim.GetName()
    if prim.GetParent() != tissue or name not in subsets:
        reader.problem(ProblemCode.ROLLER_NOT_A_SUBSET, prim.GetPath(), name, tissue=tissue.GetPath())
    normal = reader.vector(prim, "lappet:normal", 3, (0.0, 0.0, 0.0))
    return Roller(name, cast(Point, normal) if any(normal) else None)


def _region(reader: Reader, prim: Any, tissue: Any, subsets: dict[str, NDArray[np.int32]]) -> Region:
    name = prim.GetName()
    if prim.GetParent() != tissue or name not in subsets:
        reader.problem(ProblemCode.REGION_NOT_A_SUBSET, prim.GetPath(), name, tissue=tissue.GetPath())
    material = reader.target(prim, "lappet:material")
    if not material:
        reader.problem(ProblemCode.REGION_NO_MATERIAL, prim.GetPath(), "no material")
    return Region(
        name,
        material.rpartition("/")[2],
        reader.number(prim, "lappet:depthFrom", Region.depth_from),
        reader.number(prim, "lappet:depthTo", Region.depth_to),
    )


def _mesh(
    reader: Reader, prim: Any
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32], NDArray[np.intp]]:
    """Points, counts, indices, and for each corner which corner of the file it is (left-handed faces are turned)."""
    points = reader.points(prim)
    counts, indices = reader.integers(prim, "faceVertexCounts"), reader.integers(prim, "faceVertexIndices")
    corners = np.arange(len(indices))
    matrix = reader.space.to_rest(prim)
    mirrored = matrix is not None and np.linalg.det(matrix[:3, :3]) < 0.0
    left = str(prim.GetAttribute("orientation").Get() or "rightHanded") == "leftHanded"
    if left != mirrored and (counts > 0).all() and counts.sum() == len(indices):
        starts = np.repeat(np.cumsum(counts) - counts, counts)
        corners = 2 * starts + np.repeat(counts, counts) - 1 - corners
        reader.notes.append(problem(ProblemCode.FACES_TURNED, prim.GetPath(), "leftHanded"))
    if len(reader.integers(prim, "holeIndices", optional=True)):
        reader.notes.append(problem(ProblemCode.HOLES_IGNORED, prim.GetPath(), "holeIndices"))
    scheme = prim.GetAttribute("subdivisionScheme").Get()
    if scheme not in (None, "none"):
        reader.notes.append(problem(ProblemCode.SUBDIVISION_IGNORED, prim.GetPath(), scheme))
    return points, counts, indices[corners] if len(indices) else indices, corners


def _uv(reader: Reader, prim: Any, indices: NDArray[np.int32], corners: NDArray[np.intp]) -> NDArray[np.float32] | None:
    primvar = reader.usd.UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    if not primvar or not primvar.HasValue():
        return None
    interpolation = str(primvar.GetInterpolation())
    values = np.array(primvar.ComputeFlattened(reader.usd.Usd.TimeCode.EarliestTime()), np.float32)
    if values.ndim == 2 and values.shape[1] == 2:
        if interpolation == "faceVarying" and len(values) == len(corners):
            return values[corners]
        if (
            interpolation in ("vertex", "varying")
            and len(indices)
            and 0 <= indices.min() <= indices.max() < len(values)
        ):
            return values[indices]
    code = ProblemCode.PRIMVAR_COUNT
    reader.problem(code, prim.GetPath(), len(values), interpolation=interpolation, corners=len(corners))
    return None


def _bone(reader: Reader, prim: Any) -> Bone:
    points, counts, indices, _ = _mesh(reader, prim)
    start = float(reader.stage.GetStartTimeCode())
    samples = reader.space.motion(prim, start)
    rest = reader.space.motion_at(prim, start)
    motion: tuple[tuple[float, tuple[float, ...]], ...] = ()
    if any(not np.array_equal(matrix, rest) for _, matrix in samples) and abs(np.linalg.det(rest)) > 0.0:
        back = np.eye(4) if np.array_equal(rest, np.eye(4)) else np.linalg.inv(rest)
        motion = tuple((time, tuple((back @ matrix).ravel())) for time, matrix in samples)
    return Bone(prim.GetName(), points, counts, indices, motion)


def _scenery(reader: Reader, prim: Any) -> Scenery:
    points, counts, indices, _ = _mesh(reader, prim)
    kind = reader.text(prim, "lappet:kind", Scenery.kind)
    if kind not in SCENERY_KINDS:
        known = ", ".join(SCENERY_KINDS)
        reader.problem(ProblemCode.SCENERY_KIND, prim.GetPath(), kind, known=known)
        kind = Scenery.kind
    return Scenery(prim.GetName(), points, counts, indices, kind)


def _skin_line(reader: Reader, prim: Any) -> SkinLine:
    points, basis, closed = read_curve(reader, prim)
    if closed:
        points = (*points, points[0])
    along, across = reader.vector(prim, "lappet:tension", 2, (np.inf, np.inf))
    tension = None if np.isposinf(along) and np.isposinf(across) else (along, across)
    return SkinLine(prim.GetName(), points, tension, basis)


def _vessel(reader: Reader, prim: Any) -> Vessel:
    points, basis, closed = read_curve(reader, prim)
    if closed:
        points = (*points, points[0])
    return Vessel(
        prim.GetName(),
        points,
        cast(VesselKind, reader.text(prim, "lappet:kind", Vessel.kind)),
        reader.number(prim, "lappet:radius", Vessel.radius),
        reader.text(prim, "lappet:label", ""),
        reader.flag(prim, "lappet:typicalCourse", Vessel.typical_course),
        basis,
    )


def _material(reader: Reader, prim: Any) -> Material:
    def number(name: str, default: float) -> float:
        return reader.number(prim, f"lappet:{name}", default)

    along, across = reader.vector(prim, "lappet:prestretch", 2, Material.prestretch)
    return Material(
        name=prim.GetName(),
        model=reader.text(prim, "lappet:model", Material.model),
        youngs_modulus=number("youngsModulus", Material.youngs_modulus),
        poissons_ratio=number("poissonsRatio", Material.poissons_ratio),
        mooney_ratio=number("mooneyRatio", Material.mooney_ratio),
        fiber_k1=number("fiber:k1", Material.fiber_k1),
        fiber_k2=number("fiber:k2", Material.fiber_k2),
        fiber_dispersion=number("fiber:dispersion", Material.fiber_dispersion),
        fiber_slack=number("fiber:slack", Material.fiber_slack),
        fiber_angle=number("fiber:angle", Material.fiber_angle),
        fiber_direction=cast(Point, reader.vector(prim, "lappet:fiber:direction", 3, Material.fiber_direction)),
        prestretch=(along, across),
        density=number("density", Material.density),
        muscle_stress=number("muscleStress", Material.muscle_stress),
        muscle_activation=reader.samples(prim, "lappet:muscleActivation"),
    )
