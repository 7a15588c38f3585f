"""Epochs: the stretches of the timeline with constant topology, each with its cut surface at rest."""

from __future__ import annotations

from itertools import groupby

import manifold3d
import numpy as np

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch, Removed
from lappet.cutting.incision import cut, fragments, tidy
from lappet.cutting.thinning import thin
from lappet.cutting.undermining import undermine
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import Surface
from lappet.geometry.mesh_faults import CLOSED, mesh_faults
from lappet.geometry.solid import LabeledSolid
from lappet.geometry.surface_check import place
from lappet.procedure import CUTS, Excision, Incision, Procedure, Thin, Undermine
from lappet.tissue.rest_skin import RestSkin
from lappet.tissue.surface import tissue_surface

_TISSUE = "/Procedure/Tissue"
_TIMELINE = "/Procedure/Timeline"


def build_epochs(procedure: Procedure) -> list[Epoch]:
    """Cut the tissue: make the epochs of a procedure, each surface from the one before.

    Incisions, excisions, thinning and undermining at one time make one epoch, in this order; those at or before the
    start time belong to epoch 0. Edges are refined to 1.5 lattice spacings. The same procedure gives the same bytes.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[Epoch]
        The epochs; every surface is closed, manifold and oriented outwards.

    Raises
    ------
    RefusedError
        If the tissue is no closed surface, or an event cannot act on it.
    """
    spacing = procedure.tissue.spacing
    surface = tissue_surface(procedure.tissue, _TISSUE)
    rest = LabeledSolid.from_surface(surface)
    skin = RestSkin(surface, rest.solid)
    rest = tissue = tidy(rest, spacing, 0.0)
    epochs = []

    topological = [e for e in procedure.events if isinstance(e, CUTS)]
    begin = [e for e in topological if e.time <= procedure.start_time]
    later = sorted((e for e in topological if e.time > procedure.start_time), key=lambda e: e.time)
    steps = [(procedure.start_time, begin), *((time, list(es)) for time, es in groupby(later, lambda e: e.time))]
    for index, (time, events) in enumerate(steps):
        incisions = [e for e in events if isinstance(e, Incision)]
        excisions = [e for e in events if isinstance(e, Excision)]
        if incisions:
            tissue = cut(tissue, skin, incisions, spacing, _TIMELINE)
            tissue = tidy(tissue, spacing, min(0.1 * min(i.kerf for i in incisions), 0.02 * spacing))
        if excisions:
            tissue = excise(tissue, skin, excisions, spacing)
        removed: list[Removed] = []
        for thinning in (e for e in events if isinstance(e, Thin)):
            tissue, gone = thin(tissue, rest, skin, thinning, spacing, _TIMELINE)
            removed.append(gone)
        surface = tissue.surface()
        freeing = [e for e in events if isinstance(e, Undermine)]
        for event in freeing:
            surface = undermine(surface, rest, skin, event, spacing, _TIMELINE)
        _refuse_broken(surface, time)
        parts = len(tissue.solid.decompose())  # undermining parts nothing
        epochs.append(Epoch(index, float(time), surface, parts, thinned=tuple(removed)))
        if freeing and index + 1 < len(steps):
            tissue = LabeledSolid.from_surface(surface)
    return epochs


def _refuse_broken(surface: Surface, time: float) -> None:
    triangles = surface.triangles
    faults = mesh_faults(surface.points, np.full(len(triangles), 3), triangles.reshape(-1), CLOSED)
    if faults:
        found = faults[0].problem(_TISSUE)
        code = ProblemCode.CUT_SURFACE_BROKEN
        raise refused(code, _TISSUE, f"{time:g}", place=found.place, fault=found.message)


def excise(tissue: LabeledSolid, skin: RestSkin, excisions: list[Excision], spacing: float) -> LabeledSolid:
    """Take away the fragments whose surfaces are nearest to the seeds.

    Parameters
    ----------
    tissue
        The tissue as it is cut now.
    skin
        The uncut skin.
    excisions
        Events with the seeds.
    spacing
        Lattice spacing in mm.

    Returns
    -------
    LabeledSolid
        The tissue that is left.

    Raises
    ------
    RefusedError
        If a seed is off the skin or where no tissue is left, or the seeds name all of the tissue.
    """
    parts = fragments(tissue)
    surfaces = [part.surface() for part in parts]
    corners = np.concatenate([s.points[s.triangles] for s in surfaces])
    owner = np.repeat(np.arange(len(parts)), [len(s.triangles) for s in surfaces])
    closest = ClosestPoint(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    gone: dict[int, tuple[str, str, Place]] = {}
    for excision in excisions:
        prim = f"{_TIMELINE}/{excision.name}"
        if not excision.seeds:
            raise refused(ProblemCode.EXCISION_NO_SEED, prim)
        seeds = np.asarray(excision.seeds, np.float64)
        if not np.isfinite(seeds).all():
            raise refused(ProblemCode.EXCISION_SEED_NOT_FINITE, prim)
        nearest, _, distance = closest.query(seeds)
        for seed, triangle, gap, off in zip(seeds, nearest, distance, skin.distance(seeds), strict=True):
            here, at = place(seed), Place.at(seed)
            if off > max(spacing, 1.0):
                raise refused(ProblemCode.EXCISION_SEED_OFF_SKIN, prim, here, place=at, off=off)
            if gap > 0.5 * spacing:
                raise refused(ProblemCode.EXCISION_SEED_GONE, prim, here, place=at, gap=gap)
            if len(parts) == 1:
                raise refused(ProblemCode.EXCISION_IN_ONE_PIECE, prim, here, place=at)
            gone[int(owner[triangle])] = (prim, here, at)
    if len(gone) == len(parts):
        prim, here, at = list(gone.values())[-1]
        raise refused(ProblemCode.EXCISION_OF_ALL, prim, here, place=at, parts=len(parts))
    kept = [part.solid for k, part in enumerate(parts) if k not in gone]
    return tissue.with_solid(manifold3d.Manifold.compose(kept) if len(kept) > 1 else kept[0])
