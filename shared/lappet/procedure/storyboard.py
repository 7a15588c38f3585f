"""A procedure as text: the storyboard (`repr`), and what `lappet inspect` prints.

Lengths are mm, forces mN, moduli kPa; times are time codes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from lappet.procedure.events import Event, Excision, Hook, Incision, Landmark, Retractor, Suture, Undermine
from lappet.procedure.exact_values import Point
from lappet.procedure.scene_profile import profile_lines
from lappet.procedure.tissue import Material, Region

if TYPE_CHECKING:
    from lappet.procedure.procedure import Procedure


def storyboard(procedure: Procedure) -> str:
    """Describe a procedure in lines: the tissue, its materials, then the events in time order (landmarks last).

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    str
        Several lines of text.
    """
    tissue = procedure.tissue
    lines = [f"Procedure, {_timeline(procedure)}", f"  tissue     {_tissue(procedure)}"]
    lines += [f"  material   {_material(material)}" for material in procedure.materials]
    for bone in procedure.bones:
        lines.append(f"  bone       {bone.name}: {len(bone.face_vertex_counts)} faces, {_size(bone.points)}")
    lines += [f"  region     {_region(region)}" for region in tissue.regions]
    if tissue.subsets:
        held = ", ".join(f"{name} ({len(faces)})" for name, faces in tissue.subsets.items())
        lines.append(f"  faces      {held}")
    width = max((len(event.name) for event in procedure.events), default=0)
    for event in in_time_order(procedure.events):
        lines.append(
            f"  {_when(event):>11}  {event.kind.lower():<9}  {event.name:<{width}}  {describe(event)}".rstrip()
        )
    return "\n".join(lines)


def in_time_order(events: Sequence[Event]) -> list[Event]:
    """Sort events by the time at which they begin; landmarks, which have none, come last.

    Parameters
    ----------
    events
        The events; those that begin at once keep their order.

    Returns
    -------
    list[Event]
        The sorted events.
    """
    return sorted(events, key=lambda event: (math.inf, 0.0) if isinstance(event, Landmark) else (begins(event), 0.0))


def begins(event: Event) -> float:
    """Tell when an event begins to act.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    float
        Its time code; minus infinity for a landmark.
    """
    match event:
        case Incision() | Excision() | Undermine():
            return event.time
        case Landmark():
            return -math.inf
        case _:
            return event.start


def describe(event: Event) -> str:
    """Describe what an event does, in a few words with units.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    str
        A part of a sentence.
    """
    match event:
        case Incision():
            depth = "through" if event.depth is None else f"{_n(event.depth)} mm deep"
            closed = ", closed" if event.closed else ""
            return f"{depth}, {_curve(event.points, event.basis, event.closed)}{closed}, kerf {_n(event.kerf)} mm"
        case Excision():
            return "discards the fragment at " + " and ".join(_at(seed) for seed in event.seeds)
        case Undermine():
            return f"frees the bed inside {_curve(event.points, event.basis, True)}"
        case Hook():
            last = event.targets[-1][1] if event.targets else event.anchor
            travel = math.dist(event.anchor, last)
            return f"{_at(event.anchor)} drawn {_n(travel)} mm to {_at(last)}, {_n(event.stiffness)} mN/mm"
        case Retractor():
            return f"moves {event.grip!r}{_motion(event)}"
        case Suture():
            first, second = event.anchors
            gap = f"{_n(math.dist(first, second))} mm apart at rest"
            return f"{_at(first)} to {_at(second)}, {gap}, {_n(event.stiffness)} mN/mm"
        case Landmark():
            return f"{event.label!r} at " + " and ".join(_at(point) for point in event.points)


def inspection(
    procedure: Procedure,
    epochs: Sequence[str] = (),
    lattice: Sequence[str] = (),
    notes: Sequence[str] = (),
    costs: Mapping[str, str] | None = None,
) -> str:
    """Compose what `lappet inspect` prints: storyboard, epochs, scene profile, lattice counts, notes.

    Parameters
    ----------
    procedure
        The procedure.
    epochs
        A line for each epoch.
    lattice
        Lines about the lattice.
    notes
        Further lines.
    costs
        What features cost, as text by name.

    Returns
    -------
    str
        Several lines of text.
    """
    parts = [storyboard(procedure)]
    for title, lines in (
        ("Epochs", epochs),
        ("Scene profile", profile_lines(procedure, costs)),
        ("Lattice", lattice),
        ("Notes", notes),
    ):
        if lines:
            parts.append("\n".join([title, *(f"  {line}" for line in lines)]))
    return "\n\n".join(parts)


def _timeline(procedure: Procedure) -> str:
    frames = len(procedure.frames())
    span = f"{_n(procedure.start_time)} to {_n(procedure.end_time)}"
    return f"time codes {span} at {_n(procedure.fps)} per second, {frames} frame{'' if frames == 1 else 's'}"


def _tissue(procedure: Procedure) -> str:
    tissue = procedure.tissue
    gravity = f", gravity {_n(tissue.gravity)} m/s²" if tissue.gravity else ""
    return (
        f"{_size(tissue.points)}, {len(tissue.points)} points, {len(tissue.face_vertex_counts)} faces, "
        f"of {tissue.material or 'no material'}, spacing {_n(tissue.spacing)} mm, "
        f"bed {_n(tissue.bed_stiffness)} kPa/mm{gravity}"
    )


def _material(material: Material) -> str:
    text = f"{material.name}: {material.model}, E {_n(material.youngs_modulus)} kPa, ν {_n(material.poissons_ratio)}"
    if material.model == "mooneyRivlin":
        text += f", μ₀₁/μ₁₀ {_n(material.mooney_ratio)}"
    if material.fiber_k1:
        text += (
            f", fibres k₁ {_n(material.fiber_k1)} kPa, k₂ {_n(material.fiber_k2)} along {_at(material.fiber_direction)}"
        )
    if material.has_muscle:
        peak = max((value for _, value in material.muscle_activation), default=0.0)
        along = "" if material.has_fibers else f" along {_at(material.fiber_direction)}"
        text += f", muscle of {_n(material.muscle_stress)} kPa{along}, active up to {_n(peak)}"
    if material.has_prestretch:
        text += f", prestretch {_n(material.prestretch[0])} × {_n(material.prestretch[1])}"
    return text + f", {_n(material.density)} kg/m³"


def _region(region: Region) -> str:
    if math.isinf(region.depth_to):
        where = f"deeper than {_n(region.depth_from)} mm below" if region.depth_from else "all below"
    else:
        where = f"{_n(region.depth_from)} to {_n(region.depth_to)} mm below"
    return f"{where} {region.faces} is of {region.material or 'no material'}"


def _when(event: Event) -> str:
    match event:
        case Hook() | Retractor():
            return f"{_n(event.start)} – {_n(event.release)}"
        case Suture():
            return f"{_n(event.start)} – {_n(event.start + event.duration)}"
        case Landmark():
            return "always"
        case _:
            return _n(event.time)


def _curve(points: Sequence[Point], basis: str, closed: bool) -> str:
    ring = [*points, points[0]] if closed and points else list(points)
    if basis == "linear":
        return f"{_n(sum(math.dist(a, b) for a, b in pairwise(ring)))} mm through {len(points)} points"
    return f"a {basis} curve of {len(points)} points"


def _motion(event: Retractor) -> str:
    samples = [np.array(matrix).reshape(4, 4) for _, matrix in event.motion if len(matrix) == 16]
    if not samples:
        return ""
    with np.errstate(invalid="ignore"):
        turn = samples[0][:3, :3].T @ samples[-1][:3, :3]
        angle = math.degrees(math.acos(float(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))
    travel = _n(float(np.linalg.norm(samples[-1][3, :3] - samples[0][3, :3])))
    turned = f" and turns it by {angle:.3g}°" if angle > 0.05 else ""
    return f" by {travel} mm{turned} over {len(samples)} samples"


def _size(points: np.ndarray) -> str:
    if len(points) == 0:
        return "nothing"
    return " × ".join(_n(float(v)) for v in np.ptp(points, axis=0)) + " mm"


def _at(point: Point) -> str:
    return "(" + ", ".join(_n(v) for v in point) + ")"


def _n(value: float) -> str:
    return f"{value:.4g}"
