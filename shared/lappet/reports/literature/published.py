"""A number that a paper measured, what the program gives for the same, and whether the two agree."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from lappet.reports.literature.measured import Measure


class Verdict(StrEnum):
    """Whether a number of the program agrees with a published one."""

    AGREES = "agrees"
    WITHIN_ERROR = "within its error"
    UNCERTAIN = "too uncertain"
    DISAGREES = "disagrees"
    NOT_SOLVED = "not solved"


@dataclass(frozen=True)
class Published:
    """A published number, and how the program measures the same.

    Parameters
    ----------
    name
        Name of the row.
    quantity
        What it is.
    unit
        Its unit; empty for a ratio.
    least, most
        What was published; infinite where it has no bound on that side.
    source
        The paper.
    there
        What was measured there, and in what.
    here
        What is measured here, and where the two differ by their making.
    measure
        How it is measured, and in which operations.
    why
        What is known of the reason why they disagree; shown where they do.
    """

    name: str
    quantity: str
    unit: str
    least: float
    most: float
    source: str
    there: str
    here: str
    measure: Measure
    why: str = ""

    @property
    def range_text(self) -> str:
        """The published range as text, with its unit."""
        if math.isinf(self.least):
            text = f"at most {self.most:g}"
        elif math.isinf(self.most):
            text = f"at least {self.least:g}"
        else:
            text = f"{self.least:g}" if self.least == self.most else f"{self.least:g} to {self.most:g}"
        return f"{text} {self.unit}".strip()

    def verdict(self, value: float | None, error: float | None) -> Verdict:
        """Compare what the program gives with what was published.

        Parameters
        ----------
        value
            What the program gives; None where an operation was not solved to its end.
        error
            Its estimated error; None without one.

        Returns
        -------
        Verdict
            Whether they agree.
        """
        if value is None or math.isnan(value):
            return Verdict.NOT_SOLVED
        low, high = value - (error or 0.0), value + (error or 0.0)
        if self.least <= low and high <= self.most:
            return Verdict.AGREES
        if high < self.least or self.most < low:
            return Verdict.DISAGREES
        if high - low > 2.0 * abs(value):
            return Verdict.UNCERTAIN
        return Verdict.AGREES if self.least <= value <= self.most else Verdict.WITHIN_ERROR
