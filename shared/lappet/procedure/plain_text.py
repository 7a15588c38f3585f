"""Numbers and places as texts for people have them."""

from __future__ import annotations

from lappet.procedure.exact_values import Point


def number(value: float) -> str:
    """Write a number with four significant digits.

    Parameters
    ----------
    value
        The number.

    Returns
    -------
    str
        Its text.
    """
    return f"{value:.4g}"


def place(point: Point) -> str:
    """Write a point.

    Parameters
    ----------
    point
        The point, mm.

    Returns
    -------
    str
        Its coordinates in brackets.
    """
    return "(" + ", ".join(number(v) for v in point) + ")"
