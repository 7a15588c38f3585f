"""What the faces of an epoch are besides held and gripped: parts, rollers, loaded faces; and the sections across it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Boundary, Epoch
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Tissue
from lappet.procedure.prim_paths import TISSUE
from lappet.program.fixed_parts import FixedParts
from lappet.program.timed_events import TimedEvents, event_path


def with_boundaries(
    epochs: Sequence[Epoch],
    tissue: Tissue,
    parts: FixedParts,
    events: TimedEvents,
    own_times: Mapping[int, Sequence[float]],
    self_contact: bool = False,
) -> list[Epoch]:
    """Give epochs what their faces are.

    Parameters
    ----------
    epochs
        The epochs.
    tissue
        The tissue before any cut.
    parts
        The parts of its fixed faces.
    events
        The events.
    own_times
        Frames of each epoch by its index, time codes.
    self_contact
        Whether tissue is kept from passing through tissue: walls of wounds are named then.

    Returns
    -------
    list[Epoch]
        The epochs with their boundaries.

    Raises
    ------
    RefusedError
        If a load or a roller names faces that are not there.
    """
    bounded = [
        replace(epoch, boundary=boundary_of(epoch, tissue, parts, events, own_times[epoch.index])) for epoch in epochs
    ]
    return with_walls(bounded) if self_contact else bounded


def with_walls(epochs: Sequence[Epoch]) -> list[Epoch]:
    """Say which faces are walls of wounds: with self-contact sutures bring these together, not points behind them.

    Parameters
    ----------
    epochs
        The epochs.

    Returns
    -------
    list[Epoch]
        The epochs with walls in their boundaries.
    """
    return [
        replace(epoch, boundary=replace(epoch.boundary, walls=epoch.surface.origin == FaceOrigin.WOUND_WALL))
        for epoch in epochs
    ]


def boundary_of(epoch: Epoch, tissue: Tissue, parts: FixedParts, events: TimedEvents, own: Sequence[float]) -> Boundary:
    """Find what the faces of an epoch are.

    Parameters
    ----------
    epoch
        The epoch.
    tissue
        The tissue before any cut.
    parts
        The parts of its fixed faces.
    events
        The events.
    own
        The epoch's own frames, time codes.

    Returns
    -------
    Boundary
        Of loads only those that act in one of the epoch's frames.

    Raises
    ------
    RefusedError
        If a load or a roller names faces that are not there.
    """
    surface = epoch.surface
    rollers, normals = _rollers(surface, tissue)
    index, faces = _loaded(surface, events, own)
    return Boundary(
        fixed_parts=parts.on(surface),
        rollers=rollers,
        roller_normals=normals,
        loaded_index=index,
        loaded_faces=faces,
        section_points=np.array([each.point for each in events.sections], np.float64).reshape(-1, 3),
        section_normals=np.array([each.normal for each in events.sections], np.float64).reshape(-1, 3),
    )


def named_faces(surface: Surface, name: str) -> NDArray[np.bool_] | None:
    """Find the triangles of a cut surface that a face subset of the tissue names.

    Parameters
    ----------
    surface
        The surface.
    name
        Name of the subset.

    Returns
    -------
    NDArray[np.bool_] | None
        Which triangles are, shape (m,); None where there is no such subset.
    """
    labels = {
        "fixed": surface.fixed,
        "bed": surface.bed,
        "underside": surface.origin == FaceOrigin.UNDERSIDE,
        "rim": surface.origin == FaceOrigin.RIM,
    }
    return surface.grips.get(name, labels.get(name))


def _rollers(surface: Surface, tissue: Tissue) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    if not tissue.rollers:
        return np.zeros(0, np.int32), np.zeros((0, 3))
    found = np.full(len(surface.triangles), -1, np.int32)
    for k, roller in enumerate(tissue.rollers):
        mask = named_faces(surface, roller.faces)
        if mask is None:
            known = ", ".join(surface.grips) or "none"
            raise refused(ProblemCode.ROLLER_FACES_UNKNOWN, f"{TISSUE}/{roller.faces}", roller.faces, known=known)
        found[mask & ~surface.fixed] = k
    return found, np.array([roller.normal or (0.0, 0.0, 0.0) for roller in tissue.rollers], np.float64)


def _loaded(surface: Surface, events: TimedEvents, own: Sequence[float]) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    masks: dict[int, NDArray[np.bool_]] = {}
    for load in events.loads:
        acts = [time for time in own if load.start <= time < load.release]
        if not acts:
            continue
        mask = named_faces(surface, load.faces)
        if mask is None:
            known = ", ".join(surface.grips) or "none"
            raise refused(ProblemCode.LOAD_FACES_UNKNOWN, event_path(load), load.faces, known=known)
        if not mask.any():
            raise refused(ProblemCode.LOAD_EXCISED, event_path(load), load.faces, time=acts[0])
        masks[events.loaded.index(load.faces)] = mask
    if not masks:
        return np.zeros(0, np.int32), np.zeros((0, 0), np.bool_)
    index = sorted(masks)
    return np.array(index, np.int32), np.array([masks[k] for k in index], np.bool_)
