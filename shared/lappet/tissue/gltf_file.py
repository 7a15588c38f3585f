"""A glTF file whose sizes are checked before anything believes them, without its pictures."""

from __future__ import annotations

import base64
import binascii
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.folder import Folder
from lappet.foreign.limits import ReadLimits
from lappet.foreign.regular_file import refuse_irregular

MAX_LEVELS = 1000  # of nodes: each takes Python a call
_MAGIC, _JSON_CHUNK, _BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
_HEADER, _CHUNK_HEADER = 12, 8
_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_DATA = "base64,"


class GltfFile:
    """A glTF file, read and checked.

    Parameters
    ----------
    path
        A .gltf or .glb file.
    limits
        How large it may be, and where its buffers may lie.

    Raises
    ------
    RefusedError
        If it is no glTF, says that it holds what it does not, its nodes are no tree, or a buffer may not be read.
    """

    def __init__(self, path: Path, limits: ReadLimits) -> None:
        self._path, self._limits = path, limits
        self._folder = Folder(path, limits)
        try:
            text, binary = _chunks(path.read_bytes()) if path.suffix.lower() == ".glb" else (path.read_bytes(), b"")
            self._tree = json.loads(text)
            self._buffers = [self._buffer(each, binary) for each in self._tree.get("buffers", [])]
            self._refuse_sizes()
            self._refuse_nodes()
        except RefusedError:
            raise
        except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
            raise refused(ProblemCode.FILE_NO_MESH, path, type(error).__name__) from error

    def stream(self) -> io.BytesIO:
        """Write the file anew as .gltf for trimesh: no pictures, buffers by their number.

        Returns
        -------
        io.BytesIO
            The text.
        """
        plain = {name: value for name, value in self._tree.items() if name not in ("images", "textures", "samplers")}
        plain["materials"] = [{} for _ in self._tree.get("materials", [])]
        plain["buffers"] = [{"uri": str(i), "byteLength": len(data)} for i, data in enumerate(self._buffers)]
        return io.BytesIO(json.dumps(plain).encode())

    def __getitem__(self, name: str) -> bytes:
        """Return a buffer by its number: what trimesh expects of a resolver."""
        return self._buffers[int(name)]

    def _buffer(self, described: Any, binary: bytes) -> bytes:
        uri = described.get("uri")
        data = binary if uri is None else self._data(uri)
        if described["byteLength"] > len(data):
            self._promised("a buffer", described["byteLength"], len(data))
        return data

    def _data(self, uri: str) -> bytes:
        if uri.startswith("data:"):
            head, found, text = uri.partition(_DATA)
            try:
                return base64.b64decode(text if found else head)
            except binascii.Error as error:
                raise refused(ProblemCode.FILE_NO_MESH, self._path, "no base64") from error
        named = unquote(uri)
        self._folder.refuse_outside(Path(named), named)
        file = self._path.resolve().parent / named
        try:
            refuse_irregular(file, self._limits)
            return file.read_bytes()
        except OSError as error:
            raise refused(ProblemCode.FILE_NO_MESH, self._path, f"{named}: {error.strerror}") from error

    def _refuse_sizes(self) -> None:
        views = self._tree.get("bufferViews", [])
        for view in views:
            first, length = view.get("byteOffset", 0), view["byteLength"]
            room = len(self._buffers[view["buffer"]])
            if not (first >= 0 and length >= 0 and first + length <= room):
                self._promised("a bufferView", f"{length} bytes from byte {first}", room)
        for accessor in self._tree.get("accessors", []):
            count, shape = accessor["count"], accessor["type"]
            row = _COMPONENT_BYTES[accessor["componentType"]] * _COMPONENTS[shape]
            # Zeros where there is no view: a decoder may fill them from what the file holds.
            room = views[accessor["bufferView"]]["byteLength"] if "bufferView" in accessor else self._held()
            if not (isinstance(count, int) and count >= 0 and count * row <= room):
                self._promised("an accessor", f"{count} elements of {row} bytes", room)

    def _held(self) -> int:
        return sum(map(len, self._buffers))

    def _refuse_nodes(self) -> None:
        """Refuse nodes that are no trees: a scene of n nodes could draw a mesh 2^n times."""
        nodes = self._tree.get("nodes", [])
        parent = {child: i for i, node in enumerate(nodes) for child in node.get("children", ())}
        if len(parent) < sum(len(node.get("children", ())) for node in nodes):
            raise self._nodes("a node has two parents")
        level = {i: 1 for i in range(len(nodes)) if i not in parent}
        waiting = list(level)
        while waiting:
            i = waiting.pop()
            for child in nodes[i].get("children", ()):
                level[child] = level[i] + 1
                if level[child] > MAX_LEVELS:
                    raise self._nodes("they are nested more deeply")
                waiting.append(child)
        if len(level) < len(nodes):
            raise self._nodes("they form a circle")
        drawn = sum(self._elements(nodes[i]["mesh"]) for i in level if "mesh" in nodes[i])
        if drawn > self._limits.size:
            raise refused(ProblemCode.READ_RESULT_SIZE, self._path, f"{self._limits.size / 2**20:g} MiB")

    def _elements(self, mesh: int) -> int:
        """Bytes of the corners of a mesh as its indices will be held."""
        accessors = self._tree.get("accessors", [])
        return sum(8 * accessors[i]["count"] for i in self._corners(mesh))

    def _corners(self, mesh: int) -> Iterator[int]:
        for part in self._tree["meshes"][mesh]["primitives"]:
            yield part["indices"] if "indices" in part else part["attributes"]["POSITION"]

    def _nodes(self, why: str) -> RefusedError:
        return refused(ProblemCode.MESH_NODES, self._path, why, most=MAX_LEVELS)

    def _promised(self, what: str, value: object, room: int) -> None:
        raise refused(ProblemCode.MESH_SIZES, self._path, value, what=what, room=room)


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    """Return the text and the binary chunk of a .glb file."""

    def number(at: int) -> int:
        return int.from_bytes(data[at : at + 4], "little")

    if number(0) != _MAGIC:
        raise ValueError("no binary glTF")
    text, binary, at = b"", b"", _HEADER
    while at + _CHUNK_HEADER <= len(data):
        length, kind, at = number(at), number(at + 4), at + _CHUNK_HEADER
        if kind == _JSON_CHUNK and not text:
            text = data[at : at + length]
        elif kind == _BINARY_CHUNK and not binary:
            binary = data[at : at + length]
        at += length
    return text, binary
