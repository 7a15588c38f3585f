"""A design of the flap library laid on a procedure's skin, with the operation that it makes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.event_names import free_name, named_apart
from lappet.designs.flap_design import FlapDesign
from lappet.designs.flat_curves import length
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.library import library_design
from lappet.designs.technique import Row, Schedule, Technique
from lappet.designs.transposition import flap_operation
from lappet.designs.undermined_area import SkinBorder, contour_around, reaches_border
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Event, FlapLines, LaidFlap, Landmark, Point, Procedure, Tissue, Undermine
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.tissue.skin_lines import skin_field
from lappet.tissue.skin_sheet import SkinSheet

# Shares of the tissue's thickness at which sutures lie: through the deep layer, through the dermis, and on the skin.
DEEP, DERMAL = 0.8, 0.15
OBLIQUE = 0.3  # where a wall stands oblique to the skin, below whose edge there may be no tissue: no row is deeper
SEAM_SUTURES = 6.0  # sutures of a row along the longest seam, at least, as long as the lattice can hold them
BEYOND = 15.0  # mm of skin undermined around the cuts; half of it shrinks with the design
MARGIN = 24.0  # mm of skin around a design on a patch of its own
THICKNESS = 4.0  # mm, of such a patch
SPACING = 4.0 / 3.0  # mm, of its lattice: three cells through the skin
_UNMEASURED = 4.0  # mm: thickness of a tissue without a bed


def technique(design: FlapDesign, thickness: float, spacing: float) -> Technique:
    """Choose how a surgeon works on a design of this size in tissue of this thickness.

    Parameters
    ----------
    design
        The design on the skin.
    thickness
        Thickness of the tissue in mm.
    spacing
        Edge of the lattice's cells in mm; sutures are no denser than 1.5 of them.

    Returns
    -------
    Technique
        Rows at shares of the thickness; sutures, margins and hooks as fit the longest seam.
    """
    usual = Technique()
    seam = max(length(np.array(edge.points)) for seam in design.seams for edge in seam.edges)
    apart = max(min(usual.apart, seam / SEAM_SUTURES), 1.5 * spacing)
    small = min(1.0, seam / 20.0)
    deep, skin = Row("deep", round(DEEP * thickness, 2)), Row("skin", 0.0)
    dermal = Row("dermal", round((DERMAL if design.blade is None else OBLIQUE) * thickness, 2), 0.5)
    return replace(
        usual,
        rows=(deep, dermal, skin) if design.blade is None else (dermal, skin),
        apart=apart,
        margin=min(usual.margin, 0.7 * apart),
        beyond=round(0.5 * BEYOND * (1.0 + small) * design.undermined, 2),
        height=round(usual.height * small, 2),
        inside=min(usual.inside, max(0.1 * seam, spacing)),
        runs=True,
    )


def schedule(design: FlapDesign, start: float = 1.0) -> Schedule:
    """Choose when the steps of a design are done.

    Parameters
    ----------
    design
        The design.
    start
        Time code before the first cut.

    Returns
    -------
    Schedule
        That of a flap; without hooks its sutures follow the undermining, and what is cut out late the first seams. A
        second stage follows when all seams of the first are closed.
    """
    if design.division is not None:
        end = 60 if design.thinned is None else 68
        usual = Schedule(undermine=Schedule.lift, end=end)  # as long a flap hangs limp from when it is free
    elif any(cut.late for cut in design.excised):
        usual = Schedule(donor_from=8, donor_to=16, trim=19, suture_from=20, suture_to=29, end=32)
    elif design.carries:
        usual = Schedule()
    else:
        usual = Schedule(donor_from=8, donor_to=18, suture_from=8, suture_to=21, end=24)
    return Schedule(**{name: value + start - 1.0 for name, value in vars(usual).items()})


def add_flap(
    procedure: Procedure,
    name: str,
    at: ArrayLike,
    direction: ArrayLike,
    values: Mapping[str, float] | None = None,
    *,
    mirrored: bool = False,
    start: float | None = None,
    lines: FlapLines = "",
) -> Procedure:
    """Add the operation of a design to a procedure.

    Parameters
    ----------
    procedure
        The procedure.
    name
        Name of the design.
    at
        Where it lies in mm, shape (3,).
    direction
        Its direction along the skin, shape (3,).
    values
        Values of its parameters that are not the default.
    mirrored
        Whether it is mirrored.
    start
        Time code before the first cut; None for where the timeline ends, or its start if there are no events.
    lines
        How the direction was chosen by the lines of the skin, which it then follows when the flap is moved.

    Returns
    -------
    Procedure
        The procedure with the events and the laid flap, its timeline long enough for them.

    Raises
    ------
    RefusedError
        As `flap_on_skin`.
    """
    if start is None:
        timed = any(not isinstance(event, Landmark) for event in procedure.events)
        start = procedure.end_time if timed else procedure.start_time
    measures = tuple(library_design(name).values(values or {}).items())
    (x, y, z), (u, v, w) = np.asarray(at, np.float64).tolist(), np.asarray(direction, np.float64).tolist()
    laid = LaidFlap("", name, (x, y, z), (u, v, w), measures, mirrored, start, lines)
    operation, end = flap_events(procedure.tissue, laid)
    events, prefix = named_apart(operation, procedure, name)
    laid = replace(laid, name=prefix or free_name(procedure, name), events=tuple(event.name for event in events))
    longer = replace(procedure, end_time=max(procedure.end_time, end), flaps=(*procedure.flaps, laid))
    return longer.with_events(*events)


def flap_events(tissue: Tissue, laid: LaidFlap) -> tuple[tuple[Event, ...], float]:
    """Make the events of a laid flap.

    Parameters
    ----------
    tissue
        The tissue.
    laid
        The flap; of its events nothing is used.

    Returns
    -------
    tuple[tuple[Event, ...], float]
        The events with the names that a design gives them, and the last time code of the operation.

    Raises
    ------
    RefusedError
        As `flap_on_skin`.
    """
    design = flap_on_skin(tissue, laid.design, laid.at, laid.direction, dict(laid.measures), mirrored=laid.mirrored)
    skin = SkinSheet.of(tissue)
    when = schedule(design, laid.start)
    thickness = thickness_at(tissue, laid.at) if design.blade is None else _thinnest(tissue, skin, design)
    how = technique(design, thickness, tissue.spacing)
    return _kept_inside(tissue, skin, design, how, flap_operation(design, skin, when, how)), when.end


def _kept_inside(
    tissue: Tissue, skin: SkinSheet, design: FlapDesign, how: Technique, events: tuple[Event, ...]
) -> tuple[Event, ...]:
    """The events with undermining around all cuts that keeps away from where the skin ends."""
    border = SkinBorder(tissue)

    def kept(event: Event) -> Event:
        if not isinstance(event, Undermine) or design.freed or not reaches_border(border, event.points):
            return event
        curves = [*(cut.outline for cut in design.excised), *design.incisions]
        return replace(event, points=contour_around(border, skin, curves, how.beyond) or event.points)

    return tuple(kept(event) for event in events)


def flap_on_patch(
    name: str, values: Mapping[str, float] | None = None, *, mirrored: bool = False, spacing: float = SPACING
) -> Procedure:
    """Make a procedure of a design on a flat patch of the default skin, large enough for it.

    Parameters
    ----------
    name
        Name of the design.
    values
        Values of its parameters that are not the default.
    mirrored
        Whether it is mirrored.
    spacing
        Edge of the lattice's cells in mm.

    Returns
    -------
    Procedure
        The procedure; the design's direction runs along x.

    Raises
    ------
    RefusedError
        As `flap_on_skin`.
    """
    row = library_design(name)
    flat = row.draw(np.zeros(3), (1.0, 0.0, 0.0), mirrored=mirrored, **row.values(values or {}))
    curves = [*(cut.outline for cut in flat.excised), *flat.incisions]
    drawn = np.array([point for curve in curves for point in curve])[:, :2]
    low, high = drawn.min(axis=0) - MARGIN, drawn.max(axis=0) + MARGIN
    size, middle = 2.0 * np.ceil(0.5 * (high - low)), np.round(0.5 * (low + high))
    tissue = flat_patch(
        (float(size[0]), float(size[1]), THICKNESS), center=(float(middle[0]), float(middle[1])), spacing=spacing
    )
    empty = Procedure(tissue, (SKIN.material,), start_time=1, end_time=1, fps=12)
    return add_flap(empty, name, (0.0, 0.0, THICKNESS), (1.0, 0.0, 0.0), values, mirrored=mirrored)


def thickness_at(tissue: Tissue, at: ArrayLike) -> float:
    """Measure how thick the tissue is.

    Parameters
    ----------
    tissue
        The tissue.
    at
        A place in mm, shape (3,).

    Returns
    -------
    float
        Distance in mm from the skin there to the bed; 4 where there is none.
    """
    return float(_thicknesses(tissue, SkinSheet.of(tissue), np.asarray(at, np.float64)[None], "bed")[0])


def _thinnest(tissue: Tissue, skin: SkinSheet, design: FlapDesign) -> float:
    """How thick the tissue is where it is thinnest along what is sewn, mm: a lip is thinner than what is beside it."""
    edges = np.array([point for seam in design.seams for edge in seam.edges for point in edge.points])
    return float(_thicknesses(tissue, skin, edges, "underside" if "underside" in tissue.subsets else "bed").min())


def _thicknesses(tissue: Tissue, skin: SkinSheet, at: NDArray[np.float64], lower: str) -> NDArray[np.float64]:
    """Distances in mm from the skin at places (k, 3) to the faces of a subset, shape (k,)."""
    bed = tissue.subsets.get(lower, ())
    if not len(bed):
        return np.full(len(at), _UNMEASURED)
    counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
    triangles, _, faces = triangulate(tissue.points, counts, indices)
    below = ClosestPoint(tissue.points, triangles[np.isin(faces, bed)])
    on_skin, _ = skin.at(at)
    return np.asarray(below.query(on_skin)[2])


def landmark_place(procedure: Procedure, label: str) -> Point:
    """Find where a landmark is.

    Parameters
    ----------
    procedure
        The procedure.
    label
        Label or name of the landmark; of one with several points the first counts.

    Returns
    -------
    Point
        Its place in mm.

    Raises
    ------
    RefusedError
        If there is none of that name.
    """
    marks = [event for event in procedure.events if isinstance(event, Landmark)]
    for mark in marks:
        if label in (mark.label, mark.name):
            return mark.points[0]
    known = ", ".join(mark.label for mark in marks) or "none"
    raise refused(ProblemCode.DESIGN_LANDMARK, TIMELINE, label, known=known)


def has_lines(procedure: Procedure) -> bool:
    """Tell whether a procedure has lines of the skin.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    bool
        Whether it has skin lines, or its skin a direction of its fibers.
    """
    return bool(procedure.skin_lines) or procedure.material(procedure.tissue.material).has_direction


def skin_line_direction(procedure: Procedure, at: ArrayLike, *, across: bool = False) -> NDArray[np.float64]:
    """Find the direction of the lines of the skin at a place, or square to them.

    Parameters
    ----------
    procedure
        The procedure.
    at
        The place in mm, shape (3,).
    across
        Whether to turn it by 90° in the skin.

    Returns
    -------
    NDArray[np.float64]
        Unit vector along the skin, shape (3,).

    Raises
    ------
    RefusedError
        If the procedure has neither skin lines nor a material with a direction.
    """
    points, normals = SkinSheet.of(procedure.tissue).at(at)
    material = procedure.material(procedure.tissue.material)
    if procedure.skin_lines:
        along = skin_field(procedure.skin_lines, points, normals, material).directions[0]
    elif material.has_direction:
        along = np.asarray(material.fiber_direction, np.float64)
        along = along - (along @ normals[0]) * normals[0]
    else:
        raise refused(ProblemCode.DESIGN_NO_LINES, TIMELINE, "")
    size = float(np.linalg.norm(along))
    if not size > 1e-9:
        raise refused(ProblemCode.DESIGN_NO_LINES, TIMELINE, "")
    return (np.cross(normals[0], along) if across else along) / size
