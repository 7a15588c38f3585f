"""How much one turn on the main thread may do: Blender answers between two turns."""

from __future__ import annotations

from time import monotonic

SECONDS = 0.012


class Turn:
    """Costly pieces are begun only while there is time, the first one always, so that every turn gets on.

    unfinished: whether a piece was put off to the next turn.
    """

    def __init__(self, soon: bool) -> None:
        """soon: for somebody who looks on; otherwise it takes as long as it takes."""
        self.until = monotonic() + SECONDS if soon else None
        self.unfinished = False
        self._begun = False

    def begins(self, costly: bool = True) -> bool:
        """Whether a piece may be begun now; one that is not costly always may."""
        if not costly or self.until is None:
            return True
        if self._begun and monotonic() > self.until:
            self.unfinished = True
            return False
        self._begun = True
        return True
