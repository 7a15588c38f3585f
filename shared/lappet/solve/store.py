"""The frame store: solved frames, and what is shown besides, by content key, in files that are whole or not there.

A file holds the magic, a keyed hash of its own key and the value, and that as `lappet.core.value_codec` writes it:

    magic (16) | BLAKE2b-256 (32) | value

The hash is keyed with a secret that the store's folder holds and only its owner can read, so what others wrote, or what
belongs to another key, is no frame. An entry that does not fit its hash, that is no regular file of the user's own, or
that a link leads to, counts as absent and is removed. Several processes may use one store at once.
"""

from __future__ import annotations

import contextlib
import hashlib
import hmac
import os
import re
import stat
import tempfile
import time
from pathlib import Path
from typing import TypeVar

from lappet.core.array_codec import Bytes, CodecError
from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack, unpack
from lappet.solve.own_files import is_folder, is_own_file, own_folder, own_secret, own_subfolder, read_own, remove

DEFAULT_LIMIT = 4 << 30
FOLDER_VARIABLE = "LAPPET_STORE"
_MAGIC = b"LAPPET FRAMES 3\n"  # with the hash a multiple of 16: arrays are read in place
_HASH = 32
_SECRET = "secret"
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
    named = os.environ.get(FOLDER_VARIABLE)
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
        self._known_secret: bytes | None = None

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
        path = self.path(key)
        return is_folder(path.parent) and is_own_file(path)

    def get(self, key: str, kind: type[Value]) -> Value | None:
        """Look up a value.

        A file that is damaged, or not the user's own, is removed.

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
        body = self._checked(key)
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
        if self.trouble is not None:
            return False
        try:
            data = _MAGIC + _hash(key, packed, self._secret()) + packed
            own_subfolder(path.parent)
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

    def copy(self, key: str, target: FrameStore) -> bool:
        """Keep in another store what this one holds.

        Parameters
        ----------
        key
            Content key.
        target
            The other store.

        Returns
        -------
        bool
            Whether that took it; where its disk did not, its `trouble` says why.
        """
        body = self._checked(key)
        return body is not None and target.put_packed(key, bytes(body))

    def _secret(self) -> bytes:
        """What the hashes are keyed with. Raises OSError where the folder is not the user's own."""
        if self._known_secret is None:
            own_folder(self.folder)
            self._known_secret = own_secret(self.folder / _SECRET)
        return self._known_secret

    def _checked(self, key: str) -> memoryview | None:
        """The value's bytes of a key, or None where there are none to be trusted; what is there instead is removed."""
        path = self.path(key)
        if not self.folder.is_dir():
            return None
        try:
            secret = self._secret()
        except OSError:
            return None
        if not is_folder(path.parent):
            remove(path.parent)
            return None
        data = read_own(path)
        if data is None:
            return None
        start = len(_MAGIC) + _HASH
        body = memoryview(data)[start:]
        if not data.startswith(_MAGIC) or not hmac.compare_digest(data[len(_MAGIC) : start], _hash(key, body, secret)):
            remove(path)
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return body

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
        for path in self._files():
            with contextlib.suppress(OSError):
                status = path.lstat()
                if path.suffix == _SUFFIX and stat.S_ISREG(status.st_mode):
                    found.append((status.st_mtime, status.st_size, path))
        return found

    def _files(self) -> list[Path]:
        """What lies in the folders of the frames; folders that a link leads to are not the store's."""
        found: list[Path] = []
        with contextlib.suppress(OSError):
            for folder in self.folder.iterdir():
                if len(folder.name) == 2 and is_folder(folder):
                    with contextlib.suppress(OSError):  # another process takes it away
                        found += folder.iterdir()
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
        for path in self._files():
            with contextlib.suppress(OSError):
                if path.name.startswith(".writing-") and path.lstat().st_mtime < long_ago:
                    path.unlink()


def _size(path: Path) -> int:
    """Bytes; 0 for a file that is not there, or that another process takes away meanwhile."""
    try:
        return path.lstat().st_size
    except FileNotFoundError:
        return 0


def _hash(key: str, packed: Bytes, secret: bytes) -> bytes:
    made = hashlib.blake2b(f"{key}\n".encode(), digest_size=_HASH, key=secret)
    made.update(packed)
    return made.digest()


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
