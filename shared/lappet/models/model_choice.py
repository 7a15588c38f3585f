"""What may be chosen of a model, and the ranges of its values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_shape import BodyShape

SKIN_RANGE = (0.3, 5.0)
SPACING_RANGE = (0.05, 20.0)
REACH_RANGE = (0.5, 3.0)


@dataclass(frozen=True)
class ModelChoice:
    """What may be chosen of a model.

    Parameters
    ----------
    shape
        The shape of the body; None for the model's usual one.
    skin
        Thickness of the skin in mm; None for the model's.
    laxity
        How slack the skin is: 0 for the tension of its preset, 1 for none.
    spacing
        Edge of the lattice's cells in mm; None for the model's.
    scenery
        Whether the body around the tissue is shown.
    excision
        Whether the model comes with a fusiform excision, undermined and closed.
    deep
        Whether it has the layer below its fat as well: SMAS, fascia, muscle or cartilage.
    reach
        How many times as far as usual the tissue reaches in each direction.
    """

    shape: BodyShape | None = None
    skin: float | None = None
    laxity: float = 1.0
    spacing: float | None = None
    scenery: bool = True
    excision: bool = False
    deep: bool = False
    reach: float = 1.0


def checked(name: str, value: float, low: float, high: float) -> float:
    """Refuse a value outside its range.

    Parameters
    ----------
    name
        What it is.
    value
        The value.
    low
        Least value.
    high
        Greatest value.

    Returns
    -------
    float
        The value.

    Raises
    ------
    RefusedError
        If it is outside, or not finite.
    """
    if not (np.isfinite(value) and low <= value <= high):
        raise refused(ProblemCode.MODEL_PARAMETER, name, f"{value:g}", name=name, low=f"{low:g}", high=f"{high:g}")
    return value
