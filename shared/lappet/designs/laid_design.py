"""A design of the library laid on a skin, or refused with where and why it does not fit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.blade_section import blade_section
from lappet.designs.crossing_cuts import crossing_cuts
from lappet.designs.flap_design import Edge, FlapDesign
from lappet.designs.flat_curves import length
from lappet.designs.geodesic_drape import GeodesicDrape, Misfit
from lappet.designs.library import library_design
from lappet.designs.opening_drape import OpeningDrape
from lappet.designs.skin_holes import SkinHoles
from lappet.procedure import Point, Tissue
from lappet.tissue.skin_sheet import SkinSheet

_APART = 0.05  # mm: points of an edge that the skin brings nearer to each other are one
_LEAST_OPENING = 0.5  # of the opening that a design goes round: how large a hole of the skin must be to be it
_ALIKE = 0.9  # ratio of its length to the design's
OFF_SKIN = 10.0  # mm from the skin: a place typed by hand, or the middle of an outline, is nearer


def flap_on_skin(
    tissue: Tissue,
    name: str,
    at: ArrayLike,
    direction: ArrayLike,
    values: Mapping[str, float] | None = None,
    *,
    mirrored: bool = False,
) -> FlapDesign:
    """Lay a design of the library on a skin, by geodesics from a point of it.

    Parameters
    ----------
    tissue
        The tissue.
    name
        Name of the design.
    at
        Where it lies in mm, shape (3,); `LibraryDesign.center` says what of it.
    direction
        Its direction along the skin, shape (3,).
    values
        Values of its parameters that are not the default.
    mirrored
        Whether it is mirrored.

    Returns
    -------
    FlapDesign
        The design on the skin.

    Raises
    ------
    RefusedError
        If the library has no such design or the design no such parameter, a value is out of range, the place is not on
        the skin, the design is larger than the skin there or lies across a hole of it, or its cuts cross.
    """
    row = library_design(name)
    given = row.values(values or {})
    skin = SkinSheet.of(tissue)
    drape = GeodesicDrape(skin, at)
    require_on_skin(name, at, drape.middle)
    asked: list[NDArray[np.float64]] = []

    def flat(points: NDArray[np.float64]) -> NDArray[np.float64]:
        asked.append(points)
        return points

    plane = row.draw(drape.middle, direction, normal=drape.normal, mirrored=mirrored, project=flat, **given)
    crossing = crossing_cuts(plane)
    if crossing is not None:
        on_skin = drape(np.array([crossing]))[0]
        where = f"{_place_text(on_skin)} mm"
        raise refused(ProblemCode.DESIGN_CROSSES, name, where, place=Place.at(on_skin))
    holes = SkinHoles(tissue)
    around = _opening_around(name, plane, skin, holes, drape.normal)
    if around is not None:
        design = row.draw(drape.middle, direction, normal=drape.normal, mirrored=mirrored, project=around, **given)
        if around.misfit is not None:
            _refuse_misfit(name, around.misfit, holes)
        return replace(design, opening=())
    drape.prepare(np.vstack(asked))
    design = row.draw(drape.middle, direction, normal=drape.normal, mirrored=mirrored, project=drape, **given)
    if design.blade is not None:
        design = with_edges_on_skin(design, design.blade, skin)
    if drape.misfit is not None:
        _refuse_misfit(name, drape.misfit, holes)
    if holes:
        points = np.unique(np.vstack(asked), axis=0)
        crossed = holes.crossed(drape.middle, drape(points), np.linalg.norm(points - drape.middle, axis=1))
        if crossed is not None:
            size, where = f"{crossed.size:.3g}", _place_text(crossed.middle)
            raise refused(
                ProblemCode.DESIGN_ACROSS_HOLE, name, size, place=Place.at(crossed.middle), at=where, share="less"
            )
    return design


def _opening_around(
    name: str, plane: FlapDesign, skin: SkinSheet, holes: SkinHoles, normal: NDArray[np.float64]
) -> OpeningDrape | None:
    """The drape around the opening that a design in its plane goes round; None where skin has none there."""
    if not plane.opening:
        return None
    size = length(np.array(plane.opening))
    border = holes.border_near(plane.excised[0].seed, size, _LEAST_OPENING * size)
    if border is None:
        return None
    found = OpeningDrape(skin, border, plane.opening, normal)
    if not _ALIKE < found.width / size < 1.0 / _ALIKE:
        there = f"about {found.width:.3g} mm, as long as the border of the opening there"
        raise refused(ProblemCode.DESIGN_RANGE, name, f"{size:.3g}", name="opening", range=there)
    return found


def with_edges_on_skin(design: FlapDesign, blade: Point, skin: SkinSheet) -> FlapDesign:
    """Lay the edges that are sewn onto the skin: those of a cut with a blade may be drawn beside a rim.

    A straight edge that leaves the skin goes on where the blade's plane meets it, over the rim, as long as it was
    drawn.

    Parameters
    ----------
    design
        The design.
    blade
        Direction of its blade.
    skin
        The skin.

    Returns
    -------
    FlapDesign
        The design with each point of its seams' other edges where the skin is closest to it.
    """

    def laid(edge: Edge) -> Edge:
        points = np.array(edge.points)
        on_skin = skin.place(points)
        over = _over_rim(points, on_skin, blade, skin)
        if over is not None:
            return replace(edge, points=tuple((float(x), float(y), float(z)) for x, y, z in over))
        apart = np.linalg.norm(np.diff(on_skin, axis=0), axis=1) > _APART
        chosen = np.concatenate([[True], apart[:-1], [True]]) if len(points) > 2 else np.ones(len(points), bool)
        moved = np.linalg.norm(on_skin - points, axis=1) > _APART
        placed = np.where(moved[:, None], on_skin, points)[chosen]
        return replace(edge, points=tuple((float(x), float(y), float(z)) for x, y, z in placed))

    seams = tuple(replace(seam, edges=(laid(seam.edges[0]), laid(seam.edges[1]))) for seam in design.seams)
    return replace(design, seams=seams)


def _over_rim(
    points: NDArray[np.float64], on_skin: NDArray[np.float64], blade: Point, skin: SkinSheet
) -> NDArray[np.float64] | None:
    """The way of a straight line over the rim beside which it is drawn, shape (k, 3); None for another line."""
    whole = points[-1] - points[0]
    normal = np.cross(whole, blade)
    bent = np.linalg.norm(np.cross(points - points[0], whole), axis=1).max() > _APART * np.linalg.norm(whole)
    if bent or not np.linalg.norm(normal) > 0.0 or np.linalg.norm(on_skin - points, axis=1).max() <= _APART:
        return None
    (face,), (begin,), _ = skin.surface.query(points[:1])
    line = blade_section(skin.points, skin.triangles, int(face), begin, normal, whole)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    long = min(float(np.linalg.norm(whole)), float(along[-1]))
    steps = np.linspace(0.0, long, len(points))
    return np.stack([np.interp(steps, along, line[:, k]) for k in range(3)], axis=1) if long > 0.0 else None


def require_on_skin(name: str, at: ArrayLike, on_skin: NDArray[np.float64]) -> None:
    """Refuse a place that is not on the skin.

    Parameters
    ----------
    name
        Name of the design.
    at
        The place in mm, shape (3,).
    on_skin
        The point of the skin that is closest to it in mm, shape (3,).

    Raises
    ------
    RefusedError
        If they are more than `OFF_SKIN` apart.
    """
    away = float(np.linalg.norm(np.asarray(at, np.float64) - on_skin))
    if not away <= OFF_SKIN:
        raise refused(ProblemCode.DESIGN_PLACE_OFF, name, f"{away:.3g}", at=_place_text(at), near=_place_text(on_skin))


def _refuse_misfit(name: str, lacking: Misfit, holes: SkinHoles) -> NoReturn:
    """Refuse a design that leaves the skin: at the rim of the tissue, or at a hole."""
    fits, at = f"{math.floor(100.0 * lacking.share)} %", Place.at(lacking.point)
    hole = holes.at(lacking.point)
    if hole is None:
        where = _place_text(lacking.point)
        raise refused(ProblemCode.DESIGN_OFF_SKIN, name, f"{lacking.missing:.1f}", place=at, at=where, share=fits)
    size, where = f"{hole.size:.3g}", _place_text(hole.middle)
    raise refused(ProblemCode.DESIGN_ACROSS_HOLE, name, size, place=at, at=where, share=fits)


def _place_text(point: ArrayLike) -> str:
    return "({:.1f}, {:.1f}, {:.1f})".format(*np.asarray(point, np.float64).tolist())
