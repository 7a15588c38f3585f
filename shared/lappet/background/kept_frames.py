"""A frame store that keeps in memory what the disk does not take, so that a full disk costs no solve."""

from __future__ import annotations

import threading
from collections import OrderedDict
from pathlib import Path

from lappet.solve.store import FrameStore, StoredFrame

MOST_BYTES = 1 << 30


class KeptFrames(FrameStore):
    """A store for several threads that holds in memory the frames that cannot be written; the oldest go first.

    Parameters
    ----------
    folder
        Folder of the frames; the user's store when None.
    most_bytes
        The most that is held in memory.
    """

    def __init__(self, folder: Path | None = None, most_bytes: int = MOST_BYTES) -> None:
        super().__init__(folder)
        self._most_bytes = most_bytes
        self._held: OrderedDict[str, StoredFrame] = OrderedDict()
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

    def get(self, key: str) -> StoredFrame | None:
        """Look up a frame in memory or on the disk.

        Parameters
        ----------
        key
            Content key.

        Returns
        -------
        StoredFrame | None
            The frame, or None.
        """
        with self._guard:
            held = self._held.get(key)
        return super().get(key) if held is None else held

    def put(self, key: str, frame: StoredFrame) -> bool:
        """Keep a frame on the disk, else in memory.

        Parameters
        ----------
        key
            Content key.
        frame
            The frame.

        Returns
        -------
        bool
            Whether the disk took it.
        """
        with self._guard:
            if super().put(key, frame):
                return True
            if key not in self._held:
                self._held[key] = frame
                self._held_bytes += _size(frame)
            while self._held_bytes > self._most_bytes and len(self._held) > 1:
                self._held_bytes -= _size(self._held.popitem(last=False)[1])
            return False


def _size(frame: StoredFrame) -> int:
    return sum(array.nbytes for array in frame.arrays.values())
