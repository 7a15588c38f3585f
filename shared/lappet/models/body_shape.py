"""How old, of which sex and how heavy a body is, and what else of its shape is changed.

The weights are MakeHuman's own: its four ages are 1, 10, 25 and 90 years, linear between; its three ancestries are
mixed in equal parts; muscle, height and proportions are average.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_mesh import body_mesh, target

AGES = (("baby", 1.0), ("child", 10.0), ("young", 25.0), ("old", 90.0))
_ANCESTRIES = ("caucasian", "asian", "african")
_WEIGHTS = (("minweight", 0.0), ("averageweight", 0.5), ("maxweight", 1.0))


@dataclass(frozen=True)
class BodyShape:
    """The shape of a body.

    Parameters
    ----------
    age
        Age in years, 1 to 90.
    sex
        0 for female, 1 for male, anything between for a mixture.
    weight
        0 for the lightest, 0.5 for the average, 1 for the heaviest.
    targets
        Names of shape targets with how much of each, 0 for nothing and 1 for all of it.
    """

    age: float = 25.0
    sex: float = 0.5
    weight: float = 0.5
    targets: tuple[tuple[str, float], ...] = ()


NEUTRAL = BodyShape()


def shaped(shape: BodyShape) -> NDArray[np.float64]:
    """Give the base mesh a shape.

    Parameters
    ----------
    shape
        The shape.

    Returns
    -------
    NDArray[np.float64]
        Vertices in mm, shape (n, 3).

    Raises
    ------
    RefusedError
        If a value is outside its range, a target is unknown, or the package is not there.
    """
    for name, value, low, high in (
        ("age", shape.age, AGES[0][1], AGES[-1][1]),
        ("sex", shape.sex, 0.0, 1.0),
        ("weight", shape.weight, 0.0, 1.0),
        *((name, value, -1.0, 2.0) for name, value in shape.targets),
    ):
        if not (np.isfinite(value) and low <= value <= high):
            raise refused(ProblemCode.MODEL_PARAMETER, name, f"{value:g}", name=name, low=f"{low:g}", high=f"{high:g}")
    points = body_mesh().points.copy()
    for sex, share in (("female", 1.0 - shape.sex), ("male", shape.sex)):
        for age, years in _between(AGES, shape.age):
            for ancestry in _ANCESTRIES:
                points += _part(share * years / len(_ANCESTRIES), f"macrodetails/{ancestry}-{sex}-{age}")
            for weight, pounds in _between(_WEIGHTS, shape.weight):
                points += _part(share * years * pounds, f"macrodetails/universal-{sex}-{age}-averagemuscle-{weight}")
    for name, value in shape.targets:
        points += _part(value, name)
    return points


def _between(stops: Sequence[tuple[str, float]], value: float) -> list[tuple[str, float]]:
    """The names of the stops on both sides of a value with their shares, which add up to 1."""
    places = np.array([place for _, place in stops])
    k = int(np.clip(np.searchsorted(places, value) - 1, 0, len(stops) - 2))
    share = float((value - places[k]) / (places[k + 1] - places[k]))
    return [(stops[k][0], 1.0 - share), (stops[k + 1][0], share)]


def _part(share: float, name: str) -> NDArray[np.float64]:
    return np.zeros(3) if share == 0.0 else share * target(name)


def target_amount(text: str) -> tuple[str, float]:
    """Read a shape target with its amount.

    Parameters
    ----------
    text
        Such as `nose/nose-hump-incr=0.5`.

    Returns
    -------
    tuple[str, float]
        Name and amount.

    Raises
    ------
    RefusedError
        If there is no amount.
    """
    name, _, amount = text.partition("=")
    try:
        return name, float(amount)
    except ValueError:
        raise refused(ProblemCode.MODEL_TARGET_TEXT, "target", text) from None
