"""Numbers with more digits than Blender's properties hold, kept beside these, so that frames keep their keys.

A design that divides a seam evenly gives 1.8234237920817506 mm between its stitches; the property gives back 1.8234237.
The number counts as long as the property holds what was made of it.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np

from .decimals import decimal

_KEY = "lappet_exact"


def keep_exact(item: Any, value: Any) -> None:
    """Keep what the numbers of a value (a dataclass) have beyond single precision in an item, in place of others."""
    numbers = {field.name: getattr(value, field.name) for field in fields(value)}
    exact = {name: each for name, each in numbers.items() if isinstance(each, float) and math.isfinite(each)}
    # What single precision holds is from another property, which means its decimal.
    exact = {name: each for name, each in exact.items() if each not in (decimal(each), float(np.float32(each)))}
    if _KEY in item:
        del item[_KEY]
    if exact:
        item[_KEY] = exact


def with_exact(item: Any, value: Any) -> Any:
    """A value that was read from an item, with the numbers that it keeps, but for those that were changed since."""
    kept = item.get(_KEY)
    if not kept:
        return value
    own = {name: float(each) for name, each in kept.items() if getattr(value, name, None) == decimal(each)}
    return replace(value, **own) if own else value
