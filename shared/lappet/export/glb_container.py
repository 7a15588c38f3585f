"""A binary glTF 2.0 file: its arrays as accessors of one buffer, and the container around it.

Khronos Group, glTF 2.0 Specification, 2021: 3.6.2 (accessors, sparse ones), 4 (GLB).
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.durable import write_whole
from lappet.export.glb_meshopt import MESHOPT, CompressedViews

BYTE, UBYTE, SHORT, USHORT, UINT, FLOAT = 5120, 5121, 5122, 5123, 5125, 5126
VERTICES, INDICES = 34962, 34963
_BYTES = {BYTE: 1, UBYTE: 1, SHORT: 2, USHORT: 2, UINT: 4, FLOAT: 4}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class GlbContainer:
    """The arrays of a file that is being made; `accessors` and `views` are what the file says of them.

    Parameters
    ----------
    compressed
        Whether they are compressed by meshopt.
    """

    def __init__(self, compressed: bool = False) -> None:
        self.compressed = compressed
        self.accessors: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self._data = bytearray()

    def view(self, data: bytes, target: int | None = None) -> int:
        """Add bytes.

        Parameters
        ----------
        data
            The bytes.
        target
            `VERTICES` or `INDICES` for what goes to the graphics card.

        Returns
        -------
        int
            Index of their view.
        """
        self._data.extend(b"\0" * (-len(self._data) % 4))
        view = {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(data)}
        self.views.append(view if target is None else {**view, "target": target})
        self._data.extend(data)
        return len(self.views) - 1

    def floats(self, values: NDArray[np.floating], target: int | None = None, box: bool = False) -> int:
        """Add numbers or vectors.

        Parameters
        ----------
        values
            Shape (n,) or (n, k).
        target
            As of `view`.
        box
            Whether the file says between which values they lie.

        Returns
        -------
        int
            Index of their accessor.
        """
        array = np.ascontiguousarray(values, np.float32)
        return self._accessor(array, FLOAT, self.view(array.tobytes(), target), box)

    def switches(self, values: NDArray[np.bool_]) -> int:
        """Add what is on or off.

        Parameters
        ----------
        values
            Shape (n,).

        Returns
        -------
        int
            Index of their accessor.
        """
        array = np.ascontiguousarray(values, np.uint8)
        return self._accessor(array, UBYTE, self.view(array.tobytes()), False)

    def indices(self, triangles: NDArray[np.integer], count: int) -> int:
        """Add indices of vertices.

        Parameters
        ----------
        triangles
            The indices.
        count
            How many vertices there are.

        Returns
        -------
        int
            Index of their accessor.
        """
        kind = np.uint16 if count < 65535 else np.uint32
        array = np.ascontiguousarray(triangles.ravel(), kind)
        return self._accessor(array, USHORT if kind is np.uint16 else UINT, self.view(array.tobytes(), INDICES), False)

    def displacements(self, values: NDArray[np.floating], least: float, box: bool) -> int:
        """Add vectors of which many may be nothing: those alone that are more, where that takes less space.

        Parameters
        ----------
        values
            Shape (n, 3).
        least
            Length up to which a vector is nothing.
        box
            As of `floats`.

        Returns
        -------
        int
            Index of their accessor.
        """
        array = np.ascontiguousarray(values, np.float32)
        array = np.where(np.linalg.norm(array, axis=1, keepdims=True) > least, array, np.float32(0.0))
        used = np.flatnonzero(array.any(axis=1))
        short = len(array) < 65535
        if self.compressed or len(used) * (12 + (2 if short else 4)) >= array.nbytes:
            return self.floats(array, VERTICES, box)
        index = self._accessor(array, FLOAT, None, box)
        self._only(index, array, used)
        return index

    def integers(self, values: NDArray[np.signedinteger[Any]], target: int, unit: bool) -> int:
        """Add vectors of whole numbers.

        Parameters
        ----------
        values
            Shape (n, 3), int8 or int16.
        target
            As of `view`.
        unit
            Whether they stand for what lies between -1 and 1; the others are positions, and the file says between which
            they lie.

        Returns
        -------
        int
            Index of their accessor.
        """
        padded = np.zeros((len(values), 4), values.dtype)  # every vector begins at a multiple of four bytes
        padded[:, :3] = values
        view = self.view(padded.tobytes(), target)
        self.views[view]["byteStride"] = 4 * values.itemsize
        return self._whole_numbers(values, view, unit)

    def sparse_integers(self, values: NDArray[np.signedinteger[Any]], unit: bool) -> int:
        """Add vectors of whole numbers of which many may be nothing.

        Parameters
        ----------
        values
            As of `integers`.
        unit
            As of `integers`.

        Returns
        -------
        int
            Index of their accessor.
        """
        used = np.flatnonzero(values.any(axis=1))
        size = 2 if len(values) < 65535 else 4
        # Compression makes less of zeros than of the indices of what is not zero.
        if self.compressed or len(used) * (3 * values.itemsize + size) >= 4 * values.nbytes // 3:
            return self.integers(values, VERTICES, unit)
        index = self._whole_numbers(values, None, unit)
        self._only(index, values, used)
        return index

    def _whole_numbers(self, values: NDArray[Any], view: int | None, unit: bool) -> int:
        index = self._accessor(values, BYTE if values.itemsize == 1 else SHORT, view, not unit)
        if unit:
            self.accessors[index]["normalized"] = True
        return index

    def _only(self, index: int, array: NDArray[Any], used: NDArray[np.integer]) -> None:
        """Say that an accessor has values at some vertices alone."""
        if not len(used):
            return
        kind = np.uint16 if len(array) < 65535 else np.uint32
        self.accessors[index]["sparse"] = {
            "count": len(used),
            "indices": {
                "bufferView": self.view(used.astype(kind).tobytes()),
                "componentType": USHORT if kind is np.uint16 else UINT,
            },
            "values": {"bufferView": self.view(np.ascontiguousarray(array[used]).tobytes())},
        }

    def _accessor(self, array: NDArray[Any], kind: int, view: int | None, box: bool) -> int:
        accessor: dict[str, Any] = {
            "componentType": kind,
            "count": len(array),
            "type": _TYPES[1 if array.ndim == 1 else array.shape[1]],
        }
        if view is not None:
            accessor["bufferView"] = view
        if box:
            rows = array.reshape(len(array), -1)
            accessor["min"], accessor["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def _strides(self) -> dict[int, int]:
        """The bytes of each element, of the views that accessors name."""
        found = {}
        for accessor in self.accessors:
            if "bufferView" in accessor:
                columns = {name: count for count, name in _TYPES.items()}[accessor["type"]]
                view = self.views[accessor["bufferView"]]
                found[accessor["bufferView"]] = view.get("byteStride", columns * _BYTES[accessor["componentType"]])
        return found

    def write(self, document: dict[str, Any], path: Path) -> None:
        """Write the file; it appears whole or not at all.

        Parameters
        ----------
        document
            What it says besides its arrays.
        path
            The file.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        views, data, buffers = self.views, bytes(self._data), []
        if self.compressed:
            packed = CompressedViews(self.views, data, self._strides())
            views, data = packed.views, bytes(packed.data)
            plain = {"byteLength": packed.plain, "extensions": {MESHOPT: {"fallback": True}}}
            buffers = [plain] if packed.plain else []
        said = {
            **document,
            "accessors": self.accessors,
            "bufferViews": views,
            "buffers": [{"byteLength": len(data)}, *buffers],
        }
        data += b"\0" * (-len(data) % 4)
        text = json.dumps(said, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
        write_whole(path, struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
