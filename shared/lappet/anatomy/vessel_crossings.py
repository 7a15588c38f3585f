"""Where incisions cross vessels, as a surgeon says it: how far along the incision and how deep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.curve import sample_curve
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Incision, Point, Procedure
from lappet.procedure.prim_paths import TIMELINE

_GAP = 8.0  # kerfs: two ends of a vessel that are nearer lie on the two walls of one incision; chosen
_FINE = 0.25  # mm, how finely curves of incisions are sampled


@dataclass(frozen=True)
class VesselCrossing:
    """A place where an incision divides a vessel.

    Parameters
    ----------
    incision
        Name of the incision.
    vessel
        Number of the vessel in `Procedure.vessels`.
    time
        Time code of the incision.
    along
        How far along the incision in mm.
    depth
        How far below the skin before any cut in mm.
    point
        The place at rest in mm.
    """

    incision: str
    vessel: int
    time: float
    along: float
    depth: float
    point: Point


def vessel_crossings(
    procedure: Procedure, uncut: Surface, epochs: Sequence[Epoch], pieces: Sequence[VesselPieces]
) -> list[VesselCrossing]:
    """Find where incisions divide vessels.

    Parameters
    ----------
    procedure
        The procedure.
    uncut
        The surface of its tissue before any cut.
    epochs
        Its epochs in order of time.
    pieces
        What each of them holds of the vessels.

    Returns
    -------
    list[VesselCrossing]
        The crossings, epoch by epoch, in the order of the vessels.
    """
    if not procedure.vessels:
        return []
    skin = ClosestPoint(uncut.points, uncut.triangles[uncut.origin == FaceOrigin.SKIN])
    found: list[VesselCrossing] = []
    known: dict[int, NDArray[np.float64]] = {}
    for epoch, own in zip(epochs, pieces, strict=True):
        made = [event for event in procedure.events if isinstance(event, Incision) and _is_of(event, epoch, procedure)]
        courses = [(event, _course(event)) for event in made]
        widest = _GAP * max((event.kerf for event in made), default=0.0)
        places = _divided(own, widest)
        for vessel, points in places.items():
            if not courses:
                break
            before = known.get(vessel, np.zeros((0, 3)))
            for point in points:
                if not len(before) or np.linalg.norm(before - point, axis=1).min() > widest:
                    found.append(_crossing(vessel, point, epoch.start_time, courses, skin))
        known = places
    return found


def crossing_warnings(procedure: Procedure, crossings: Sequence[VesselCrossing]) -> list[Problem]:
    """Say which incisions divide vessels.

    Parameters
    ----------
    procedure
        The procedure.
    crossings
        Where.

    Returns
    -------
    list[Problem]
        A warning for each.
    """
    said = []
    for each in crossings:
        vessel = procedure.vessels[each.vessel]
        path, where = f"{TIMELINE}/{each.incision}", Place.at(each.point)
        told: dict[str, object] = {
            "incision": each.incision,
            "vessel": vessel.title,
            "kind": vessel.kind,
            "along": each.along,
        }
        said.append(problem(ProblemCode.VESSEL_CUT, path, vessel.name, place=where, deep=each.depth, **told))
    return said


def _is_of(incision: Incision, epoch: Epoch, procedure: Procedure) -> bool:
    """Whether an epoch begins with an incision."""
    return max(incision.time, procedure.start_time) == epoch.start_time


def _course(incision: Incision) -> NDArray[np.float64]:
    course = sample_curve(incision.points, incision.basis, incision.closed, _FINE, f"{TIMELINE}/{incision.name}")
    return np.concatenate([course, course[:1]]) if incision.closed else course


def _divided(pieces: VesselPieces, widest: float) -> dict[int, NDArray[np.float64]]:
    """The places where each vessel is divided, by its number: one for two ends that are not farther apart."""
    ends: dict[int, list[NDArray[np.float64]]] = {}
    for vessel, points, divided in zip(pieces.vessel, pieces.split(pieces.points), pieces.divided, strict=True):
        own = ends.setdefault(int(vessel), [])
        own += [point for point, cut in zip((points[0], points[-1]), divided, strict=True) if cut]
    places = {}
    for vessel, tips in ends.items():
        near = [np.linalg.norm(b - a) <= widest for a, b in pairwise(tips)]
        merged, k = [], 0
        while k < len(tips):
            twin = k < len(near) and bool(near[k])
            merged.append(0.5 * (tips[k] + tips[k + 1]) if twin else tips[k])
            k += 2 if twin else 1
        places[vessel] = np.array(merged).reshape(-1, 3)
    return places


def _crossing(
    vessel: int,
    point: NDArray[np.float64],
    time: float,
    courses: Sequence[tuple[Incision, NDArray[np.float64]]],
    skin: ClosestPoint,
) -> VesselCrossing:
    """The crossing at a place, with the incision that runs nearest above it."""
    _, above, depth = skin.query(point[None])
    nearest = [(*_nearest(course, above[0]), incision.name) for incision, course in courses]
    _, along, name = min(nearest)
    x, y, z = (float(value) for value in point)
    return VesselCrossing(name, vessel, float(time), along, float(depth[0]), (x, y, z))


def _nearest(course: NDArray[np.float64], point: NDArray[np.float64]) -> tuple[float, float]:
    """How far a place is from a polyline (k, 3), and how far along it the nearest point is, mm."""
    start, step = course[:-1], np.diff(course, axis=0)
    length = np.linalg.norm(step, axis=1)
    share = np.clip(np.einsum("ij,ij->i", point - start, step) / np.maximum(length, 1e-300) ** 2, 0.0, 1.0)
    apart = np.linalg.norm(start + share[:, None] * step - point, axis=1)
    k = int(np.argmin(apart))
    return float(apart[k]), float(length[:k].sum() + share[k] * length[k])
