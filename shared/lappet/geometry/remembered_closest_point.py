"""Closest points that are remembered: a procedure that is compiled after each edit asks for the same ones again."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint

_SURFACES = 16  # the tissue, and the skin and walls of the epochs of a few procedures
_ANSWERS = 20_000
_lock = threading.Lock()
_surfaces: OrderedDict[bytes, _Remembering] = OrderedDict()


class _Remembering(ClosestPoint):
    """Answers as its base does, to the bit, and each point but once."""

    def __init__(self, surface_points: ArrayLike, triangles: ArrayLike) -> None:
        super().__init__(surface_points, triangles)
        self._answers: dict[bytes, tuple[int, NDArray[np.float64], float]] = {}

    def _one(self, query: NDArray[np.float64]) -> tuple[int, NDArray[np.float64], float]:
        key = query.tobytes()
        answer = self._answers.get(key)
        if answer is None:
            if len(self._answers) >= _ANSWERS:
                self._answers.clear()
            answer = self._answers[key] = super()._one(query)
        return answer


def remembered_closest_point(surface_points: ArrayLike, triangles: ArrayLike) -> ClosestPoint:
    """A `ClosestPoint` of this surface, the one made before where its contents are the same. Raises as that does."""
    points, faces = np.ascontiguousarray(surface_points, np.float64), np.ascontiguousarray(triangles)
    hasher = hashlib.blake2b(f"{points.shape}{faces.dtype.str}{faces.shape}".encode(), digest_size=32)
    hasher.update(points.data)
    hasher.update(faces.data)
    key = hasher.digest()
    with _lock:
        found = _surfaces.get(key)
        if found is not None:
            _surfaces.move_to_end(key)
            return found
    made = _Remembering(points, faces)
    with _lock:
        _surfaces[key] = made
        while len(_surfaces) > _SURFACES:
            _surfaces.popitem(last=False)
    return made
