"""The frame store: solved frames by content key, in files that are written whole or not at all.

A file holds the magic, a checksum of the rest, the length of a JSON header, the header, and the arrays one after
another:

    magic (8) | BLAKE2b-256 of what follows (32) | header bytes (8, little-endian) | header | array | array | ...

The header is {"header": any JSON object, "arrays": [{"name", "dtype", "shape"}, ...]}. An entry that does not fit its
checksum counts as absent. Several processes may use one store at once.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import re
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode

DEFAULT_LIMIT = 4 << 30
_MAGIC = b"LAPPETF1"
_CHECKSUM = 32
_KEY = re.compile(r"[0-9a-f]{16,128}")
_SUFFIX = ".frame"
_STALE_SECONDS = 3600.0
_DTYPES = frozenset({"<f4", "<f8", "<i4", "<i8", "|u1"})


@dataclass(frozen=True, eq=False)
class StoredFrame:
    """What is kept of a frame.

    Parameters
    ----------
    header
        Any JSON object.
    arrays
        Arrays by name, of the kinds f4, f8, i4, i8 or u1 and of any shape.
    """

    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)


def default_folder() -> Path:
    """Find the store's folder: `LAPPET_STORE` where that is set, else `frames` in the user's cache folder.

    Returns
    -------
    Path
        The folder; it may not exist yet.
    """
    named = os.environ.get("LAPPET_STORE")
    if named:
        return Path(named).expanduser()
    from platformdirs import user_cache_path

    return user_cache_path("lappet", appauthor=False) / "frames"


class FrameStore:
    """A content-addressed store of frames, bounded in size; what has not been used for longest goes first.

    Trouble with the disk (full, read-only) never raises: the store stops writing and `trouble` says why.

    Parameters
    ----------
    folder
        Folder of the frames, made when the first is written; `default_folder()` where it is None.
    limit
        Greatest size in bytes.
    """

    def __init__(self, folder: Path | None = None, limit: int = DEFAULT_LIMIT) -> None:
        self.folder = default_folder() if folder is None else Path(folder)
        self.limit = limit
        self.trouble: Problem | None = None
        self._bytes: int | None = None

    def path(self, key: str) -> Path:
        """Find the file of a key.

        Parameters
        ----------
        key
            Content key.

        Returns
        -------
        Path
            The file; it may not exist.

        Raises
        ------
        ValueError
            If the key is not lower-case hexadecimal.
        """
        if not _KEY.fullmatch(key):
            raise ValueError(f"{key!r} is not a content key; give 16 to 128 lower-case hexadecimal digits.")
        return self.folder / key[:2] / (key + _SUFFIX)

    def __contains__(self, key: str) -> bool:
        return self.path(key).is_file()

    def get(self, key: str) -> StoredFrame | None:
        """Look up a frame.

        Parameters
        ----------
        key
            Content key.

        Returns
        -------
        StoredFrame | None
            The frame, or None where it is absent, unreadable or damaged (a damaged file is removed).
        """
        path = self.path(key)
        try:
            data = path.read_bytes()
        except OSError:
            return None
        frame = _unpack(data)
        with contextlib.suppress(OSError):
            if frame is None:
                path.unlink()
            else:
                os.utime(path)
        return frame

    def put(self, key: str, frame: StoredFrame) -> bool:
        """Keep a frame.

        Parameters
        ----------
        key
            Content key.
        frame
            The frame.

        Returns
        -------
        bool
            Whether the disk took it; where it did not, `trouble` says why.

        Raises
        ------
        TypeError
            If JSON cannot hold the header.
        ValueError
            If an array is of another kind.
        """
        path = self.path(key)
        data = _pack(frame)
        if self.trouble is not None:
            return False
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            before = _size(path)
            handle, name = tempfile.mkstemp(prefix=".writing-", dir=path.parent)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(data)
                Path(name).replace(path)
            except BaseException:
                with contextlib.suppress(OSError):
                    Path(name).unlink()
                raise
        except OSError as error:
            self.trouble = problem(ProblemCode.STORE_NOT_WRITABLE, self.folder, error.strerror or error)
            return False
        if self._bytes is not None:
            self._bytes += len(data) - before
        if self._bytes is None or self._bytes > self.limit:
            self._prune(keep=path)
        return True

    def size(self) -> int:
        """Measure the store.

        Returns
        -------
        int
            The bytes of all frames in it.
        """
        return sum(size for _, size, _ in self._entries())

    def _entries(self) -> list[tuple[float, int, Path]]:
        """(time of last use, bytes, file) of every frame; files that vanish meanwhile are left out."""
        found = []
        for path in self.folder.glob(f"??/*{_SUFFIX}"):
            with contextlib.suppress(OSError):
                status = path.stat()
                found.append((status.st_mtime, status.st_size, path))
        return found

    def _prune(self, keep: Path) -> None:
        """Remove the frames used longest ago until nine tenths of the limit are kept, and what crashed writers left."""
        entries = sorted(self._entries(), key=lambda entry: entry[0])
        total = sum(size for _, size, _ in entries)
        if total > self.limit:
            for _, size, path in entries:
                if total <= 0.9 * self.limit:
                    break
                if path != keep:
                    with contextlib.suppress(OSError):
                        path.unlink()
                        total -= size
        self._bytes = total
        long_ago = time.time() - _STALE_SECONDS
        for path in self.folder.glob("??/.writing-*"):
            with contextlib.suppress(OSError):
                if path.stat().st_mtime < long_ago:
                    path.unlink()


def _size(path: Path) -> int:
    """Bytes; 0 for a file that is not there, or that another process takes away meanwhile."""
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return 0


def _pack(frame: StoredFrame) -> bytes:
    described, payload = [], []
    for name, value in frame.arrays.items():
        array = np.ascontiguousarray(value)
        array = array.astype(array.dtype.newbyteorder("<"), copy=False)
        kind = array.dtype.str
        if kind not in _DTYPES:
            raise ValueError(f"The array {name!r} is of the kind {kind}, which a stored frame cannot hold.")
        described.append({"name": name, "dtype": kind, "shape": list(np.shape(value))})
        payload.append(array.tobytes())
    head = json.dumps({"header": frame.header, "arrays": described}).encode()
    body = b"".join([len(head).to_bytes(8, "little"), head, *payload])
    return _MAGIC + hashlib.blake2b(body, digest_size=_CHECKSUM).digest() + body


def _unpack(data: bytes) -> StoredFrame | None:
    start = len(_MAGIC) + _CHECKSUM
    body = data[start:]
    checksum = hashlib.blake2b(body, digest_size=_CHECKSUM).digest()
    if not data.startswith(_MAGIC) or data[len(_MAGIC) : start] != checksum:
        return None
    length = int.from_bytes(body[:8], "little")
    head = json.loads(body[8 : 8 + length])
    offset = 8 + length
    arrays = {}
    for described in head["arrays"]:
        dtype, shape = np.dtype(described["dtype"]), tuple(described["shape"])
        count = math.prod(shape)
        # A copy, so that it is aligned: what lies at an odd offset some libraries refuse.
        arrays[described["name"]] = np.array(np.frombuffer(body, dtype, count, offset).reshape(shape))
        offset += count * dtype.itemsize
    return StoredFrame(head["header"], arrays)
