"""Compress the arrays of a .glb by meshopt (Khronos, EXT_meshopt_compression), and read them again.

A compressed view says where its bytes lie and, as a view of a buffer that is not in the file, where they would lie
without compression.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from lappet.export.meshopt_package import meshopt

MESHOPT = "EXT_meshopt_compression"
INDICES = 34963


class CompressedViews:
    """The views of a file with those compressed that become smaller by it.

    Parameters
    ----------
    views
        The views, each of buffer 0.
    data
        Its bytes.
    strides
        For the index of a view the bytes of each of its elements.
    """

    def __init__(self, views: list[dict[str, Any]], data: bytes, strides: dict[int, int]) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.plain = 0  # bytes of the buffer that is not in the file
        encoder = meshopt()
        for number, view in enumerate(views):
            own = data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
            stride = strides.get(number, 0)
            packed = _packed(encoder, own, stride, view.get("target") == INDICES)
            if packed is None or len(packed) >= len(own):
                self.views.append({**view, "byteOffset": self._put(own)})
                continue
            mode = "TRIANGLES" if view.get("target") == INDICES else "ATTRIBUTES"
            told: dict[str, Any] = {"buffer": 0, "byteOffset": self._put(packed), "byteLength": len(packed)}
            told = {**told, "byteStride": stride, "count": len(own) // stride, "mode": mode}
            self.plain += -self.plain % 4
            self.views.append({**view, "buffer": 1, "byteOffset": self.plain, "extensions": {MESHOPT: told}})
            self.plain += len(own)

    def _put(self, own: bytes) -> int:
        self.data.extend(b"\0" * (-len(self.data) % 4))
        at = len(self.data)
        self.data.extend(own)
        return at


def _packed(encoder: Any, own: bytes, stride: int, indices: bool) -> bytes | None:
    """The compressed bytes of a view; None where it is not of elements that can be compressed."""
    if indices:
        kind = np.uint16 if stride == 2 else np.uint32
        found: bytes = encoder.encode_index_buffer(np.frombuffer(own, kind).astype(np.uint32))
        return found
    if not stride or stride % 4 or stride > 256 or len(own) % stride:
        return None
    packed: bytes = encoder.encode_vertex_buffer(np.frombuffer(own, np.uint8).reshape(-1, stride))
    return packed


def unpacked(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Read a .glb with its compressed views put back.

    Parameters
    ----------
    data
        The file.

    Returns
    -------
    tuple[dict[str, Any], bytes]
        What it says, with views of one buffer, and the bytes of that.
    """
    length = struct.unpack_from("<I", data, 12)[0]
    document: dict[str, Any] = json.loads(data[20 : 20 + length])
    buffer = data[28 + length :]
    if MESHOPT not in document.get("extensionsUsed", ()):
        return document, buffer
    decoder = meshopt()
    whole = bytearray(buffer)
    for view in document["bufferViews"]:
        told = view.pop("extensions", {}).get(MESHOPT)
        if told is None:
            continue
        packed = buffer[told["byteOffset"] : told["byteOffset"] + told["byteLength"]]
        if told["mode"] == "TRIANGLES":
            own = np.asarray(decoder.decode_index_buffer(told["count"], 4, packed), np.uint32)
            own = own.astype(np.uint16 if told["byteStride"] == 2 else np.uint32)
        else:
            own = decoder.decode_vertex_buffer(told["count"], told["byteStride"], packed)
        whole.extend(b"\0" * (-len(whole) % 4))
        view["buffer"], view["byteOffset"] = 0, len(whole)
        whole.extend(np.ascontiguousarray(own).tobytes()[: view["byteLength"]])
    return document, bytes(whole)
