"""Two or more solved operations beside each other: how they close, how the skin pulls, what they distort."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lappet.output.skin_regions import skin_regions
from lappet.procedure import Undermine
from lappet.tissue.skin_lines import skin_field
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.cache_end import CacheEnd

GREATEST = (
    0.99  # share of the skin's area whose tension is at most the "greatest": single points of a seam do not count
)

_UNBROKEN = "\u00a0"  # a space at which no line is broken


@dataclass(frozen=True)
class Compared:
    """What is compared of an operation, at the last frame of its cache; NaN where it is not known.

    Parameters
    ----------
    name
        Name of the operation.
    closing_force_mn
        Sum of the forces of all sutures in mN, but for those that the lattice does not resolve.
    greatest_force_mn
        Greatest of them in mN.
    greatest_tension_kpa
        Mean tension in kPa that 99 % of the skin's area does not exceed.
    mean_tension_kpa
        Mean tension, averaged over the skin's area, in kPa.
    scar_length_mm
        Length of all seams in mm.
    scar_to_lines_deg
        Mean angle between the seams and the lines of the skin in degrees, weighted by length: 0 along, 90 across.
    open_area_mm2
        Area of the wound that is still open in mm².
    dog_ear_mm
        Greatest height of a dog-ear in mm.
    undermined_mm2
        Area inside the lines of undermining in mm².
    moved_mm
        By label, how far each landmark has moved in mm.
    moved_by_mm
        By label, where to along x, y and z in mm.
    stretched
        By label of a landmark of several points, how much longer the line through them is, as a share.
    regions
        By name of a region, the greatest (as above) and the mean tension of its skin in kPa.
    unresolved
        How many sutures the lattice does not resolve.
    """

    name: str
    closing_force_mn: float
    greatest_force_mn: float
    greatest_tension_kpa: float
    mean_tension_kpa: float
    scar_length_mm: float
    scar_to_lines_deg: float
    open_area_mm2: float
    dog_ear_mm: float
    undermined_mm2: float
    moved_mm: dict[str, float] = field(default_factory=dict)
    moved_by_mm: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    stretched: dict[str, float] = field(default_factory=dict)
    regions: dict[str, tuple[float, float]] = field(default_factory=dict)
    unresolved: int = 0


# What is shown of it: a field, what it is called, its unit.
SHOWN = (
    ("closing_force_mn", "closing force", "mN"),
    ("greatest_force_mn", "greatest force of a suture", "mN"),
    ("greatest_tension_kpa", "greatest tension of the skin", "kPa"),
    ("mean_tension_kpa", "mean tension of the skin", "kPa"),
    ("scar_length_mm", "scar", "mm"),
    ("scar_to_lines_deg", "scar to skin lines", "°"),
    ("open_area_mm2", "open wound", "mm²"),
    ("dog_ear_mm", "greatest dog-ear", "mm"),
    ("undermined_mm2", "undermined", "mm²"),
)


def compared(name: str, end: CacheEnd) -> Compared:
    """Measure an operation.

    Parameters
    ----------
    name
        Name to show.
    end
        The last frame of its cache.

    Returns
    -------
    Compared
        The measures.
    """
    seams = end.measures.values()
    ears = [each[key] for each in seams for key in ("startDogEar", "endDogEar") if math.isfinite(each[key])]
    single = {label: float(np.linalg.norm(now - rest)) for label, (rest, now) in end.landmarks.items()}
    lines = {label: float(np.linalg.norm(now - rest, axis=1).max()) for label, (rest, now) in end.lines.items()}
    undermined = [_area(np.array(event.points)) for event in end.procedure.events if isinstance(event, Undermine)]
    return Compared(
        name,
        sum(end.forces.values()),
        max(end.forces.values(), default=math.nan),
        _share(end.tension, end.area, GREATEST),
        float(np.average(end.tension, weights=end.area)) if len(end.tension) else math.nan,
        sum(each["scarLength"] for each in seams),
        _to_lines(end),
        sum(each["openArea"] for each in seams),
        max(ears, default=math.nan),
        sum(undermined),
        single | lines,
        {label: _vector(now - rest) for label, (rest, now) in end.landmarks.items()},
        {label: _length(now) / _length(rest) - 1.0 for label, (rest, now) in end.lines.items()},
        {name: (_share(*each, share=GREATEST), _mean(*each)) for name, each in skin_regions(end).items()},
        len(end.unresolved),
    )


def _mean(values: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    return float(np.average(values, weights=weights))


def _vector(way: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = way.tolist()
    return (float(x), float(y), float(z))


def _length(line: NDArray[np.float64]) -> float:
    return max(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()), 1e-9)


def comparison_rows(columns: Sequence[Compared]) -> list[list[str]]:
    """Write the measures as rows of a table, a column for each operation.

    Parameters
    ----------
    columns
        The operations.

    Returns
    -------
    list[list[str]]
        Rows of text: what it is with its unit, then the values; then regions and landmarks, those that more than one
        has.
    """
    rows = [[f"{title}, {unit}", *(value_text(getattr(each, name)) for each in columns)] for name, title, unit in SHOWN]
    if any(each.unresolved for each in columns):
        rows.insert(
            2, ["sutures left out, as the lattice does not resolve them", *(str(each.unresolved) for each in columns)]
        )
    for name in shared_names([each.regions for each in columns]):
        pairs = [each.regions.get(name, (math.nan, math.nan)) for each in columns]
        rows.append([f"{name}: greatest tension, kPa", *(value_text(greatest) for greatest, _ in pairs)])
        rows.append([f"{name}: mean tension, kPa", *(value_text(mean) for _, mean in pairs)])
    for label in shared_names([each.moved_mm for each in columns]):
        rows.append([f"{label} moved, mm", *(value_text(each.moved_mm.get(label, math.nan)) for each in columns)])
        by = [" ".join(f"{v:.1f}" for v in each.moved_by_mm.get(label, ())) for each in columns]
        if any(by):
            rows.append([f"{label} moved along x, y, z, mm", *by])
        if any(label in each.stretched for each in columns):
            longer = [value_text(100.0 * each.stretched.get(label, math.nan)) for each in columns]
            rows.append([f"{label} longer, %", *longer])
    return rows


def shared_names(columns: Sequence[Mapping[str, object]]) -> list[str]:
    """List the names that more than one operation has, in their order.

    Parameters
    ----------
    columns
        Something by name, of each operation.

    Returns
    -------
    list[str]
        The names; all of them where there is one operation alone.
    """
    names = dict.fromkeys(name for each in columns for name in each)
    return [name for name in names if len(columns) == 1 or sum(name in each for each in columns) > 1]


def one_line(column: Compared) -> str:
    """Write what is measured of an operation in a line.

    Parameters
    ----------
    column
        The operation.

    Returns
    -------
    str
        What is known of it, with units.
    """
    said = [(title, value_text(getattr(column, name)), unit) for name, title, unit in SHOWN]
    return "; ".join(f"{title} {text}{'' if unit == '°' else _UNBROKEN}{unit}" for title, text, unit in said if text)


def value_text(value: float) -> str:
    """Write a value of the table.

    Parameters
    ----------
    value
        The value.

    Returns
    -------
    str
        Three digits, or whole above 100; nothing where it is not known.
    """
    if not math.isfinite(value):
        return ""
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _share(values: NDArray[np.float64], weights: NDArray[np.float64], share: float) -> float:
    """The value that this share of the weights does not exceed."""
    if not len(values):
        return math.nan
    order = np.argsort(values)
    summed = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(summed, share * summed[-1])])


def _area(points: NDArray[np.float64]) -> float:
    """Area of a closed line that lies nearly in a plane, mm²."""
    around = points - points.mean(axis=0)
    return 0.5 * float(np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)))


def _to_lines(end: CacheEnd) -> float:
    """Mean angle of the seams to the lines of the skin, by length; NaN without seams or lines."""
    procedure = end.procedure
    material = procedure.material(procedure.tissue.material)
    if not end.seams or not (procedure.skin_lines or material.has_direction):
        return math.nan
    starts = np.vstack([line[:-1] for line in end.seams.values()])
    ways = np.vstack([np.diff(line, axis=0) for line in end.seams.values()])
    sizes = np.linalg.norm(ways, axis=1)
    points, normals = SkinSheet.of(procedure.tissue).at(starts)
    if procedure.skin_lines:
        lines = skin_field(procedure.skin_lines, points, normals, material).directions
    else:
        lines = np.tile(np.asarray(material.fiber_direction, np.float64), (len(points), 1))
        lines -= np.einsum("ij,ij->i", lines, normals)[:, None] * normals
    along = sizes > 1e-9
    cosines = np.abs(np.einsum("ij,ij->i", ways, lines))[along]
    cosines /= np.maximum(sizes * np.linalg.norm(lines, axis=1), 1e-300)[along]
    angles = np.degrees(np.arccos(np.clip(cosines, 0.0, 1.0)))
    return float(np.average(angles, weights=sizes[along]))
