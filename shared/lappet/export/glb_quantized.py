"""Positions and normals of a .glb as whole numbers (Khronos, KHR_mesh_quantization), and how far that moves vertices.

Positions have 16 bits, normals 8. A mesh's node says by its translation and scale which millimetres the numbers are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.export.glb_container import VERTICES, GlbContainer
from lappet.export.glb_meshopt import unpacked
from lappet.export.moving_shape import MovingShape

EXTENSION = "KHR_mesh_quantization"
_MOST = {np.int8: 127.0, np.int16: 32767.0}
_TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}


@dataclass(frozen=True, eq=False)
class QuantizedShape:
    """What the numbers of a shape's positions mean.

    Parameters
    ----------
    center
        What 0 is, in mm, shape (3,).
    size
        What the greatest number is, in mm from there.
    """

    center: NDArray[np.float64]
    size: float

    @staticmethod
    def of(shape: MovingShape) -> QuantizedShape:
        """Choose what the numbers mean, for a shape whose last frame is its base.

        Parameters
        ----------
        shape
            The shape.

        Returns
        -------
        QuantizedShape
            The choice.
        """
        base = shape.positions[-1].astype(np.float64)
        low, high = base.min(axis=0), base.max(axis=0)
        moved = float(np.abs(shape.positions - shape.positions[-1]).max())
        return QuantizedShape(0.5 * (low + high), 1.001 * max(float((high - low).max()) / 2.0, moved, 1e-3))

    @property
    def node(self) -> dict[str, Any]:
        """What the mesh's node says."""
        return {"translation": self.center.tolist(), "scale": [self.size / _MOST[np.int16]] * 3}

    def attributes(self, put: GlbContainer, shape: MovingShape) -> dict[str, int]:
        """Add the base.

        Parameters
        ----------
        put
            The file.
        shape
            The shape.

        Returns
        -------
        dict[str, int]
            Its accessors by their names.
        """
        return {
            "POSITION": put.integers(self._base(shape), VERTICES, False),
            "NORMAL": put.integers(_rounded(shape.normals[-1], np.int8), VERTICES, True),
        }

    def target(self, put: GlbContainer, shape: MovingShape, frame: int, still: tuple[float, float]) -> dict[str, int]:
        """Add what a frame moves.

        Parameters
        ----------
        put
            The file.
        shape
            The shape.
        frame
            Index of the frame.
        still
            Up to which length a displacement in mm, and a change of a normal, is nothing.

        Returns
        -------
        dict[str, int]
            The accessors by their names.
        """
        base = self.center + self.size * self._base(shape) / _MOST[np.int16]
        points = (shape.positions[frame] - base) / self.size
        points[np.linalg.norm(shape.positions[frame] - shape.positions[-1], axis=1) <= still[0]] = 0.0
        shaded = _rounded(shape.normals[-1], np.int8) / _MOST[np.int8]
        turned = shape.normals[frame] - shaded
        turned[np.linalg.norm(shape.normals[frame] - shape.normals[-1], axis=1) <= still[1]] = 0.0
        whole = np.abs(turned).max() <= 1.0  # a normal that turns back has no place in the numbers
        normals = (
            put.sparse_integers(_rounded(turned, np.int8), True) if whole else put.displacements(turned, 0.0, False)
        )
        return {"POSITION": put.sparse_integers(_rounded(points, np.int16), False), "NORMAL": normals}

    def _base(self, shape: MovingShape) -> NDArray[np.int16]:
        return _rounded((shape.positions[-1] - self.center) / self.size, np.int16)


def _rounded(values: NDArray[Any], kind: Any) -> NDArray[Any]:
    most = _MOST[kind]
    return np.rint(np.clip(values, -1.0, 1.0) * most).astype(kind)


def glb_error(path: Path, shapes: Sequence[MovingShape]) -> float:
    """Read a file and find how far its vertices are from where they should be.

    Parameters
    ----------
    path
        The file, with a mesh for each shape and a node that has it.
    shapes
        The shapes in it, as they should be.

    Returns
    -------
    float
        The greatest distance in any frame, in mm.
    """
    document, data = unpacked(path.read_bytes())
    buffer = memoryview(data)
    nodes = {each["mesh"]: each for each in document["nodes"] if "mesh" in each}
    worst = 0.0
    for number, shape in enumerate(shapes):
        node, primitive = nodes[number], document["meshes"][number]["primitives"][0]
        size, shift = node.get("scale", [1.0] * 3)[0] or 1.0, np.array(node.get("translation", [0.0] * 3))
        base = _read(document, buffer, primitive["attributes"]["POSITION"])
        moved = [_read(document, buffer, each["POSITION"]) for each in primitive.get("targets", [])]
        found = [*(base + each for each in moved), base] if moved else [base] * len(shape.frames)
        for points, wanted in zip(found, shape.positions, strict=True):
            worst = max(worst, float(np.linalg.norm(points * size + shift - wanted, axis=1).max()))
    return worst


def _read(document: dict[str, Any], buffer: memoryview, index: int) -> NDArray[np.float64]:
    """The vectors of an accessor, as a viewer takes them."""
    accessor = document["accessors"][index]
    kind = np.dtype(_TYPES[accessor["componentType"]])

    def rows(own: dict[str, Any], count: int, what: np.dtype[Any], columns: int) -> NDArray[Any]:
        view = document["bufferViews"][own["bufferView"]]
        begin = view.get("byteOffset", 0) + own.get("byteOffset", 0)
        strides = (view.get("byteStride", columns * what.itemsize), what.itemsize)
        return np.ndarray((count, columns), what, buffer, begin, strides)

    values = np.zeros((accessor["count"], 3), kind)
    if "bufferView" in accessor:
        values[:] = rows(accessor, len(values), kind, 3)
    if "sparse" in accessor:
        sparse = accessor["sparse"]
        of = np.dtype(_TYPES[sparse["indices"]["componentType"]])
        values[rows(sparse["indices"], sparse["count"], of, 1)[:, 0]] = rows(sparse["values"], sparse["count"], kind, 3)
    scale = _MOST[kind.type] if accessor.get("normalized") else 1.0
    return np.maximum(values.astype(np.float64) / scale, -1.0) if scale > 1.0 else values.astype(np.float64)
