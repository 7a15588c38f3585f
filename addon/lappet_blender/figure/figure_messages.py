"""What a process that draws says on standard output: one JSON object a line."""

from __future__ import annotations

import json
import os
from typing import Protocol


class Say(Protocol):
    """Says a message."""

    def __call__(self, **message: object) -> None:
        """Write the message's line."""


def messages() -> Say:
    """Keep standard output for messages; what Blender prints there goes to standard error from now on."""
    lines = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
    os.dup2(2, 1)

    def say(**message: object) -> None:
        lines.write(json.dumps(message) + "\n")
        lines.flush()

    return say
