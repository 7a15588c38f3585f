"""Muscles: strands of fibers in the tissue at rest, from an origin to an insertion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lappet.procedure.exact_values import Point, set_fields, single_points


@dataclass(frozen=True)
class Strand:
    """A part of a muscle: a sweep along a curve, along which its fibers run.

    Parameters
    ----------
    points
        Its course from the origin to the insertion in mm, shape (n, 3), kept in single precision, n at least 2.
    radii
        Radius at each point in mm, shape (n,), kept in single precision, at least 0.
    """

    points: tuple[Point, ...]
    radii: tuple[float, ...]

    def __post_init__(self) -> None:
        radii = tuple(float(np.float32(radius)) for radius in self.radii)
        set_fields(self, points=single_points(self.points), radii=radii)


@dataclass(frozen=True)
class Muscle:
    """A muscle in the tissue at rest (`LappetMuscleAPI`): all that one of its strands holds.

    It is of its own material, whose fibers and active muscle run along the strands and come together where a strand
    tapers. Where several muscles hold a place, that in which it lies deepest counts, by its radius there.

    Parameters
    ----------
    name
        Name of the muscle, unique among the muscles.
    strands
        Its strands, one or more.
    material
        Name of its material; `Material.muscle_activation` says when it is active.
    """

    name: str
    strands: tuple[Strand, ...]
    material: str

    def __post_init__(self) -> None:
        set_fields(self, strands=tuple(self.strands))
