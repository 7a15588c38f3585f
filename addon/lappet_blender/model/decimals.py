"""Blender's properties are single precision; a procedure is made of the decimals that its author typed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def decimal(value: float) -> float:
    """The shortest decimal that has this value in single precision: 0.05 for what Blender gives as 0.05000000075."""
    return float(str(np.float32(value))) + 0.0  # + 0.0: there is no negative zero


def decimals(values: Iterable[float]) -> tuple[float, ...]:
    """`decimal` of each."""
    return tuple(decimal(value) for value in values)
