"""A frame store that keeps in memory what the disk does not take, so that a full disk costs no solve."""

from __future__ import annotations

import threading
from collections import OrderedDict
from pathlib import Path

from lappet.solve.store import FrameStore, Value, unpack_as

MAX_BYTES = 1 << 30


class KeptFrames(FrameStore):
    """A store for several threads that holds in memory the frames that cannot be written; the oldest go first.

    Parameters
    ----------
    folder
        Folder of the frames; the user's store when None.
    max_bytes
        The most that is held in memory.
    """

    def __init__(self, folder: Path | None = None, max_bytes: int = MAX_BYTES) -> None:
        super().__init__(folder)
        self._max_bytes = max_bytes
        self._held: OrderedDict[str, bytes] = OrderedDict()  # as packed
        self._held_bytes = 0
        self._guard = threading.RLock()

    def try_again(self) -> None:
        """Try the disk again: it may have room by now."""
        with self._guard:
            self.trouble = None

    def holds(self, key: str) -> bool:
        """Tell whether a frame is in memory, where no other process finds it.

        Parameters
        ----------
        key
            Content key.

        Returns
        -------
        bool
            Whether it is.
        """
        return key in self._held

    def __contains__(self, key: str) -> bool:
        return key in self._held or super().__contains__(key)

    def get(self, key: str, kind: type[Value]) -> Value | None:
        """Look up a value in memory and on the disk.

        Parameters
        ----------
        key
            Content key.
        kind
            Dataclass that it is of.

        Returns
        -------
        Value | None
            The value, or None where neither holds it.
        """
        with self._guard:
            held = self._held.get(key)
        return super().get(key, kind) if held is None else unpack_as(held, kind)

    def put_packed(self, key: str, packed: bytes) -> bool:
        """Keep a value on the disk, else in memory.

        Parameters
        ----------
        key
            Content key.
        packed
            The value as `lappet.core.value_codec.pack` wrote it.

        Returns
        -------
        bool
            Whether the disk took it.
        """
        with self._guard:
            if super().put_packed(key, packed):
                return True
            if key not in self._held:
                self._held[key] = packed
                self._held_bytes += len(packed)
            while self._held_bytes > self._max_bytes and len(self._held) > 1:
                self._held_bytes -= len(self._held.popitem(last=False)[1])
            return False
