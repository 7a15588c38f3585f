"""A design of the flap library that is as large as a defect asks for, and lies where that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import skin_axes
from lappet.designs.geodesic_drape import REACHED, GeodesicDrape
from lappet.designs.library import library_design
from lappet.designs.library_design import LibraryDesign
from lappet.designs.marked_faces import REGION, subset_outline
from lappet.procedure import Event, Excision, Incision, Landmark, Point, Procedure, Tissue
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.skin_sheet import SkinSheet

_SIDES = 36  # directions in which an outline of more edges is measured
_CONVEX = 0.97  # share of its convex hull that an outline fills at least
_ROUNDS = 3  # of laying the design where the last round found its place
_LEAST_POINTS = 3
_ALIKE = 1.002  # sizes that differ by less are one: the design lies in the middle of their places


@dataclass(frozen=True)
class Fitted:
    """Where a design lies and how large it is.

    Parameters
    ----------
    at
        Where it lies in mm.
    values
        Its measures.
    """

    at: Point
    values: dict[str, float]


def fit_to_defect(
    tissue: Tissue,
    name: str,
    defect: ArrayLike,
    direction: ArrayLike,
    values: Mapping[str, float] | None = None,
    *,
    mirrored: bool = False,
) -> Fitted:
    """Find the smallest design of a shape whose excision holds a defect.

    What a design excises first grows in proportion with its lengths. Of all places and sizes at which the defect lies
    inside it the smallest size is taken: a linear program of three unknowns, solved by its corners.

    Parameters
    ----------
    tissue
        The tissue.
    name
        Name of the design.
    defect
        Outline of the defect on the skin in mm, shape (n, 3).
    direction
        Direction of the design along the skin, shape (3,).
    values
        Values of its shares, angles and counts that are not the default; a length says how it stands to the others.
    mirrored
        Whether the design is mirrored.

    Returns
    -------
    Fitted
        The design's place and all its measures.

    Raises
    ------
    RefusedError
        If the design excises nothing first, or no convex shape, the outline has too few points or cannot be reached
        along the skin, or the defect needs a length that is out of its range.
    """
    row = library_design(name)
    given = row.values(values or {})
    points = np.asarray(defect, np.float64).reshape(-1, 3)
    if len(points) < _LEAST_POINTS:
        raise refused(ProblemCode.DESIGN_DEFECT_POINTS, name, len(points))
    normals, reach = _sides(row, given)
    skin = SkinSheet.of(tissue)
    at, size = points.mean(axis=0), 1.0
    for _ in range(_ROUNDS):
        drape = GeodesicDrape(skin, at)
        along, across = skin_axes(direction, drape.normal, name)
        axes = np.stack([along, -across if mirrored else across])
        flat = _unrolled(drape, points, name) @ axes.T
        middle, size = _smallest(normals, reach, (normals @ flat.T).max(axis=1))
        at = drape((drape.middle + middle @ axes)[None])[0]
    x, y, z = at.tolist()
    return Fitted((x, y, z), row.values(_sized(row, given, size)))


def _sides(row: LibraryDesign, values: Mapping[str, float]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Outward normals of what a design excises first, and how far it reaches along each from where the design lies."""
    excised = row.draw(np.zeros(3), (1.0, 0.0, 0.0), **values).excised
    if not excised:
        raise refused(ProblemCode.DESIGN_DEFECT_NONE, row.name, row.name)
    outline = np.array(excised[0].outline)[:, :2]
    ways = np.roll(outline, -1, axis=0) - outline
    ways = ways[np.linalg.norm(ways, axis=1) > 1e-9]
    angles = np.arctan2(-ways[:, 0], ways[:, 1])  # of the normals: the outline runs counter-clockwise
    angles = np.unique(np.round(angles, 6))
    if len(angles) > _SIDES:
        angles = np.linspace(-np.pi, np.pi, _SIDES, endpoint=False)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    if _area(outline) < _CONVEX * _area(_hull(outline)):
        raise refused(ProblemCode.DESIGN_DEFECT_SHAPE, row.name, row.name)
    return normals, (normals @ outline.T).max(axis=1)


def _unrolled(drape: GeodesicDrape, points: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    """The places (n, 3) in the plane, from its middle, that are draped onto points of the skin."""
    flat = drape.unrolled(points)
    off = points - drape(drape.middle + flat)
    off = np.linalg.norm(off - np.outer(off @ drape.normal, drape.normal), axis=1)
    if off.max() < REACHED:
        return flat
    worst = points[int(off.argmax())]
    raise refused(ProblemCode.DESIGN_DEFECT_FAR, name, "({:.1f}, {:.1f}, {:.1f})".format(*worst))


def _smallest(
    normals: NDArray[np.float64], reach: NDArray[np.float64], needed: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """The place o and the least size s with normals . o + s reach >= needed, found at a corner of what is allowed."""
    sides = np.column_stack([normals, reach])
    three = np.array(list(combinations(range(len(sides)), 3)))
    matrices = sides[three]
    regular = np.abs(np.linalg.det(matrices)) > 1e-6 * np.abs(reach).max()
    corners = np.linalg.solve(matrices[regular], needed[three[regular]][..., None])[..., 0]
    allowed = (corners @ sides.T >= needed - 1e-6 * (1.0 + np.abs(needed))).all(axis=1) & (corners[:, 2] > 0.0)
    corners = corners[allowed]
    least = corners[corners[:, 2] <= _ALIKE * corners[:, 2].min()].mean(axis=0)  # what is allowed is convex
    return least[:2], float(least[2])


def _sized(row: LibraryDesign, values: Mapping[str, float], size: float) -> dict[str, float]:
    """The measures with all lengths in proportion, at least as small as they may be."""
    lengths = [each for each in row.parameters if each.unit == "mm"]
    size = max([size, *(each.least / values[each.name] for each in lengths)])
    for each in lengths:
        value = size * values[each.name]
        if value > each.most:
            most = f"{each.most:g}"
            raise refused(ProblemCode.DESIGN_DEFECT_SIZE, row.name, f"{value:.1f}", name=each.name, most=most)
    return {**values, **{each.name: round(size * values[each.name] + 5e-4, 3) for each in lengths}}


def _area(outline: NDArray[np.float64]) -> float:
    x, y = outline.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _hull(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The convex hull of points (n, 2), counter-clockwise (Andrew's monotone chain)."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]

    def chain(some: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        kept: list[NDArray[np.float64]] = []
        for point in some:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], point) <= 0.0:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    return np.array([*chain(ordered), *chain(ordered[::-1])])


def _turn(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def lengths_of(name: str, values: Mapping[str, float]) -> list[str]:
    """Write the lengths among the measures of a design.

    Parameters
    ----------
    name
        Name of the design.
    values
        Its measures.

    Returns
    -------
    list[str]
        A text for each.
    """
    lengths = [each.name for each in library_design(name).parameters if each.unit == "mm"]
    return [f"{each} {values[each]:g} mm" for each in lengths]


def marked_defect(procedure: Procedure, name: str) -> NDArray[np.float64]:
    """Find the outline of a defect that is drawn in a procedure.

    Parameters
    ----------
    procedure
        The procedure.
    name
        Name of a closed incision, or name or label of a landmark of three points or more; "region:" and a name for a
        face subset of the tissue.

    Returns
    -------
    NDArray[np.float64]
        The outline in mm, shape (n, 3).

    Raises
    ------
    RefusedError
        If the procedure has none of that name, or as `lappet.designs.marked_faces.subset_outline`.
    """
    if name.startswith(REGION):
        return subset_outline(procedure.tissue, name.removeprefix(REGION))
    drawn = {label: event for event in procedure.events if _is_outline(event) for label in _labels(event)}
    if name not in drawn:
        known = ", ".join(sorted({event.name for event in drawn.values()})) or "none"
        raise refused(ProblemCode.DESIGN_DEFECT_UNKNOWN, TIMELINE, name, known=known)
    event = drawn[name]
    assert isinstance(event, Incision | Landmark)
    return np.array(event.points, np.float64)


def without_drawn(procedure: Procedure, name: str) -> Procedure:
    """Take away the incision that drew a defect, and what excised its inside: the design's own excision replaces them.

    Parameters
    ----------
    procedure
        The procedure.
    name
        Name of the incision; a landmark stays.

    Returns
    -------
    Procedure
        The procedure without them.
    """
    drawn = [event for event in procedure.events if isinstance(event, Incision) and event.name == name]
    if not drawn:
        return procedure
    (cut,) = drawn
    middle = np.mean(cut.points, axis=0)
    far = np.linalg.norm(np.array(cut.points) - middle, axis=1).max()

    def excises(event: Event) -> bool:
        return isinstance(event, Excision) and all(
            float(np.linalg.norm(np.array(seed) - middle)) < far for seed in event.seeds
        )

    return replace(procedure, events=tuple(e for e in procedure.events if e is not cut and not excises(e)))


def _is_outline(event: Event) -> bool:
    closed = isinstance(event, Landmark) or (isinstance(event, Incision) and event.closed)
    return closed and len(event.points) >= _LEAST_POINTS  # type: ignore[union-attr]


def _labels(event: Event) -> tuple[str, ...]:
    return (event.name, event.label) if isinstance(event, Landmark) else (event.name,)
