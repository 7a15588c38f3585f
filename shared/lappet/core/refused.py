"""Work that is refused, with one sentence that names the thing, its value and the remedy."""

from __future__ import annotations


class RefusedError(ValueError):
    """What was asked makes no sense or cannot be done; the message is the sentence that the user reads."""
