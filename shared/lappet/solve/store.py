"""The frame store: solved frames, and what is shown besides, by content key, in files that are whole or not there.

A file holds the magic, a checksum of the rest, and the value as `lappet.core.value_codec` writes it:

    magic (16) | BLAKE2b-256 of what follows (32) | value

An entry that does not fit its checksum, or holds no such value, counts as absent. Several processes may use one store
at once.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import tempfile
import time
from pathlib import Path
from typing import TypeVar

from lappet.core.array_codec import Bytes, CodecError
from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack, unpack

DEFAULT_LIMIT = 4 << 30
_MAGIC = b"LAPPET FRAMES 2\n"  # with the checksum a multiple of 16: arrays are read in place
_CHECKSUM = 32
_KEY = re.compile(r"[0-9a-f]{16,128}")
_SUFFIX = ".frame"
_STALE_SECONDS = 3600.0

Value = TypeVar("Value")


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

    def get(self, key: str, kind: type[Value]) -> Value | None:
        """Look up a value.

        A damaged file is removed.

        Parameters
        ----------
        key
            Content key.
        kind
            Dataclass that it is of.

        Returns
        -------
        Value | None
            The value, or None where it is absent, of another class, unreadable or damaged; its arrays are read-only.
        """
        path = self.path(key)
        try:
            data = path.read_bytes()
        except OSError:
            return None
        body = _checked(data)
        with contextlib.suppress(OSError):
            if body is None:
                path.unlink()
            else:
                os.utime(path)
        return None if body is None else unpack_as(body, kind)

    def put(self, key: str, value: object) -> bool:
        """Keep a value.

        Parameters
        ----------
        key
            Content key.
        value
            A value of dataclasses, arrays, numbers, text and tuples of these.

        Returns
        -------
        bool
            Whether the disk took it; where it did not, `trouble` says why.

        Raises
        ------
        CodecError
            If it cannot be written.
        """
        return self.put_packed(key, pack(value))

    def put_packed(self, key: str, packed: bytes) -> bool:
        """Keep a value that `lappet.core.value_codec.pack` has written.

        Parameters
        ----------
        key
            Content key.
        packed
            The value.

        Returns
        -------
        bool
            Whether the disk took it.
        """
        path = self.path(key)
        data = _MAGIC + hashlib.blake2b(packed, digest_size=_CHECKSUM).digest() + packed
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


def _checked(data: bytes) -> memoryview | None:
    """Return the value's bytes in a file's, or None where they do not fit their checksum."""
    start = len(_MAGIC) + _CHECKSUM
    body = memoryview(data)[start:]
    checksum = hashlib.blake2b(body, digest_size=_CHECKSUM).digest()
    return body if data.startswith(_MAGIC) and data[len(_MAGIC) : start] == checksum else None


def unpack_as(packed: Bytes, kind: type[Value]) -> Value | None:
    """Read a value from its bytes.

    Parameters
    ----------
    packed
        The bytes.
    kind
        Dataclass that it is of.

    Returns
    -------
    Value | None
        The value, or None where it is of another class.
    """
    try:
        value: Value = unpack(packed, kind)
    except CodecError:
        return None
    return value
