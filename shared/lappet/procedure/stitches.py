"""The usual stitches as lists of bites of one thread, and how long it is when the lips of the wound just meet.

A stitch is made at a place on the wound, in the direction across it. All but the running suture are loops: their thread
is tied where it begins. In the tissue it runs straight down from the skin, straight across at its depth, and up again.

Usual distances:

- Vertical mattress: the far bites 4 to 8 mm from the edge; horizontal mattress: bites 4 to 8 mm from the edge, the
  second 4 to 8 mm along the wound (Zuber 2002, Am. Fam. Physician 66:2231). The middle of each is the default.
- Simple and running sutures: on head and neck neither 2 against 5 mm from the edge (10.1016/j.jaad.2021.10.036) nor 2
  against 5 mm from each other (Sklar et al., trial NCT03330041) made a difference in the scars; 4 mm from the edge is
  *chosen* between them, for buried stitches too.
- Near bites 1.5 mm from the edge and 1 mm deep: *chosen*.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lappet.procedure.events import Suture
from lappet.procedure.exact_values import Point, double_point

BITE = 4.0
"""Distance of a bite from the edge of the wound in mm."""

FAR, NEAR, SHALLOW = 6.0, 1.5, 1.0
"""Distances of the far and the near bites of a vertical mattress suture from the edge, and depth of the near, in mm."""

MATTRESS, ALONG = 6.0, 6.0
"""Distance of the bites of a horizontal mattress suture from the edge, and from each other along it, in mm."""


class StitchPlace(Protocol):
    """A place on a wound at which a stitch is made."""

    def bite(self, side: int, distance: float, depth: float = 0.0, along: float = 0.0) -> Bite:
        """Find a point of the tissue beside the wound.

        Parameters
        ----------
        side
            -1 or 1: before or behind the wound, in the direction across it.
        distance
            Distance from its edge in mm.
        depth
            Depth below the skin in mm.
        along
            How far along the wound in mm.

        Returns
        -------
        Bite
            The point.
        """
        ...


@dataclass(frozen=True)
class Station:
    """A place on a wound at rest.

    Parameters
    ----------
    spot
        The middle of the wound there, on the skin, in mm.
    across
        Direction across the wound, of any length.
    outward
        Normal of the skin, of any length.
    gap
        Width of the wound at rest in mm.
    """

    spot: Point
    across: Point
    outward: Point = (0.0, 0.0, 1.0)
    gap: float = 0.0

    def bite(self, side: int, distance: float, depth: float = 0.0, along: float = 0.0) -> Bite:
        """Find a point of the tissue beside the wound.

        Parameters
        ----------
        side
            -1 or 1: before or behind the wound, in the direction across it.
        distance
            Distance from its edge in mm.
        depth
            Depth below the skin in mm.
        along
            How far along the wound in mm.

        Returns
        -------
        Bite
            The point in mm at rest, and where it is when the lips meet at the middle of the wound.
        """
        outward = np.asarray(self.outward, np.float64) / math.hypot(*self.outward)
        across = np.asarray(self.across, np.float64)
        across = across - (across @ outward) * outward
        across /= np.linalg.norm(across)
        closed = np.asarray(self.spot) + side * distance * across - depth * outward
        closed += along * np.cross(outward, across)
        return Bite(closed + 0.5 * side * self.gap * across, closed)


@dataclass(frozen=True, eq=False)
class Bite:
    """A point of the tissue that a stitch holds.

    Parameters
    ----------
    rest
        The point in mm at rest, shape (3,).
    closed
        Where it is in mm when the lips of the wound meet, shape (3,).
    """

    rest: NDArray[np.float64]
    closed: NDArray[np.float64]


@dataclass(frozen=True)
class Stitch:
    """The bites of a thread.

    Parameters
    ----------
    bites
        Material points in mm in the order of the thread.
    length
        Length of the thread in mm when the lips of the wound just meet.
    """

    bites: tuple[Point, ...]
    length: float

    def suture(self, name: str, start: float, drawn: float = 1.0, **values: Any) -> Suture:
        """Make the event.

        Soft tissue gives way where a bite holds it, so a thread of the stitch's length leaves the wound open a little:
        in skin of 50 kPa threads that are drawn to 0.85 to 0.95 of it close an ellipse of 30 x 2.4 mm.

        Parameters
        ----------
        name
            Its name.
        start
            Time code at which it begins to be drawn.
        drawn
            Share of the stitch's length to which it is drawn.
        **values
            Other values of `Suture`, as `thread="nylon 5-0"`.

        Returns
        -------
        Suture
            A thread.
        """
        return Suture(name, self.bites, start, mode="thread", length=drawn * self.length, **values)


def simple(at: StitchPlace, bite: float = BITE, depth: float = 0.0) -> Stitch:
    """Make a simple interrupted stitch: across the wound in the tissue and back over it.

    Parameters
    ----------
    at
        Where.
    bite
        Distance of the bites from the edge in mm.
    depth
        Depth in which it crosses in mm; 0: two bites on the skin and no more.

    Returns
    -------
    Stitch
        The stitch.
    """
    crossing = _through(at, bite, depth)
    return _stitch(_tied(crossing) if depth > 0.0 else crossing)


def vertical_mattress(
    at: StitchPlace, depth: float, far: float = FAR, near: float = NEAR, shallow: float = SHALLOW
) -> Stitch:
    """Make a vertical mattress stitch, far-far-near-near: deep across the wound and back just below the skin.

    Parameters
    ----------
    at
        Where.
    depth
        Depth of the far pass in mm.
    far
        Distance of the far bites from the edge in mm.
    near
        That of the near bites.
    shallow
        Depth of the near pass in mm.

    Returns
    -------
    Stitch
        The stitch.
    """
    return _stitch(_tied([*_through(at, far, depth), *reversed(_through(at, near, shallow))]))


def horizontal_mattress(at: StitchPlace, depth: float, bite: float = MATTRESS, along: float = ALONG) -> Stitch:
    """Make a horizontal mattress stitch: across the wound, along its edge on the skin, and back across it.

    Parameters
    ----------
    at
        Where; its middle.
    depth
        Depth in which it crosses in mm.
    bite
        Distance of the bites from the edge in mm.
    along
        Distance of the two passes in mm.

    Returns
    -------
    Stitch
        The stitch.
    """
    first, second = _through(at, bite, depth, -0.5 * along), _through(at, bite, depth, 0.5 * along)
    return _stitch(_tied([*first, *reversed(second)]))


def half_buried_mattress(at: StitchPlace, depth: float, bite: float = MATTRESS, along: float = ALONG) -> Stitch:
    """Make a half-buried horizontal mattress stitch: behind the wound it stays in the tissue, as in the tip of a flap.

    Parameters
    ----------
    at
        Where; `across` points to the side on which the thread does not come out.
    depth
        Depth in which it crosses and runs along the wound in mm.
    bite
        Distance of the bites from the edge in mm.
    along
        Distance of the two passes in mm.

    Returns
    -------
    Stitch
        The stitch.
    """
    first, second = _through(at, bite, depth, -0.5 * along), _through(at, bite, depth, 0.5 * along)
    return _stitch(_tied([*first[:3], *reversed(second[:3])]))


def deep_dermal(at: StitchPlace, depth: float, shallow: float = SHALLOW, bite: float = BITE) -> Stitch:
    """Make a buried stitch: up on one side, across, down on the other and tied below.

    Parameters
    ----------
    at
        Where.
    depth
        Depth of the knot in mm.
    shallow
        Depth of the upper pass in mm.
    bite
        Distance of the bites from the edge in mm.

    Returns
    -------
    Stitch
        The stitch.
    """
    corners = [(-1, depth), (-1, shallow), (1, shallow), (1, depth)]
    return _stitch(_tied([at.bite(side, bite, below) for side, below in corners]))


def figure_of_eight(at: StitchPlace, depth: float, bite: float = BITE, along: float = ALONG) -> Stitch:
    """Make a figure-of-eight: two passes from one side to the other, whose threads cross above the wound.

    Parameters
    ----------
    at
        Where; its middle.
    depth
        Depth in which it crosses in mm.
    bite
        Distance of the bites from the edge in mm.
    along
        Distance of the two passes in mm.

    Returns
    -------
    Stitch
        The stitch.
    """
    passes = [_through(at, bite, depth, place) for place in (-0.5 * along, 0.5 * along)]
    return _stitch(_tied([*passes[0], *passes[1]]))


def running(stations: Sequence[StitchPlace], bite: float = BITE, depth: float = 0.0) -> Stitch:
    """Make a running suture: the same pass at each place, one thread over the wound from each to the next.

    Parameters
    ----------
    stations
        Where, in order along the wound; at least one.
    bite
        Distance of the bites from the edge in mm.
    depth
        Depth in which it crosses in mm; 0: two bites on the skin at each place.

    Returns
    -------
    Stitch
        The stitch, open at its ends.
    """
    return _stitch([place for at in stations for place in _through(at, bite, depth)])


def _through(at: StitchPlace, bite: float, depth: float, along: float = 0.0) -> list[Bite]:
    """A pass across the wound: in, down, across, up and out; at no depth from one side to the other."""
    corners = [(-1, 0.0), (-1, depth), (1, depth), (1, 0.0)] if depth > 0.0 else [(-1, 0.0), (1, 0.0)]
    return [at.bite(side, bite, below, along) for side, below in corners]


def _tied(bites: list[Bite]) -> list[Bite]:
    return [*bites, bites[0]]


def _stitch(bites: Sequence[Bite]) -> Stitch:
    length = sum((float(np.linalg.norm(a.closed - b.closed)) for a, b in pairwise(bites)), 0.0)
    return Stitch(tuple(double_point(bite.rest.tolist()) for bite in bites), length)
