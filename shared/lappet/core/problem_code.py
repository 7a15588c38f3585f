"""The code of every problem: what code compares, stores and sends, whatever the wording."""

from __future__ import annotations

from enum import StrEnum, unique


@unique
class ProblemCode(StrEnum):
    """What kind of problem it is. A value never changes its meaning; its texts are in `core/texts/`."""

    UNSORTED = "unsorted"
    INTERNAL = "internal"
