"""What is measured at solved operations, each number with its estimated error."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.output.solve_to_cache import SolveResult
from lappet.reports.literature.operations import BESIDE, CENTRAL_LIMB, LIMB, LIPS, SCAR_ENDS
from lappet.solve.coarse_program import RATIO
from lappet.solve.measure_errors import FORCE_ORDER
from lappet.solve.seam_measures import SeamMeasure

LAID_OPEN = 7.0  # time code at which a wound is excised and undermined, before its first suture


@dataclass(frozen=True)
class Measured:
    """A number with its error.

    Parameters
    ----------
    value
        The number.
    error
        Its estimated error; None without one.
    """

    value: float
    error: float | None = None

    def per(self, other: Measured) -> Measured:
        """Divide by another number; errors add as shares.

        Parameters
        ----------
        other
            The other number.

        Returns
        -------
        Measured
            The quotient; not a number over zero.
        """
        if other.value == 0.0:
            return Measured(math.nan)
        quotient = self.value / other.value
        if self.error is None or other.error is None:
            return Measured(quotient)
        return Measured(quotient, (self.error + abs(quotient) * other.error) / abs(other.value))

    def minus(self, other: Measured) -> Measured:
        """Subtract another number; errors add.

        Parameters
        ----------
        other
            The other number.

        Returns
        -------
        Measured
            The difference.
        """
        known = self.error is not None and other.error is not None
        return Measured(self.value - other.value, (self.error or 0.0) + (other.error or 0.0) if known else None)

    def times(self, factor: float) -> Measured:
        """Multiply by an exact number.

        Parameters
        ----------
        factor
            The number.

        Returns
        -------
        Measured
            The product.
        """
        return Measured(self.value * factor, None if self.error is None else self.error * abs(factor))


def closing_share(held: SolveResult, freed: SolveResult) -> Measured:
    """Divide the closing force of an operation by that of another, with the error of the quotient as one quantity.

    The lattice costs both forces much the same, and of the quotient only what it costs one more than the other is left:
    the quotient is taken on both lattices, and its error reckoned from the two values as that of a force is
    (`lappet.solve.measure_errors`), at least what the relative errors of the two forces differ by. Two lattices may
    agree by chance: with 2.67, 2 and 1.33 mm undermining skin of the trunk leaves 0.911, 0.931 and 0.905 of the force.
    So the geometric mean with the sum of the two errors is taken, as of a force with that of its displacements.

    Parameters
    ----------
    held
        The operation whose force is divided by.
    freed
        The other one.

    Returns
    -------
    Measured
        The quotient; with the errors of both forces added where a lattice resolves no suture.
    """
    forces, shares = (closing_force(freed), closing_force(held)), (_coarse_share(freed), _coarse_share(held))
    quotient = forces[0].per(forces[1])
    if quotient.error is None or not (shares[0] and shares[1]):
        return quotient
    apart = abs(math.log(shares[0] / shares[1]))
    found = 1.0 - math.exp(-apart / (RATIO**FORCE_ORDER - 1.0))
    own, other = ((force.error or 0.0) / force.value for force in forces)
    return Measured(quotient.value, quotient.value * math.sqrt(max(found, abs(own - other)) * (own + other)))


def _coarse_share(result: SolveResult) -> float | None:
    """The closing force on the coarse lattice over that on the lattice, at the end."""
    sums = result.measures[-1].sums
    return None if sums is None else sums.coarse_share


@dataclass(frozen=True)
class Measure:
    """How a number is measured.

    Parameters
    ----------
    operations
        The operations at which, of `lappet.reports.literature.operations`.
    of
        Takes their solves in this order and gives the number.
    """

    operations: tuple[str, ...]
    of: Callable[..., Measured]


def closing_force(result: SolveResult) -> Measured:
    """Sum up the forces of all sutures at the end, without those that the lattice does not resolve.

    Parameters
    ----------
    result
        A solve.

    Returns
    -------
    Measured
        The sum in N.
    """
    sums = result.measures[-1].sums
    if sums is None:
        return Measured(math.nan)
    return Measured(sums.total_mn, sums.total_error_mn).times(1e-3)


def greatest_of(result: SolveResult, closure: str, *, others: bool = False) -> Measured:
    """Take the greatest force of a suture of a closure at the end.

    Parameters
    ----------
    result
        A solve.
    closure
        What its name has in it.
    others
        Whether all other closures are meant instead.

    Returns
    -------
    Measured
        The force in mN.
    """
    sums = result.measures[-1].sums
    rows = [row for row in (sums.closures if sums else ()) if (closure in row.closure) is not others]
    if not rows:
        return Measured(math.nan)
    most = max(rows, key=lambda row: row.greatest_mn)
    return Measured(most.greatest_mn, most.greatest_error_mn)


def greatest_in_middle(result: SolveResult, closure: str, width: float) -> Measured:
    """Take the greatest force of a suture in the middle of closures at the end.

    Parameters
    ----------
    result
        A solve.
    closure
        What the names of the closures have in them.
    width
        Length of the middle at rest in mm.

    Returns
    -------
    Measured
        The force in mN.
    """
    rows = [row for row in result.measures[-1].sutures if closure in row.closure and row.resolved]
    ends = {row.closure: max(each.along_mm for each in rows if each.closure == row.closure) for row in rows}
    inside = [row for row in rows if abs(row.along_mm - 0.5 * ends[row.closure]) <= 0.5 * width]
    if not inside:
        return Measured(math.nan)
    most = max(inside, key=lambda row: row.force_mn)
    return Measured(most.force_mn, most.force_error_mn)


def scar_length(result: SolveResult) -> Measured:
    """Add up the lengths of the scars at the end.

    Parameters
    ----------
    result
        A solve.

    Returns
    -------
    Measured
        The length in mm.
    """
    return _summed(_seams(result, result.frames[-1].solved.time), "scar_length_mm", "scar_length_error_mm")


def designed_arc(result: SolveResult) -> Measured:
    """Take the length of a wound's lip as it was drawn: half of what was excised is bounded by it.

    Parameters
    ----------
    result
        A solve.

    Returns
    -------
    Measured
        The mean of both lips in mm, exact.
    """
    seams = _seams(result, result.frames[-1].solved.time)
    return Measured(sum(0.5 * (row.first_edge_at_rest_mm + row.second_edge_at_rest_mm) for row in seams), 0.0)


def wound_area(result: SolveResult) -> Measured:
    """Measure how large the wound is before it is sutured.

    Parameters
    ----------
    result
        A solve.

    Returns
    -------
    Measured
        Its area in mm².
    """
    return _summed(_seams(result, LAID_OPEN), "open_area_mm2", "open_area_error_mm2")


def dog_ear(result: SolveResult) -> Measured:
    """Measure the higher of the dog-ears at the end.

    Parameters
    ----------
    result
        A solve.

    Returns
    -------
    Measured
        Its height in mm; not a number where the skin's rim is too near.
    """
    found = [
        Measured(height, error)
        for row in _seams(result, result.frames[-1].solved.time)
        for height, error in (
            (row.start_dog_ear_mm, row.start_dog_ear_error_mm),
            (row.end_dog_ear_mm, row.end_dog_ear_error_mm),
        )
        if height is not None
    ]
    return max(found, key=lambda each: each.value, default=Measured(math.nan))


def scar_gain(result: SolveResult) -> Measured:
    """Measure by how much the skin along a Z-plasty's first scar has lengthened.

    Parameters
    ----------
    result
        Its solve.

    Returns
    -------
    Measured
        Per cent of the limb.
    """
    (first, last), errors = _landmarks(result, SCAR_ENDS)
    gained = Measured(float(np.linalg.norm(last - first)) - LIMB - 2.0 * BESIDE, sum(errors) if errors else None)
    return gained.times(100.0 / LIMB)


def limb_turn(result: SolveResult) -> Measured:
    """Measure the angle by which a Z-plasty's central limb has turned from its first scar, which ran along x.

    Parameters
    ----------
    result
        Its solve.

    Returns
    -------
    Measured
        The angle in degrees, 0 to 90.
    """
    (first, last), errors = _landmarks(result, CENTRAL_LIMB)
    along = (last - first)[:2]
    length = float(np.linalg.norm(along))
    angle = float(np.degrees(np.arctan2(abs(along[1]), abs(along[0]))))
    return Measured(angle, float(np.degrees(sum(errors) / length)) if errors else None)


def gape(result: SolveResult) -> Measured:
    """Measure how far the middles of a cut's lips are apart at the end.

    Parameters
    ----------
    result
        Its solve.

    Returns
    -------
    Measured
        The distance in mm.
    """
    (first, last), errors = _landmarks(result, LIPS)
    return Measured(float(np.linalg.norm(last - first)), sum(errors) if errors else None)


def _landmarks(result: SolveResult, label: str) -> tuple[NDArray[np.float64], list[float]]:
    """Places of the points of a landmark in the last frame, and their errors, or none without an estimate."""
    solved = result.frames[-1].solved
    names = [result.program.landmarks[index] for index in solved.landmark_index]
    rows = [row for row, name in enumerate(names) if name.startswith(label)]
    estimate = result.errors.frames[-1] if result.errors is not None else None
    errors = [estimate.landmarks[row] for row in rows] if estimate is not None else []
    return np.asarray(solved.landmarks, float)[rows], errors


def _seams(result: SolveResult, time: float) -> list[SeamMeasure]:
    return [row for row in result.seams if row.time == time]


def _summed(rows: list[SeamMeasure], value: str, error: str) -> Measured:
    errors = [getattr(row, error) for row in rows]
    known = None if any(each is None for each in errors) else float(sum(errors))
    return Measured(float(sum(getattr(row, value) for row in rows)), known)
