"""Handles of a laid flap: one to move it, one to turn it, one for each measure, and what a handle's move changes.

The handle of a measure is the corner of the design that the measure moves most: the end of a limb, a corner of the
defect, a point of its rim. Where the handle is dragged, the measure takes the value at which that corner lies nearest.
So no design says anything about handles; a count has none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import skin_axes
from lappet.designs.flap_design import FlapDesign
from lappet.designs.geodesic_drape import GeodesicDrape
from lappet.designs.laid_flaps import changed_flap
from lappet.designs.library import library_design
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.procedure import LaidFlap, Point, Procedure
from lappet.procedure.prim_paths import FLAPS
from lappet.tissue.skin_sheet import SkinSheet

PLACE, TURN = "place", "turn"
_BEYOND = 5.0  # mm from the design to the handle that turns it
_APART = 2.0  # mm between two handles, at least
_NUDGE = 0.01  # of a measure's range, to see what it moves
_STEPS, _ROUNDS = 12, 4  # values that are tried for a measure; each round between the neighbors of the best
_DIGITS = 2  # of a measure that was dragged
_ALIKE = 0.02  # mm beside the point, over the whole range of a measure
_ALONG = 8  # points of a closed curve that can be a handle


@dataclass(frozen=True)
class FlapHandle:
    """A point of a laid flap that can be dragged along the skin.

    Parameters
    ----------
    name
        "place", "turn", or the measure that it changes.
    point
        Where it is on the skin at rest in mm.
    says
        What it changes, and the value now, for people.
    """

    name: str
    point: Point
    says: str


class HandledFlap:
    """A laid flap with its handles, on the skin of a procedure.

    Parameters
    ----------
    procedure
        The procedure, which need not hold the flap.
    laid
        The flap.

    Raises
    ------
    RefusedError
        If its design is not in the library, or its direction stands upright on the skin.
    """

    def __init__(self, procedure: Procedure, laid: LaidFlap) -> None:
        self._procedure, self._row = procedure, library_design(laid.design)
        self._skin = SkinSheet.of(procedure.tissue)
        self._set(laid)
        self._corners = _corners_of_measures(self._row, dict(laid.measures), laid.mirrored)

    @property
    def laid(self) -> LaidFlap:
        """The flap as its handles have it now."""
        return self._laid

    def handles(self) -> tuple[FlapHandle, ...]:
        """List the handles where they are now.

        Returns
        -------
        tuple[FlapHandle, ...]
            Place, turn, then the measures in the design's order.

        Raises
        ------
        RefusedError
            If the design cannot be drawn with its measures.
        """
        values = dict(self._laid.measures)
        flat = _features(self._drawn(values))
        known = {each.name: each for each in self._row.parameters}
        names = [PLACE, TURN, *self._corners]
        far = np.array([max(0.0, float(flat[:, 0].max())) + _BEYOND, 0.0])
        places = [np.zeros(2), far, *(flat[k] for k in self._corners.values())]
        on_skin = self._drape(self._drape.middle + np.array(places) @ self._axes)
        says = [self._row.title, "Direction", *(_says(known[name], values[name]) for name in self._corners)]
        return tuple(
            FlapHandle(name, (float(x), float(y), float(z)), said)
            for name, (x, y, z), said in zip(names, on_skin, says, strict=True)
        )

    def move(self, handle: str, to: ArrayLike) -> LaidFlap:
        """Drag a handle to a point.

        Parameters
        ----------
        handle
            Name of the handle.
        to
            The point, in or near the skin at rest, mm, shape (3,).

        Returns
        -------
        LaidFlap
            The flap with the handle as near to the point as the design allows.

        Raises
        ------
        RefusedError
            If there is no such handle, or no lines of the skin for a flap that follows them.
        """
        on_skin = self._skin.at(to)[0][0]
        if handle == PLACE:
            self._set(changed_flap(self._procedure, self._laid, at=np.round(on_skin, 4)))
        elif handle == TURN:
            way = self._drape.unrolled(on_skin[None])[0]
            if float(np.linalg.norm(way)) > _APART:
                way = np.round(way / np.linalg.norm(way), 6)
                self._set(changed_flap(self._procedure, self._laid, direction=way))
        elif handle in self._corners:
            flat = self._axes @ self._drape.unrolled(on_skin[None])[0]
            value = self._nearest(handle, flat)
            self._set(changed_flap(self._procedure, self._laid, measures={handle: value}))
        else:
            known = ", ".join([PLACE, TURN, *self._corners])
            raise refused(ProblemCode.FLAP_HANDLE, f"{FLAPS}/{self._laid.name}", handle, known=known)
        return self._laid

    def curves(self) -> list[tuple[NDArray[np.float64], bool]]:
        """Draw the plan on the skin.

        Returns
        -------
        list[tuple[NDArray[np.float64], bool]]
            Points of each cut in mm, shape (n, 3), and whether it is closed.

        Raises
        ------
        RefusedError
            If the design cannot be drawn with its measures.
        """
        drawn = self._drawn(dict(self._laid.measures))
        cuts = [(np.array(cut.outline)[:, :2], True) for cut in drawn.excised]
        cuts += [(np.array(curve)[:, :2], False) for curve in drawn.incisions]
        flat = np.vstack([points for points, _ in cuts])
        on_skin = self._drape(self._drape.middle + flat @ self._axes)
        ends = np.cumsum([len(points) for points, _ in cuts])[:-1]
        return [(part, closed) for part, (_, closed) in zip(np.split(on_skin, ends), cuts, strict=True)]

    def _set(self, laid: LaidFlap) -> None:
        self._laid = laid
        self._drape = GeodesicDrape(self._skin, laid.at)
        self._axes = np.stack(skin_axes(laid.direction, self._drape.normal, laid.design))

    def _drawn(self, values: Mapping[str, float]) -> FlapDesign:
        return _drawn(self._row, values, self._laid.mirrored)

    def _nearest(self, measure: str, flat: NDArray[np.float64]) -> float:
        """The value of a measure at which its corner is nearest to a point of the plane."""
        (parameter,) = (each for each in self._row.parameters if each.name == measure)
        values, index = dict(self._laid.measures), self._corners[measure]
        low, high = parameter.least, parameter.most
        now = best = values[measure]
        for _ in range(_ROUNDS):
            tried = np.unique([*np.linspace(low, high, _STEPS + 1), best])
            away = np.array([self._away({**values, measure: float(value)}, index, flat) for value in tried])
            if not np.isfinite(away).any():
                return now
            # Of values that do as well (a row of teeth changes by whole teeth) the one nearest to that of now.
            k = int((away + _ALIKE * np.abs(tried - now) / (parameter.most - parameter.least)).argmin())
            best = float(tried[k])
            low, high = float(tried[max(k - 1, 0)]), float(tried[min(k + 1, len(tried) - 1)])
        return float(min(max(round(best, _DIGITS), parameter.least), parameter.most))

    def _away(self, values: Mapping[str, float], index: int, flat: NDArray[np.float64]) -> float:
        """How far a corner is from a point, mm; infinite where the design cannot be drawn so."""
        try:
            features = _features(self._drawn(values))
        except RefusedError:
            return float("inf")
        return float(np.linalg.norm(features[index] - flat)) if index < len(features) else float("inf")


def _drawn(row: LibraryDesign, values: Mapping[str, float], mirrored: bool) -> FlapDesign:
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), mirrored=mirrored, **values)


def _features(drawn: FlapDesign) -> NDArray[np.float64]:
    """The points (n, 2) of a design in its plane that may be handles, as many whatever its lengths.

    First the corners that meet, pivots, ends of cuts and middles of later ones; then points at shares of the length of
    each cut.
    """
    corners = [spot.point for pair in drawn.corners for spot in (pair.flap, pair.wound)]
    corners += [carry.pivot for carry in drawn.carries if carry.pivot is not None]
    corners += [end for curve in drawn.incisions for end in (curve[0], curve[-1])]
    corners += [cut[len(cut) // 2] for cut in _later_cuts(drawn)]
    closed = [np.array([*cut.outline, cut.outline[0]])[:, :2] for cut in drawn.excised]
    cuts = [*closed, *(np.array(curve)[:, :2] for curve in drawn.incisions)]
    found = np.array(corners, np.float64).reshape(-1, 3)[:, :2]
    return np.vstack([found, *(_at_shares(cut) for cut in cuts)])


def _later_cuts(drawn: FlapDesign) -> tuple[tuple[Point, ...], ...]:
    """The cuts of a second stage."""
    return () if drawn.division is None else drawn.division.cuts


def _at_shares(points: NDArray[np.float64]) -> NDArray[np.float64]:
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = along[-1] * np.arange(_ALONG) / _ALONG
    return np.stack([np.interp(at, along, points[:, k]) for k in range(2)], axis=1)


def _corners_of_measures(row: LibraryDesign, values: Mapping[str, float], mirrored: bool) -> dict[str, int]:
    """For each measure that is no count the point of the design that is its handle, by its index."""
    here = _features(_drawn(row, values, mirrored))
    drawn = _drawn(row, values, mirrored)
    sharp = 2 * len(drawn.corners) + sum(each.pivot is not None for each in drawn.carries) + 2 * len(drawn.incisions)
    sharp += len(_later_cuts(drawn))
    taken, found = [np.zeros(2)], dict[str, int]()
    for parameter in row.parameters:
        speed = None if parameter.whole else _speed(row, values, mirrored, parameter, here)
        if speed is None:
            continue
        free = np.min([np.linalg.norm(here - each, axis=1) for each in taken], axis=0) > _APART
        speed = np.where(free, speed, 0.0)
        speed[sharp:] *= 0.5  # a corner is a better handle than a point of a rim
        if speed.max() > 1e-6:
            found[parameter.name] = int(speed.argmax())
            taken.append(here[found[parameter.name]])
    return found


def _speed(
    row: LibraryDesign,
    values: Mapping[str, float],
    mirrored: bool,
    parameter: Parameter,
    here: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """How far a nudge of a measure moves each point (n,), mm; None where the design cannot be drawn nudged."""
    step = _NUDGE * (parameter.most - parameter.least)
    for value in (values[parameter.name] - step, values[parameter.name] + step):
        if not parameter.least <= value <= parameter.most:
            continue
        try:
            there = _features(_drawn(row, {**values, parameter.name: value}, mirrored))
        except RefusedError:
            continue
        if len(there) == len(here):
            return np.linalg.norm(there - here, axis=1)
    return None


def _says(parameter: Parameter, value: float) -> str:
    unit = f" {parameter.unit}" if parameter.unit == "mm" else parameter.unit
    title = parameter.name.replace("_", " ").capitalize()
    return f"{title} {value:g}{unit}"
