"""Vessels and nerves: curves in the tissue at rest that move with it, are cut with it and are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast, get_args

from lappet.procedure.cuts import Basis
from lappet.procedure.exact_values import Point, set_fields, single_points

VesselKind = Literal["artery", "vein", "nerve", "lymphatic"]
# How atlases of anatomy color them, linear RGB: arteries red, veins blue, nerves yellow, lymphatics green.
VESSEL_COLORS: dict[str, tuple[float, float, float]] = {
    "artery": (0.62, 0.022, 0.018),
    "vein": (0.045, 0.10, 0.42),
    "nerve": (0.88, 0.62, 0.06),
    "lymphatic": (0.06, 0.36, 0.10),
}
VESSEL_KINDS = cast(tuple[VesselKind, ...], get_args(VesselKind))


@dataclass(frozen=True)
class Vessel:
    """A vessel or nerve in the tissue at rest (`LappetVesselAPI`).

    It has no stiffness of its own: it lies in the tissue, moves with it and is divided where an incision crosses it.

    Parameters
    ----------
    name
        Name of the vessel, unique among the vessels.
    points
        Control points of its course in mm, shape (n, 3), kept in single precision, in the tissue or on its surface.
    kind
        One of `VESSEL_KINDS`: how it is drawn and what reports call it.
    radius
        Outer radius in mm, above 0: how thick it is drawn.
    label
        What pictures and reports call it; its name where nothing is given.
    typical_course
        Whether the course is that of a textbook and not this patient's.
    basis
        How the curve runs through or beside its points, as USD's `basis`.
    """

    name: str
    points: tuple[Point, ...]
    kind: VesselKind = "artery"
    radius: float = 0.5
    label: str = ""
    typical_course: bool = False
    basis: Basis = "linear"

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points), radius=float(self.radius))

    @property
    def title(self) -> str:
        """What a sentence calls it: its label, or its name."""
        return self.label or self.name
