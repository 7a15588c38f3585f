"""What is shown around the tissue and not solved: the rest of a face, the eyes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lappet.procedure.exact_values import frozen, same_array, set_fields

SceneryKind = Literal["skin", "eye", "iris", "pupil", "teeth"]
SCENERY_KINDS: tuple[SceneryKind, ...] = get_args(SceneryKind)


@dataclass(frozen=True, eq=False)
class Scenery:
    """A mesh that is shown and has no part in the mechanics (`/Procedure/Scenery/<name>`).

    Parameters
    ----------
    name
        Name of the mesh, unique among the scenery.
    points
        Vertices in mm, shape (n, 3), float64 that single precision can hold.
    face_vertex_counts
        Corners of each face, shape (m,), int32.
    face_vertex_indices
        Vertices of the faces one after another, shape (k,), int32.
    kind
        What it is, one of `SCENERY_KINDS`: how pictures color it.
    """

    name: str
    points: NDArray[np.float64]
    face_vertex_counts: NDArray[np.int32]
    face_vertex_indices: NDArray[np.int32]
    kind: SceneryKind = "skin"

    def __post_init__(self) -> None:
        set_fields(
            self,
            points=frozen(self.points, np.float64, 3),
            face_vertex_counts=frozen(self.face_vertex_counts, np.int32),
            face_vertex_indices=frozen(self.face_vertex_indices, np.int32),
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scenery):
            return NotImplemented
        return (
            (self.name, self.kind) == (other.name, other.kind)
            and same_array(self.points, other.points)
            and same_array(self.face_vertex_counts, other.face_vertex_counts)
            and same_array(self.face_vertex_indices, other.face_vertex_indices)
        )

    def __hash__(self) -> int:
        return hash((self.name, self.kind, self.points.shape, self.points.tobytes()))
