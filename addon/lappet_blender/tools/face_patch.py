"""The faces of the tissue around a point: what a retractor grips when no group was made for it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

import bpy
import numpy as np
from numpy.typing import NDArray

from ..model.mesh_values import GROUP
from .shown_surface import RestShape


def faces_around(shape: RestShape, place: Sequence[float], radius: float) -> NDArray[np.int64]:
    """The faces (f,) of the tissue on the skin around a place.

    Those with a triangle whose center at rest lies within `radius` mm of it, or else the one face nearest to it.
    """
    skin = shape.skin[shape.face[shape.skin] >= 0]
    if len(skin) == 0:
        return np.zeros(0, np.int64)
    centers = shape.points[shape.triangles[skin]].mean(axis=1)
    away = np.linalg.norm(centers - np.asarray(place), axis=1)
    near = away <= max(radius, float(away.min()))
    return np.unique(shape.face[skin[near]].astype(np.int64))


def free_group_name(tissue: bpy.types.Object, stem: str = "grip") -> str:
    """The first of grip_1, grip_2 ... that the tissue's mesh has no group of."""
    taken = tissue.data.attributes
    return next(name for k in count(1) if GROUP + (name := f"{stem}_{k}") not in taken)
