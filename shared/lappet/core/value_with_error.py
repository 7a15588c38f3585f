"""A value and its estimated error as people read them."""

from __future__ import annotations

import math


def with_error(value: float, error: float | None) -> str:
    """Write a value as exactly as its error allows: the error with one digit, or two where the first is a 1.

    Parameters
    ----------
    value
        The value.
    error
        Its estimated error, or None.

    Returns
    -------
    str
        Value and error; the value alone with three digits where there is no error, below ten
        million without an exponent.
    """
    if error is None or not error > 0.0:
        rounded = float(f"{value:.3g}")
        return f"{rounded:.0f}" if 1e3 <= abs(rounded) < 1e7 else f"{value:.3g}"
    first = math.floor(math.log10(float(f"{error:.1e}")))
    digits = first - 1 if float(f"{error:.1e}") / 10.0**first < 1.95 else first
    shown = max(0, -digits)
    return f"{round(value, -digits):.{shown}f} ± {round(error, -digits):.{shown}f}"
