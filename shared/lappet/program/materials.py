"""The materials of a procedure as the daemon is told them: the table, the regions, how active the muscles are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError
from lappet.cutting.epoch import Regions
from lappet.geometry.labelled_surface import FaceOrigin
from lappet.procedure import Material, Procedure
from lappet.program.settings import MaterialParameters
from lappet.tissue.surface import tissue_surface

_TISSUE = "/Procedure/Tissue"


def materials_in_use(procedure: Procedure) -> tuple[Material, ...]:
    """The tissue's material, then those of its regions, each once. Raises RefusedError for one that is not there."""
    known = {material.name for material in procedure.materials}
    users = [(_TISSUE, procedure.tissue.material)]
    users += [(f"{_TISSUE}/{region.faces}", region.material) for region in procedure.tissue.regions]
    for path, name in users:
        if name not in known:
            raise RefusedError(f"{path}: its material {name!r} is not under /Procedure/Materials; add it.")
    return procedure.materials_in_use()


def parameters(material: Material) -> MaterialParameters:
    """A material as the daemon is told it: what has no effect is as in any other, so that it changes no key."""
    fibres, plain = material.has_fibers, MaterialParameters()
    direction = np.asarray(material.fiber_direction, np.float64)
    x, y, z = (
        (float(v) for v in direction / np.linalg.norm(direction)) if material.has_direction else plain.fibre_direction
    )
    return MaterialParameters(
        model=material.model,
        youngs_modulus=float(material.youngs_modulus),
        poissons_ratio=float(material.poissons_ratio),
        density=float(material.density),
        mooney_ratio=float(material.mooney_ratio) if material.model == "mooneyRivlin" else plain.mooney_ratio,
        fibre_direction=(x, y, z),
        fibre_k1=float(material.fiber_k1),
        fibre_k2=float(material.fiber_k2) if fibres else plain.fibre_k2,
        fibre_dispersion=float(material.fiber_dispersion) if fibres else plain.fibre_dispersion,
        muscle_stress=float(material.muscle_stress),
        prestretch=material.prestretch,
    )


def activation(materials: Sequence[Material], time: float) -> NDArray[np.float64]:
    """How active each material's muscle is at a time code, (M,) in 0 to 1; (0,) where no material has any muscle."""
    if not any(material.has_muscle for material in materials):
        return np.zeros(0)
    return np.array([_activation(material, time) for material in materials])


def _activation(material: Material, time: float) -> float:
    if not material.has_muscle or not material.muscle_activation:
        return 0.0
    times, values = zip(*sorted(material.muscle_activation), strict=True)
    return float(np.interp(time, times, values))


def region_program(procedure: Procedure, materials: Sequence[Material]) -> Regions:
    """The regions of the tissue over the triangles of its uncut skin.

    Nothing for a tissue without regions whose materials have no direction: then the skin is not needed. materials: the
    table that the regions index. Raises RefusedError for a region whose face subset is not there.
    """
    tissue = procedure.tissue
    if not tissue.regions and not any(material.has_direction for material in materials):
        return Regions()
    surface = tissue_surface(tissue)
    skin = surface.origin == FaceOrigin.SKIN
    for region in tissue.regions:
        if region.faces not in surface.grips:
            raise RefusedError(
                f"{_TISSUE}/{region.faces}: a region needs a face subset of its own; name one of "
                f"{', '.join(surface.grips) or 'those that you add'}."
            )
    used, triangles = np.unique(surface.triangles[skin], return_inverse=True)
    names = [material.name for material in materials]
    return Regions(
        skin_points=surface.points[used],
        skin_triangles=triangles.reshape(-1, 3).astype(np.int32),
        faces=np.array([surface.grips[region.faces][skin] for region in tissue.regions], bool).reshape(-1, skin.sum()),
        material=np.array([names.index(region.material) for region in tissue.regions], np.int32),
        depth_from=np.array([region.depth_from for region in tissue.regions], np.float64),
        depth_to=np.array([region.depth_to for region in tissue.regions], np.float64),
    )
