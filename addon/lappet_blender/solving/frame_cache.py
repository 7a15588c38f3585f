"""Frames in memory: those used last stay within a bound of bytes; the rest is read from the store again.

Reading ahead runs on a thread of its own, so that scrubbing finds the neighbors in memory.
"""

from __future__ import annotations

import contextlib
import threading
from collections import OrderedDict
from collections.abc import Sequence

from lappet.daemon.solved_frame import SolvedFrame
from lappet.solve.store import FrameStore

LIMIT = 512 << 20


class FrameCache:
    """Shown frames by content key. limit: bytes of arrays. Every method may be called from any thread."""

    def __init__(self, limit: int = LIMIT) -> None:
        self.limit = limit
        self.bytes = 0
        self._frames: OrderedDict[str, SolvedFrame] = OrderedDict()
        self._lock = threading.Lock()
        self._wanted: list[str] = []
        self._store: FrameStore | None = None
        self._wake = threading.Event()
        self._reader: threading.Thread | None = None
        self._closed = False

    def __contains__(self, key: str) -> bool:
        return key in self._frames

    def get(self, key: str, store: FrameStore) -> SolvedFrame | None:
        """The frame of a key, from memory or from the store; None where neither holds it."""
        with self._lock:
            found = self._frames.get(key)
            if found is not None:
                self._frames.move_to_end(key)
                return found
        read = _read(store, key)
        if read is not None:
            self.put(key, read)
        return read

    def put(self, key: str, frame: SolvedFrame) -> None:
        """Keep a frame; those used longest ago go when the bound is passed, but never this one."""
        size = frame.nbytes
        with self._lock:
            old = self._frames.pop(key, None)
            self.bytes += size - (0 if old is None else old.nbytes)
            self._frames[key] = frame
            while self.bytes > self.limit and len(self._frames) > 1:
                _, gone = self._frames.popitem(last=False)
                self.bytes -= gone.nbytes

    def drop(self, key: str) -> None:
        """Drop a frame; one that is not there is no error."""
        with self._lock:
            gone = self._frames.pop(key, None)
            if gone is not None:
                self.bytes -= gone.nbytes

    def clear(self) -> None:
        """Drop every frame."""
        with self._lock:
            self._frames.clear()
            self._wanted = []
            self.bytes = 0

    def read_ahead(self, keys: Sequence[str], store: FrameStore) -> None:
        """Have these frames read in this order, in place of those that were wanted before; return at once."""
        missing = [key for key in keys if key not in self._frames]
        with self._lock:
            self._wanted, self._store = missing, store
        if not missing:
            return
        if self._reader is None:
            self._reader = threading.Thread(target=self._read_on, name="lappet frames", daemon=True)
            self._reader.start()
        self._wake.set()

    def close(self) -> None:
        """End the reading thread until something is to be read ahead again."""
        if self._reader is not None:
            self._closed = True
            self._wake.set()
            self._reader.join(timeout=2.0)
            self._reader, self._closed = None, False

    def _read_on(self) -> None:
        while not self._closed:
            with self._lock:
                key = self._wanted.pop(0) if self._wanted else None
                store = self._store
            if key is None or store is None:
                self._wake.wait()
                self._wake.clear()
                continue
            if key not in self._frames:
                frame = _read(store, key)
                if frame is not None:
                    self.put(key, frame)


def _read(store: FrameStore, key: str) -> SolvedFrame | None:
    with contextlib.suppress(OSError):
        frame = store.get(key, SolvedFrame)
        return None if frame is None else frame.shown()
    return None
