"""What a report takes for the truth: Richardson extrapolation from three halvings, with its own uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEAST_ORDER, GREATEST_ORDER = 0.8, 2.5


@dataclass(frozen=True, eq=False)
class Reference:
    """Positions that errors are measured against.

    Parameters
    ----------
    points
        Positions in mm, shape (s, 3).
    order
        Order observed between the three spacings.
    uncertainty
        Root mean square of how far the extrapolation may be off in mm.
    uncertainty_max
        Greatest of it in mm.
    """

    points: NDArray[np.float64]
    order: float
    uncertainty: float
    uncertainty_max: float


def rms(vectors: NDArray[np.floating]) -> float:
    """Compute the root mean square length of vectors.

    Parameters
    ----------
    vectors
        Vectors, shape (s, 3).

    Returns
    -------
    float
        The length.
    """
    return float(np.sqrt(np.mean(np.einsum("ij,ij->i", vectors, vectors)))) if len(vectors) else 0.0


def greatest(vectors: NDArray[np.floating]) -> float:
    """Compute the greatest length of vectors.

    Parameters
    ----------
    vectors
        Vectors, shape (s, 3).

    Returns
    -------
    float
        The length.
    """
    return float(np.sqrt(np.max(np.einsum("ij,ij->i", vectors, vectors)))) if len(vectors) else 0.0


def richardson(coarse: NDArray[np.float64], middle: NDArray[np.float64], fine: NDArray[np.float64]) -> Reference:
    """Extrapolate the limit of positions at three spacings: fine + (fine - middle) / (2^p - 1).

    p is observed from the three (Roache 1994, J Fluids Eng 116:405) and kept within 0.8 to 2.5; where it falls outside,
    the positions do not converge regularly and the whole last difference is the uncertainty, else what is added.

    Parameters
    ----------
    coarse
        Positions at the spacing 4h in mm, shape (s, 3).
    middle
        Positions at 2h in mm, shape (s, 3).
    fine
        Positions at h in mm, shape (s, 3).

    Returns
    -------
    Reference
        The limit with its uncertainty.
    """
    first, second = rms(middle - coarse), rms(fine - middle)
    observed = math.log2(first / second) if first > 0.0 and second > 0.0 else GREATEST_ORDER
    order = min(max(observed, LEAST_ORDER), GREATEST_ORDER)
    added = (fine - middle) / (2.0**order - 1.0)
    regular = observed >= LEAST_ORDER
    off = added if regular or rms(added) > second else fine - middle
    return Reference(fine + added, observed, rms(off), greatest(off))


def observed_orders(spacings: Sequence[float], errors: Sequence[float]) -> list[float]:
    """Compute the orders between one spacing and the next finer one: log(e1 / e2) / log(h1 / h2).

    Parameters
    ----------
    spacings
        Spacings h.
    errors
        Errors e.

    Returns
    -------
    list[float]
        The orders.
    """
    pairs = zip(spacings, spacings[1:], errors, errors[1:], strict=False)
    return [math.log(e1 / e2) / math.log(h1 / h2) if e1 > 0.0 and e2 > 0.0 else math.nan for h1, h2, e1, e2 in pairs]


def fitted_order(spacings: Sequence[float], errors: Sequence[float]) -> float:
    """Fit the order over all spacings by least squares of the logarithms.

    Parameters
    ----------
    spacings
        Spacings.
    errors
        Errors.

    Returns
    -------
    float
        The order.
    """
    return float(np.polyfit(np.log(spacings), np.log(np.maximum(errors, 1e-300)), 1)[0])
