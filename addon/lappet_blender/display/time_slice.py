"""How much the display may draw at a time on the main thread: Blender answers its user between two slices."""

from __future__ import annotations

from time import monotonic
from typing import Protocol

SECONDS = 0.012


class Awaited(Protocol):
    """What a thread makes (`MadeSoon`)."""

    @property
    def done(self) -> bool:
        """Whether it is made."""


class TimeSlice:
    """Costly pieces are begun only while there is time; the first one always is, so that every slice makes progress.

    unfinished: whether a piece was put off to the next slice. waits_for: what the next slice has to wait for.
    """

    def __init__(self, soon: bool) -> None:
        """soon: somebody is looking on; otherwise the slice has no end."""
        self.until = monotonic() + SECONDS if soon else None
        self.unfinished = False
        self.waits_for: list[Awaited] = []
        self._begun = False

    @property
    def soon(self) -> bool:
        """Whether somebody is looking on."""
        return self.until is not None

    def has(self, made: Awaited) -> bool:
        """Whether a value that is made on a thread is there; waited for where nobody looks on, else put off."""
        if made.done or not self.soon:
            return True
        self.unfinished = True
        self.waits_for.append(made)
        return False

    def begins(self, costly: bool = True) -> bool:
        """Whether a piece may be begun now; one that is not costly always may."""
        if not costly or self.until is None:
            return True
        if self._begun and monotonic() > self.until:
            self.unfinished = True
            return False
        self._begun = True
        return True
