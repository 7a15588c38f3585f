"""The estimated errors of forces, tensions and seams against the true ones: a scene's finest solve is the truth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from lappet.solve.force_sums import force_sums
from lappet.solve.measures import FrameMeasures
from lappet.solve.seam_measures import SeamMeasure
from lappet.solve.suture_forces import SutureForce, closing_tension

FACTOR = 3.0  # that estimates must be within
FORCES = (
    "suture force",
    "sum of suture forces",
    "greatest suture force",
    "sum of a closure",
    "hook force",
    "closing tension",
)
"""The quantities that are forces."""

_OF_SEAM = (
    ("scar length", "mm", "scar_length_mm", "scar_length_error_mm"),
    ("gap", "mm", "greatest_gap_mm", "greatest_gap_error_mm"),
    ("step-off", "mm", "step_off_mm", "step_off_error_mm"),
    ("mismatch", "mm", "edge_mismatch_mm", "edge_mismatch_error_mm"),
    ("open area", "mm²", "open_area_mm2", "open_area_error_mm2"),
    ("dog-ear at the start", "mm", "start_dog_ear_mm", "start_dog_ear_error_mm"),
    ("dog-ear at the end", "mm", "end_dog_ear_mm", "end_dog_ear_error_mm"),
    ("closing tension", "N/mm", "tension_n_per_mm", "tension_error_n_per_mm"),
)


@dataclass(frozen=True)
class ValueRow:
    """A value in the last frame with its estimated and its true error.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing_mm
        Lattice spacing.
    quantity
        What it is.
    name
        Of which suture, hook or seam; empty where there is one in all.
    unit
        Its unit.
    value
        The value.
    estimate
        Its estimated error, or None.
    reference
        The value in the finest solve.
    uncertainty
        How far that is from the solve on twice its spacing.
    """

    scene: str
    spacing_mm: float
    quantity: str
    name: str
    unit: str
    value: float
    estimate: float | None
    reference: float
    uncertainty: float

    @property
    def error(self) -> float:
        """The true error."""
        return abs(self.value - self.reference)

    @property
    def is_judged(self) -> bool:
        """Whether the error is above the uncertainty of the reference."""
        return self.error > self.uncertainty


@dataclass(frozen=True)
class ValueGroup:
    """The values of a quantity in a scene at a spacing, those that can be judged.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing_mm
        Lattice spacing.
    quantity
        What they are.
    unit
        Their unit.
    count
        How many they are.
    value
        Their root mean square.
    error, error_max
        Root mean square and greatest error.
    estimate, estimate_max
        Root mean square and greatest estimate; None where one of them has none.
    """

    scene: str
    spacing_mm: float
    quantity: str
    unit: str
    count: int
    value: float
    error: float
    error_max: float
    estimate: float | None
    estimate_max: float | None

    @property
    def ratios(self) -> tuple[float, ...]:
        """Estimate over error, root mean square and greatest."""
        if self.estimate is None or self.estimate_max is None:
            return ()
        return self.estimate / self.error, self.estimate_max / self.error_max

    @property
    def is_within(self) -> bool:
        """Whether both are within a factor 3."""
        return bool(self.ratios) and all(1.0 / FACTOR <= each <= FACTOR for each in self.ratios)

    @property
    def is_too_small(self) -> bool:
        """Whether one is below a third of the error."""
        return any(each < 1.0 / FACTOR for each in self.ratios)


def value_rows(
    scene: str, spacing: float, found: FrameMeasures, references: tuple[FrameMeasures, FrameMeasures]
) -> list[ValueRow]:
    """List the values of a frame that its references have too.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing
        Lattice spacing in mm.
    found
        What is measured at the frame, with its estimated errors.
    references
        The same of the finest solve, and of that on twice its spacing.

    Returns
    -------
    list[ValueRow]
        The rows.
    """
    finest, coarser = (
        {(quantity, name, unit): value for quantity, name, unit, value, _ in _values(_alike(each, found))}
        for each in references
    )
    rows = []
    for quantity, name, unit, value, error in _values(found):
        key = (quantity, name, unit)
        if key in finest:
            off = abs(finest[key] - coarser[key]) if key in coarser else math.inf
            rows.append(ValueRow(scene, spacing, quantity, name, unit, value, error, finest[key], off))
    return rows


def groups_of(rows: Sequence[ValueRow]) -> list[ValueGroup]:
    """Group rows by scene, spacing and quantity; what cannot be judged is left out.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    list[ValueGroup]
        The groups.
    """
    found = []
    judged = [row for row in rows if row.is_judged]
    for key in dict.fromkeys((row.scene, row.spacing_mm, row.quantity, row.unit) for row in judged):
        own = [row for row in judged if (row.scene, row.spacing_mm, row.quantity, row.unit) == key]
        known = [row.estimate for row in own if row.estimate is not None]
        whole = len(known) == len(own)
        errors = [row.error for row in own]
        found.append(
            ValueGroup(
                *key,
                len(own),
                _rms([row.value for row in own]),
                _rms(errors),
                max(errors),
                _rms(known) if whole else None,
                max(known) if whole else None,
            )
        )
    return found


def _values(measures: FrameMeasures) -> Iterator[tuple[str, str, str, float, float | None]]:
    """Each quantity with its name, unit, value and estimated error."""
    for row in measures.sutures:
        if row.resolved:
            yield "suture force", row.suture, "mN", row.force_mn, row.force_error_mn
    if (sums := measures.sums) is not None and sums.greatest_suture is not None:
        yield "sum of suture forces", "", "mN", sums.total_mn, sums.total_error_mn
        yield "greatest suture force", "", "mN", sums.greatest_mn, sums.greatest_error_mn
        for closure in sums.closures:
            yield "sum of a closure", closure.closure, "mN", closure.total_mn, closure.total_error_mn
    for hook in measures.hooks:
        yield "hook force", hook.hook, "mN", hook.force_mn, hook.force_error_mn
    for state in measures.seams:
        for quantity, unit, value, error in _OF_SEAM:
            found = getattr(state.measure, value)
            if found is not None:
                yield quantity, state.measure.seam, unit, found, getattr(state.measure, error)
    if (tension := measures.mean_tension) is not None:
        yield "mean tension", "", "kPa", tension.tension, tension.error


def _alike(reference: FrameMeasures, found: FrameMeasures) -> FrameMeasures:
    """The measures of a reference without the sutures that another lattice does not resolve."""
    kept = {row.suture for row in found.sutures if row.resolved}
    rows = tuple(replace(row, resolved=row.resolved and row.suture in kept) for row in reference.sutures)
    seams = tuple(replace(state, measure=_pulled(state.measure, state.closures, rows)) for state in reference.seams)
    return replace(reference, sutures=rows, seams=seams, sums=force_sums(rows, seams) if rows else None)


def _pulled(measure: SeamMeasure, closures: Sequence[str], rows: Sequence[SutureForce]) -> SeamMeasure:
    own = [row for row in rows if row.closure in closures]
    return replace(measure, tension_n_per_mm=closing_tension(own, measure.scar_length_mm))


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / len(values))


def shares(groups: Sequence[ValueGroup]) -> Mapping[str, tuple[int, int, int]]:
    """Count the groups of each quantity.

    Parameters
    ----------
    groups
        The groups.

    Returns
    -------
    Mapping[str, tuple[int, int, int]]
        By quantity: how many lie within the factor, below a third of the error, and are there in all.
    """
    return {
        quantity: (
            sum(each.is_within for each in groups if each.quantity == quantity),
            sum(each.is_too_small for each in groups if each.quantity == quantity),
            sum(each.quantity == quantity for each in groups),
        )
        for quantity in dict.fromkeys(each.quantity for each in groups)
    }
