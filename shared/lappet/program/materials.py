"""The materials of a procedure as the daemon is told them: the table, the regions, how active the muscles are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Regions
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.geometry.normals import vertex_normals
from lappet.procedure import Material, Procedure
from lappet.procedure.prim_paths import MATERIALS, MUSCLES, TISSUE
from lappet.program.settings import MaterialParameters
from lappet.tissue.skin_lines import line_stretch, skin_field
from lappet.tissue.surface import tissue_surface


def materials_in_use(procedure: Procedure) -> tuple[Material, ...]:
    """List the tissue's material, then those of its regions and muscles.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    tuple[Material, ...]
        Each material once.

    Raises
    ------
    RefusedError
        If one is not there.
    """
    known = [material.name for material in procedure.materials]
    users = [(TISSUE, procedure.tissue.material)]
    users += [(f"{TISSUE}/{region.faces}", region.material) for region in procedure.tissue.regions]
    users += [(f"{MUSCLES}/{muscle.name}", muscle.material) for muscle in procedure.muscles]
    for path, name in users:
        code = ProblemCode.TISSUE_MATERIAL_UNKNOWN if path == TISSUE else ProblemCode.REGION_MATERIAL_UNKNOWN
        if path.startswith(MUSCLES):
            code = ProblemCode.MUSCLE_MATERIAL_UNKNOWN
        if name not in known:
            raise refused(code, path, name, materials=MATERIALS, known=", ".join(known) or "none")
    return procedure.materials_in_use()


def parameters(material: Material) -> MaterialParameters:
    """Translate a material for the daemon; what has no effect is as in any other material, so that it changes no key.

    Parameters
    ----------
    material
        The material.

    Returns
    -------
    MaterialParameters
        Its parameters.
    """
    fibers, plain = material.has_fibers, MaterialParameters()
    direction = np.asarray(material.fiber_direction, np.float64)
    x, y, z = (
        (float(v) for v in direction / np.linalg.norm(direction)) if material.has_direction else plain.fiber_direction
    )
    return MaterialParameters(
        model=material.model,
        youngs_modulus=float(material.youngs_modulus),
        poissons_ratio=float(material.poissons_ratio),
        density=float(material.density),
        mooney_ratio=float(material.mooney_ratio) if material.model == "mooneyRivlin" else plain.mooney_ratio,
        fiber_direction=(x, y, z),
        fiber_k1=float(material.fiber_k1),
        fiber_k2=float(material.fiber_k2) if fibers else plain.fiber_k2,
        fiber_dispersion=float(material.fiber_dispersion) if fibers else plain.fiber_dispersion,
        fiber_slack=float(material.fiber_slack) if fibers else plain.fiber_slack,
        fiber_angle=float(material.fiber_angle) if fibers or material.has_muscle else plain.fiber_angle,
        muscle_stress=float(material.muscle_stress),
        prestretch=material.prestretch,
    )


def activation(materials: Sequence[Material], time: float) -> NDArray[np.float64]:
    """Compute how active each material's muscle is.

    Parameters
    ----------
    materials
        The materials.
    time
        Time code.

    Returns
    -------
    NDArray[np.float64]
        Activation from 0 to 1, shape (M,); shape (0,) where no material has any muscle.
    """
    if not any(material.has_muscle for material in materials):
        return np.zeros(0)
    return np.array([_activation(material, time) for material in materials])


def _activation(material: Material, time: float) -> float:
    if not material.has_muscle or not material.muscle_activation:
        return 0.0
    times, values = zip(*sorted(material.muscle_activation), strict=True)
    return float(np.interp(time, times, values))


def region_program(procedure: Procedure, materials: Sequence[Material]) -> Regions:
    """Lay the regions of the tissue over the triangles of its uncut skin.

    Parameters
    ----------
    procedure
        The procedure.
    materials
        The table of materials that the regions index.

    Returns
    -------
    Regions
        The regions; nothing for a tissue without regions whose materials have no direction, where the skin is not
        needed.

    Raises
    ------
    RefusedError
        If a region's face subset is not there.
    """
    tissue = procedure.tissue
    along_skin = {tissue.material, *(region.material for region in tissue.regions)}  # muscles have their own courses
    if not tissue.regions and not any(m.has_direction for m in materials if m.name in along_skin):
        return Regions()
    surface = tissue_surface(tissue)
    skin = surface.origin == FaceOrigin.SKIN
    for region in tissue.regions:
        if region.faces not in surface.grips:
            known = ", ".join(surface.grips) or "none"
            raise refused(ProblemCode.REGION_NO_SUBSET, f"{TISSUE}/{region.faces}", repr(region.faces), known=known)
    used, triangles = np.unique(surface.triangles[skin], return_inverse=True)
    triangles = triangles.reshape(-1, 3).astype(np.int32)
    names = [material.name for material in materials]
    return Regions(
        skin_points=surface.points[used],
        skin_triangles=triangles,
        faces=np.array([surface.grips[region.faces][skin] for region in tissue.regions], bool).reshape(-1, skin.sum()),
        material=np.array([names.index(region.material) for region in tissue.regions], np.int32),
        depth_from=np.array([region.depth_from for region in tissue.regions], np.float64),
        depth_to=np.array([region.depth_to for region in tissue.regions], np.float64),
        **_skin_field(procedure, surface.points[used], triangles),
    )


def _skin_field(
    procedure: Procedure, points: NDArray[np.float64], triangles: NDArray[np.int32]
) -> dict[str, NDArray[np.float64]]:
    """What the lines of the skin say, as fields of `Regions`; nothing without lines."""
    if not procedure.skin_lines:
        return {}
    material = procedure.material(procedure.tissue.material)
    found = skin_field(procedure.skin_lines, points, vertex_normals(points, triangles), material)
    fields = {"skin_directions": found.directions}
    if any(line.tension is not None for line in procedure.skin_lines):
        fields["skin_stretch"] = found.stretch
    return fields


def with_line_tension(procedure: Procedure, materials: Sequence[Material]) -> tuple[Material, ...]:
    """Give the tissue's material the mean prestretch of the skin's lines, so that it counts as stretched in vivo.

    Parameters
    ----------
    procedure
        The procedure.
    materials
        Its materials in use.

    Returns
    -------
    tuple[Material, ...]
        The materials; as they are where no line has a tension.
    """
    lines = procedure.skin_lines
    if not any(line.tension is not None for line in lines):
        return tuple(materials)
    skin = procedure.material(procedure.tissue.material)
    along, across = np.mean([line_stretch(line, skin) for line in lines], axis=0)
    stretched = replace(skin, prestretch=(float(along), float(across)))
    return tuple(stretched if material.name == skin.name else material for material in materials)
