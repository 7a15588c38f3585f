"""The arrays of a lesson as one compressed block: differences, sorted by their bytes, deflated."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

_LEVEL = 9
STEP = 0.01  # mm: to so much positions are rounded, where a range of 655 mm is enough
_MOST = 65535


class LessonArrays:
    """Collect the arrays of a lesson.

    An array of unsigned whole numbers is written as differences to the number `back` places before it (to the one
    before it where there is none), modulo its width, folded so that small ones of either sign are small, and as planes:
    all lowest bytes first. Deflating the whole then takes advantage of what stays still. `viewer/src/arrays.ts` reads
    it.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, values: NDArray[np.unsignedinteger], back: int = 1) -> dict[str, int]:
        """Add an array.

        Parameters
        ----------
        values
            The numbers, of 1, 2 or 4 bytes; they are taken in their order in memory.
        back
            How many places before a number the one lies that it is likely to be near.

        Returns
        -------
        dict[str, int]
            Where it lies: `at` in bytes, `count`, `width` in bytes, `back`.
        """
        flat = np.ascontiguousarray(values).ravel()
        width, count = flat.dtype.itemsize, flat.size
        back = max(1, min(back, count))
        before = np.zeros_like(flat)
        before[1:back] = flat[: back - 1]
        before[back:] = flat[:-back]
        difference = (flat - before).view(f"i{width}")
        folded = (difference.astype(np.int64) << 1) ^ (difference.astype(np.int64) >> 63)
        planes = folded.astype(f"<u{width}").view(np.uint8).reshape(count, width).T
        entry = {"at": self._size, "count": count, "width": width, "back": back}
        self._parts.append(planes.tobytes())
        self._size += count * width
        return entry

    def positions(self, tracks: NDArray[np.floating]) -> dict[str, Any]:
        """Add places that move, rounded to `STEP` (a larger step where they range over more than 655 mm).

        Parameters
        ----------
        tracks
            Places in mm, shape (f, n, 3): f states of n places, each likely to be near the one before it.

        Returns
        -------
        dict[str, Any]
            `low` in mm and `step` in mm, `states`, `places`, and the array, of which a state has all x, then all y and
            all z.
        """
        states, places = tracks.shape[:2]
        flat = np.asarray(tracks, np.float64).reshape(-1, 3)
        low = flat.min(axis=0) if len(flat) else np.zeros(3)
        extent = float((flat - low).max(initial=0.0))
        step = max(STEP, extent / _MOST)
        whole = np.rint((np.asarray(tracks, np.float64) - low) / step).astype(np.uint16)
        array = self.add(whole.transpose(0, 2, 1), 3 * places)
        return {"low": low.tolist(), "step": step, "states": states, "places": places, "array": array}

    def block(self) -> bytes:
        """Deflate all arrays.

        Returns
        -------
        bytes
            The block (zlib, with its check sum).
        """
        return zlib.compress(b"".join(self._parts), _LEVEL)

    @property
    def size(self) -> int:
        """Number of bytes of the block once it is inflated."""
        return self._size
