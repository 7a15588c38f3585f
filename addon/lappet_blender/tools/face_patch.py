"""The faces of the tissue around a point: what a retractor grips when no group was made for it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

import bpy
import numpy as np
from numpy.typing import NDArray

from .shown_surface import GROUP_PREFIX, RestShape


def faces_around(shape: RestShape, place: Sequence[float], radius: float) -> NDArray[np.int64]:
    """The faces of the tissue (f,) on the skin with a triangle whose centre at rest lies within `radius` mm of a place,
    or else the one face nearest to it."""
    skin = shape.skin[shape.face[shape.skin] >= 0]
    if len(skin) == 0:
        return np.zeros(0, np.int64)
    centers = shape.points[shape.triangles[skin]].mean(axis=1)
    away = np.linalg.norm(centers - np.asarray(place), axis=1)
    near = away <= max(radius, float(away.min()))
    return np.unique(shape.face[skin[near]].astype(np.int64))


def as_ranges(faces: Sequence[int] | NDArray[np.int64]) -> str:
    """Indices as text: "0,1,5-9"."""
    parts: list[str] = []
    run: list[int] = []
    for face in [*(int(f) for f in faces), -2]:
        if run and face == run[-1] + 1:
            run.append(face)
            continue
        if run:
            parts.append(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}")
        run = [face]
    return ",".join(parts)


def free_group_name(tissue: bpy.types.Object, stem: str = "grip") -> str:
    """The first of grip_1, grip_2 ... that the tissue's mesh has no group of."""
    taken = tissue.data.attributes
    return next(name for k in count(1) if GROUP_PREFIX + (name := f"{stem}_{k}") not in taken)


def group_items(tissue: bpy.types.Object | None) -> list[str]:
    """The names of the groups of a tissue's faces."""
    if tissue is None or tissue.type != "MESH":
        return []
    names = [a.name for a in tissue.data.attributes if a.domain == "FACE" and a.data_type == "BOOLEAN"]
    return [name.removeprefix(GROUP_PREFIX) for name in names if name.startswith(GROUP_PREFIX)]
