"""Read the scenery of a stage: what is shown around the tissue and not solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class SceneryMesh:
    """A mesh of the scenery.

    Parameters
    ----------
    name
        Its prim's name.
    kind
        What it shows, such as "skin".
    points
        Vertices in mm, shape (n, 3), float32.
    triangles
        Vertex indices, shape (m, 3), int32.
    """

    name: str
    kind: str
    points: NDArray[np.float32]
    triangles: NDArray[np.int32]


def read_scenery(stage: Any, mm: float, folder_path: str = "/Procedure/Scenery") -> tuple[SceneryMesh, ...]:
    """Read the scenery of a stage; faces of more than three corners are split into fans.

    Parameters
    ----------
    stage
        The stage.
    mm
        Millimetres in the stage's unit.
    folder_path
        Path of the prim below which the meshes lie.

    Returns
    -------
    tuple[SceneryMesh, ...]
        The meshes, without those that are broken.
    """
    folder = stage.GetPrimAtPath(folder_path)
    found = []
    for prim in folder.GetChildren() if folder else []:
        points = np.asarray(prim.GetAttribute("points").Get() or [], np.float32).reshape(-1, 3) * np.float32(mm)
        counts = np.asarray(prim.GetAttribute("faceVertexCounts").Get() or [], np.int64)
        corners = np.asarray(prim.GetAttribute("faceVertexIndices").Get() or [], np.int64)
        if counts.sum() != len(corners) or not len(corners) or corners.max() >= len(points) or corners.min() < 0:
            continue  # a picture does without what is broken; `lappet check` tells of it
        kind = prim.GetAttribute("lappet:kind").Get() or "skin"
        found.append(SceneryMesh(prim.GetName(), str(kind), points, _fans(counts, corners)))
    return tuple(found)


def _fans(counts: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.int32]:
    starts = np.cumsum(counts) - counts
    parts = []
    for k in range(1, int(counts.max()) - 1):
        own = starts[counts > k + 1]
        parts.append(np.stack([corners[own], corners[own + k], corners[own + k + 1]], axis=1))
    return np.concatenate(parts).astype(np.int32)
