"""Fit the orders of convergence that the estimate reckons with to the rows of a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from lappet.reports.error_estimate.measured_values import FACTOR
from lappet.reports.error_estimate.measurement import EstimateRow
from lappet.solve.coarse_program import RATIO

# What is tried: beyond the limits of every order that the estimate reckons with, in steps of what rows can tell.
LEAST, GREATEST, STEP = 0.5, 3.0, 0.05


@dataclass(frozen=True)
class FittedOrder:
    """The order that would have served the rows of one order best.

    Parameters
    ----------
    order
        Order that the rows were reckoned with.
    best
        Order with which most of them lie within a factor 3, nearest to the truth in the mean of logarithms among
        equals.
    rows
        Number of rows that can be judged.
    within
        How many lie within a factor 3.
    within_best
        How many would with the best order.
    too_small
        How many lie below a third of the true error.
    too_small_best
        How many would with the best order.
    """

    order: float
    best: float
    rows: int
    within: int
    within_best: int
    too_small: int
    too_small_best: int


def fit_orders(rows: Sequence[EstimateRow]) -> list[FittedOrder]:
    """Fit an order to all rows that were reckoned with the same one.

    Estimates are taken to be of the lattice alone, (u_h - u_2h) / (2^p - 1), as they are but for a few percent.

    Parameters
    ----------
    rows
        What was measured.

    Returns
    -------
    list[FittedOrder]
        One per order, rising.
    """
    fitted = []
    for order in sorted({row.order for row in rows if row.order is not None}):
        judged = [row.ratios for row in rows if row.order == order and row.ratios]
        tried = [LEAST + STEP * index for index in range(round((GREATEST - LEAST) / STEP) + 1)]
        best = max(tried, key=lambda p, order=order, judged=judged: _merit(judged, _scale(order, p)))  # type: ignore[misc]
        scale = _scale(order, best)
        within, low = [[count(judged, each) for each in (1.0, scale)] for count in (_within, _too_small)]
        fitted.append(FittedOrder(order, best, len(judged), *within, *low))
    return fitted


def _scale(order: float, other: float) -> float:
    """What an estimate is multiplied with when another order is reckoned with."""
    return (RATIO**order - 1.0) / (RATIO**other - 1.0)


def _merit(judged: Sequence[tuple[float, ...]], scale: float) -> tuple[int, float]:
    """How many rows lie within the factor, and the mean square distance from the truth, negative."""
    logs = [math.log(scale * each) for ratios in judged for each in ratios]
    return _within(judged, scale), -sum(each * each for each in logs)


def _within(judged: Sequence[tuple[float, ...]], scale: float) -> int:
    return sum(all(1.0 / FACTOR <= scale * each <= FACTOR for each in ratios) for ratios in judged)


def _too_small(judged: Sequence[tuple[float, ...]], scale: float) -> int:
    return sum(any(scale * each < 1.0 / FACTOR for each in ratios) for ratios in judged)
