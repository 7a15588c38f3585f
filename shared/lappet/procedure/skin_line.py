"""Lines of the skin: along them its fibers run and its tension is greatest."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.procedure.cuts import Basis
from lappet.procedure.exact_values import Point, set_fields, single_points


@dataclass(frozen=True)
class SkinLine:
    """A line of the skin at rest (`LappetSkinLineAPI`).

    Between the lines of a procedure direction and tension change smoothly (`lappet.tissue.skin_lines`).

    Parameters
    ----------
    name
        Name of the line, unique among the lines.
    points
        Control points of the curve in mm, shape (n, 3), kept in single precision, on the skin or near it.
    tension
        In-vivo tension along and across the line in kPa of true stress; None for the prestretch of the tissue's
        material.
    basis
        How the curve runs through or beside its points, as USD's `basis`.
    """

    name: str
    points: tuple[Point, ...]
    tension: tuple[float, float] | None = None
    basis: Basis = "linear"

    def __post_init__(self) -> None:
        tension = None if self.tension is None else tuple(float(value) for value in self.tension)
        set_fields(self, points=single_points(self.points), tension=tension)
