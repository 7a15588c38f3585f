"""What a surgeon measures at a closed wound: how its lips meet, how long the scar is, how it pulls, and its dog-ears.

At every place along a seam the offset from its first lip to its second one has three parts: the gap, across the seam in
the skin; the step-off, along the skin's normal; and the mismatch, along the seam.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.triangles import area_normals, directions
from lappet.geometry.wound_edges import EdgePlace, WoundEdges
from lappet.program.program import Program
from lappet.solve.dog_ear import DogEar, dog_ear_at
from lappet.solve.seams import Lip, Seam, seams_of
from lappet.solve.suture_forces import SutureForce, closing_tension

CLOSED = 0.5
"""Chosen: lips meet where no more than this is open between them in mm …"""

NEAR = 5.0
"""… and what should meet is no farther apart than this in mm. Beyond, a lip is elsewhere: a flap's before it moves."""

_BAND = 3.0  # mm of skin beside a lip whose normal counts (chosen: more than the lip's own rolling in)


@dataclass(frozen=True)
class SeamMeasure:
    """A seam in one frame, a row of the table.

    Parameters
    ----------
    time
        Time code.
    seam
        Name of the seam, that of its closure nearest to the skin's outer side.
    scar_length_mm
        Length of the line midway between its lips.
    first_edge_mm, second_edge_mm
        Lengths of its lips.
    first_edge_at_rest_mm, second_edge_at_rest_mm
        Their lengths at rest.
    edge_difference_mm
        The difference of these, which the sutures distribute along the seam.
    greatest_gap_mm
        The widest that the lips are apart; negative where they overlap everywhere.
    open_area_mm2
        Area of the wound between the lips that is still open.
    closed_share
        Share of the seam's length at which the lips meet, by `CLOSED` and `NEAR`.
    edge_mismatch_mm
        How far, at most, what should meet lies apart along the seam, where the lips meet; None where they do nowhere.
    step_off_mm
        How much higher, at most, one lip is than the other, where they meet; None where they do nowhere.
    start_dog_ear_mm, end_dog_ear_mm
        How far the skin at its ends stands above the surface around; None near the tissue's rim.
    force_mn
        What its sutures draw its lips together with, all closures together, without those that the lattice does not
        resolve.
    tension_n_per_mm
        That per length of the scar; None while no suture that the lattice resolves is placed.
    scar_length_error_mm, greatest_gap_error_mm, open_area_error_mm2, edge_mismatch_error_mm, step_off_error_mm
        Estimated errors of these; None without an estimate, or where there is no value.
    start_dog_ear_error_mm, end_dog_ear_error_mm, force_error_mn, tension_error_n_per_mm
        Likewise.
    """

    time: float
    seam: str
    scar_length_mm: float
    first_edge_mm: float
    second_edge_mm: float
    first_edge_at_rest_mm: float
    second_edge_at_rest_mm: float
    edge_difference_mm: float
    greatest_gap_mm: float
    open_area_mm2: float
    closed_share: float
    edge_mismatch_mm: float | None
    step_off_mm: float | None
    start_dog_ear_mm: float | None
    end_dog_ear_mm: float | None
    force_mn: float
    tension_n_per_mm: float | None
    scar_length_error_mm: float | None = None
    greatest_gap_error_mm: float | None = None
    open_area_error_mm2: float | None = None
    edge_mismatch_error_mm: float | None = None
    step_off_error_mm: float | None = None
    start_dog_ear_error_mm: float | None = None
    end_dog_ear_error_mm: float | None = None
    force_error_mn: float | None = None
    tension_error_n_per_mm: float | None = None


@dataclass(frozen=True, eq=False)
class SeamState:
    """A seam in one frame, place by place.

    Parameters
    ----------
    measure
        What it comes to.
    closures
        Names of its closures, that of the leading one first.
    points
        The line midway between its lips in mm, shape (`lappet.solve.seams.SAMPLES`, 3).
    gap
        How far the lips are apart across it in mm, negative where they overlap, shape (SAMPLES,).
    step
        How much higher the second lip is than the first in mm, shape (SAMPLES,).
    mismatch
        How far the second lip lies ahead of the first along the seam in mm, shape (SAMPLES,).
    """

    measure: SeamMeasure
    closures: tuple[str, ...]
    points: NDArray[np.float64]
    gap: NDArray[np.float64]
    step: NDArray[np.float64]
    mismatch: NDArray[np.float64]

    @property
    def meets(self) -> NDArray[np.bool_]:
        """Where the lips meet, by `CLOSED` and `NEAR`, shape (SAMPLES,)."""
        return _meet(self.gap, self.step, self.mismatch)


class SeamGauges:
    """Measure seams, with what of an epoch that needs, which is found once.

    Parameters
    ----------
    program
        The program.
    """

    def __init__(self, program: Program) -> None:
        self._sutures = program.stitches
        self._surfaces = {epoch.index: epoch.surface for epoch in program.epochs} if program.stitches else {}
        self._epochs = {each.time: each.epoch for each in program.frames}
        self._gauges: dict[int, list[_Gauge]] = {}

    def measure(self, frame: SolvedFrame, forces: Sequence[SutureForce]) -> list[SeamState]:
        """Measure the seams of a frame.

        Parameters
        ----------
        frame
            The frame.
        forces
            The forces on its sutures.

        Returns
        -------
        list[SeamState]
            Each seam whose tissue is cut along it.
        """
        if not self._surfaces:
            return []
        epoch = self._epochs[frame.time]
        if epoch not in self._gauges:
            surface = self._surfaces[epoch]
            edges = WoundEdges(surface)
            found = seams_of(self._sutures, surface, edges)
            self._gauges[epoch] = [_Gauge(surface, edges, seam) for seam in found]
        return [gauge.measure(frame, forces) for gauge in self._gauges[epoch]]


class _Gauge:
    """What of an epoch a seam's measures need: bands of skin beside the lips, and the skin around the ends."""

    def __init__(self, surface: Surface, edges: WoundEdges, seam: Seam) -> None:
        self._seam = seam
        self._bands = [_band(surface, edges, lip) for lip in seam.lips]
        nodes = [lip.nodes(surface.points) for lip in seam.lips]
        self._at_rest = [_length(each) for each in nodes]
        ends = [np.mean([each[k] for each in nodes], axis=0) for k in (0, -1)]
        self._dog_ears: list[DogEar | None] = [dog_ear_at(surface, edges, end) for end in ends]

    def measure(self, frame: SolvedFrame, forces: Sequence[SutureForce]) -> SeamState:
        points = np.asarray(frame.points, np.float64)
        nodes = [lip.nodes(points) for lip in self._seam.lips]
        first, second = (lip.samples(own) for lip, own in zip(self._seam.lips, nodes, strict=True))
        up = directions(self._bands[0].normals(points) + self._bands[1].normals(points))
        middle = 0.5 * (first + second)
        along = _along(middle, first, up)
        apart = second - first
        # Along the first lip the skin lies on the left, the wound on the right.
        gap, step, mismatch = (np.einsum("ij,ij->i", apart, axis) for axis in (np.cross(along, up), up, along))
        steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
        share = np.concatenate([[0.0], steps]) + np.concatenate([steps, [0.0]])
        meet = _meet(gap, step, mismatch)
        length = float(steps.sum())
        sutures = {name for names in self._seam.sutures.values() for name in names}
        own = [row for row in forces if row.suture in sutures]
        ears = [None if ear is None else ear.height(points) for ear in self._dog_ears]
        measure = SeamMeasure(
            frame.time,
            self._seam.name,
            length,
            _length(nodes[0]),
            _length(nodes[1]),
            self._at_rest[0],
            self._at_rest[1],
            abs(self._at_rest[0] - self._at_rest[1]),
            float(gap.max()),
            _open_area(first, second, up),
            float(share[meet].sum() / max(share.sum(), 1e-300)),
            _greatest(mismatch, meet),
            _greatest(step, meet),
            ears[0],
            ears[1],
            sum(row.pull_mn for row in own if row.resolved),
            closing_tension(own, length),
        )
        return SeamState(measure, tuple(self._seam.sutures), middle, gap, step, mismatch)


@dataclass(frozen=True, eq=False)
class _Band:
    """The skin beside a lip: its triangles, shape (t, 3), and which of them lie beside each sample, (SAMPLES, t)."""

    triangles: NDArray[np.int64]
    beside: NDArray[np.float64]

    def normals(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return directions(self.beside @ area_normals(points[self.triangles]))


def _band(surface: Surface, edges: WoundEdges, lip: Lip) -> _Band:
    loop = edges.loops[lip.loop]
    skin = surface.triangles[surface.origin == FaceOrigin.SKIN].astype(np.int64)
    corner = np.argmin(edges.distance[skin], axis=1)
    vertex = skin[np.arange(len(skin)), corner]
    near = np.flatnonzero(edges.distance[vertex] <= _BAND)
    places: list[EdgePlace] = [edges.place_of(edges.nearest[each]) for each in vertex[near]]
    own = np.array([place.loop == lip.loop for place in places], bool)
    kept, at = near[own], np.array([place.at for place in places])[own]
    off = np.abs((at[None] - lip.places[:, None] + 0.5 * loop.length) % loop.length - 0.5 * loop.length)
    beside = off <= np.maximum(_BAND, off.min(axis=1, initial=np.inf))[:, None]
    return _Band(skin[kept], beside.astype(np.float64))


def _along(middle: NDArray[np.float64], first: NDArray[np.float64], up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors along the seam and the skin; along the first lip where the line between the lips stands still."""
    along = np.gradient(middle, axis=0)
    still = np.linalg.norm(along, axis=1) < 1e-9
    along[still] = np.gradient(first, axis=0)[still]
    return directions(along - np.einsum("ij,ij->i", along, up)[:, None] * up)


def _meet(gap: NDArray[np.float64], step: NDArray[np.float64], mismatch: NDArray[np.float64]) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (gap <= CLOSED) & (gap**2 + step**2 + mismatch**2 <= NEAR**2)
    return found


def _open_area(first: NDArray[np.float64], second: NDArray[np.float64], up: NDArray[np.float64]) -> float:
    """The area of the quadrilaterals between the lips, seen along the normal; where they overlap nothing is open."""
    diagonals = second[1:] - first[:-1], first[1:] - second[:-1]
    areas = 0.5 * np.cross(diagonals[0], diagonals[1])
    return float(np.maximum(np.einsum("ij,ij->i", areas, directions(up[1:] + up[:-1])), 0.0).sum())


def _greatest(values: NDArray[np.float64], where: NDArray[np.bool_]) -> float | None:
    return float(np.abs(values[where]).max()) if where.any() else None


def _length(points: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
