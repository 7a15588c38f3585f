"""Two or more solved operations beside each other: how they close, how the skin pulls, what they distort."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Undermine
from lappet.tissue.skin_lines import skin_field
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.cache_end import CacheEnd

GREATEST = (
    0.99  # share of the skin's area whose tension is at most the "greatest": single points of a seam do not count
)


@dataclass(frozen=True)
class Compared:
    """What is compared of an operation, at the last frame of its cache; NaN where it is not known.

    Parameters
    ----------
    name
        Name of the operation.
    closing_force_mn
        Sum of the forces of all sutures in mN.
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
        {label: float(np.linalg.norm(now - rest)) for label, (rest, now) in end.landmarks.items()},
    )


def comparison_rows(columns: Sequence[Compared]) -> list[list[str]]:
    """Write the measures as rows of a table, a column for each operation.

    Parameters
    ----------
    columns
        The operations.

    Returns
    -------
    list[list[str]]
        Rows of text: what it is with its unit, then the values; landmarks last, those that more than one has.
    """
    rows = [[f"{title}, {unit}", *(_text(getattr(each, name)) for each in columns)] for name, title, unit in SHOWN]
    labels = dict.fromkeys(label for each in columns for label in each.moved_mm)
    for label in labels:
        if sum(label in each.moved_mm for each in columns) > 1 or len(columns) == 1:
            moved = [_text(each.moved_mm.get(label, math.nan)) for each in columns]
            rows.append([f"{label} moved, mm", *moved])
    return rows


def plot_comparison(columns: Sequence[Compared], path: Path) -> None:
    """Draw the measures as bars.

    Parameters
    ----------
    columns
        The operations.
    path
        The picture (.png, .svg or .pdf).
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(3, 3, figsize=(10.0, 7.5), layout="constrained")
    colors = [f"C{k}" for k in range(len(columns))]
    for axis, (name, title, unit) in zip(axes.flat, SHOWN, strict=True):
        values = [getattr(each, name) for each in columns]
        axis.barh(
            [each.name for each in columns], [value if math.isfinite(value) else 0.0 for value in values], color=colors
        )
        axis.invert_yaxis()
        axis.set_title(f"{title} ({unit})", fontsize=9)
        axis.tick_params(labelsize=8)
        axis.margins(x=0.2)
        for k, value in enumerate(values):
            axis.text(
                value if math.isfinite(value) else 0.0, k, f" {_text(value) or 'not known'}", va="center", fontsize=8
            )
    figure.savefig(path, dpi=150)
    pyplot.close(figure)


def _text(value: float) -> str:
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
