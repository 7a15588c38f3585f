"""What undermined tissue rests on: the bed faces of the tissue as it was before any cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lappet.cutting.epoch import Epoch, Ground
from lappet.geometry.surface_check import signed_volume
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue


def on_ground(epochs: Sequence[Epoch], tissue: Tissue) -> list[Epoch]:
    """Give the ground to the epochs with faces that rest on it.

    Parameters
    ----------
    epochs
        The epochs.
    tissue
        The tissue before any cut.

    Returns
    -------
    list[Epoch]
        The epochs.
    """
    rests = [bool(np.any(epoch.support == 2)) for epoch in epochs]
    if not any(rests):
        return list(epochs)
    ground = _ground(tissue)
    return [replace(epoch, ground=ground) if each else epoch for epoch, each in zip(epochs, rests, strict=True)]


def _ground(tissue: Tissue) -> Ground:
    points = np.asarray(tissue.points, np.float64)
    counts, indices = (np.asarray(each, np.int64) for each in (tissue.face_vertex_counts, tissue.face_vertex_indices))
    triangles, _, faces = triangulate(points, counts, indices)
    if signed_volume(points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    below = np.zeros(len(counts), bool)
    below[np.asarray(tissue.subsets.get("bed", ()), np.int64)] = True
    used, compact = np.unique(triangles[below[faces]], return_inverse=True)
    return Ground(points[used], compact.reshape(-1, 3).astype(np.int32))
