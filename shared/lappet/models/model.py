"""A model of the catalogue: what part of the body it is and what its tissue is made of."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.models.cleft import Cleft
from lappet.models.region import Ellipsoid
from lappet.procedure import Point


@dataclass(frozen=True)
class Depth:
    """A thickness with its source.

    Parameters
    ----------
    mm
        The thickness in mm.
    source
        A key of `SOURCES`, or `CHOSEN`.
    how
        How it follows from the source; why it was chosen.
    """

    mm: float
    source: str
    how: str


@dataclass(frozen=True)
class Trial:
    """The fusiform excision with which a model is tried.

    Parameters
    ----------
    at
        Its middle on the neutral body in mm, on the skin or near it.
    along
        Direction of its long axis.
    length
        Length in mm; it is a third as wide.
    beyond
        How far beyond the wound the skin is undermined, as a share of its length: less beside a rim.
    """

    at: Point
    along: Point
    length: float
    beyond: float = 0.35


@dataclass(frozen=True)
class Model:
    """A row of the catalogue. Places are those of the neutral body: x to the patient's right, y to the front, z up, mm.

    Parameters
    ----------
    name
        What the command line and Blender call it.
    title
        What it shows, in a few words.
    region
        Which skin belongs to it.
    skin
        Thickness of the skin.
    fat
        Thickness of what the tissue has below the skin, down to the plane in which flaps are raised.
    preset
        Name of the preset of the skin.
    bed
        A key of `lappet.tissue.bed.BEDS`.
    spacing
        Edge of the lattice's cells in mm by default.
    subdivision
        How often the faces of the base mesh are divided.
    lines
        Families of skin lines, keys of `lappet.models.skin_line_plans.FAMILIES`.
    trial
        The excision with which it was tried.
    surround
        Lowest and highest corner of what of the body is shown around it, in mm.
    female
        Whether it is a woman's unless told otherwise.
    units
        What its skin is divided into, a key of `lappet.models.subunits.UNITS`; empty for nothing.
    cleft
        The cleft of its lip; None for none.
    """

    name: str
    title: str
    region: Ellipsoid
    skin: Depth
    fat: Depth
    preset: str
    bed: str
    spacing: float
    subdivision: int
    lines: tuple[str, ...]
    trial: Trial
    surround: tuple[Point, Point]
    female: bool = False
    units: str = ""
    cleft: Cleft | None = None

    @property
    def thickness(self) -> float:
        """Thickness of the tissue in mm."""
        return self.skin.mm + self.fat.mm
