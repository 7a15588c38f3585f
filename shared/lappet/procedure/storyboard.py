"""A procedure as text: the storyboard (`repr`), and what `lappet inspect` prints.

Lengths are mm, forces mN, moduli kPa; times are time codes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lappet.procedure.event_text import describe, duration_text
from lappet.procedure.events import Event, Landmark, begins, kind_words
from lappet.procedure.laid_flap import LaidFlap
from lappet.procedure.muscle import Muscle
from lappet.procedure.plain_text import number, place
from lappet.procedure.plate import Plate
from lappet.procedure.position import position_of
from lappet.procedure.scene_profile import profile_lines
from lappet.procedure.tissue import Material, Region
from lappet.procedure.vessel import Vessel

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
        moves = f", moves in {len(bone.motion)} samples" if bone.moves else ""
        lines.append(f"  bone       {bone.name}: {len(bone.face_vertex_counts)} faces, {_size(bone.points)}{moves}")
    for each in procedure.scenery:
        lines.append(f"  scenery    {each.name}: {each.kind}, {len(each.face_vertex_counts)} faces")
    lines += [f"  region     {_region(region)}" for region in tissue.regions]
    lines += [f"  {vessel.kind:<9}  {_vessel(vessel)}" for vessel in procedure.vessels]
    lines += [f"  muscle     {_muscle(muscle)}" for muscle in procedure.muscles]
    lines += [f"  flap       {_flap(flap)}" for flap in procedure.flaps]
    lines += [f"  plate      {_plate(plate)}" for plate in procedure.plates]
    if tissue.subsets:
        held = ", ".join(f"{name} ({len(faces)})" for name, faces in tissue.subsets.items())
        lines.append(f"  faces      {held}")
    width = max((len(event.name) for event in procedure.events), default=0)
    for event in in_time_order(procedure.events):
        lines.append(
            f"  {duration_text(event):>11}  {kind_words(event):<9}  {event.name:<{width}}  {describe(event)}".rstrip()
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


def inspection(
    procedure: Procedure,
    epochs: Sequence[str] = (),
    lattice: Sequence[str] = (),
    notes: Sequence[str] = (),
    costs: Mapping[str, str] | None = None,
    runs: Sequence[str] = (),
) -> str:
    """Compose what `lappet inspect` prints: storyboard, epochs, suture runs, scene profile, lattice counts, notes.

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
    runs
        A line for each suture run.

    Returns
    -------
    str
        Several lines of text.
    """
    parts = [storyboard(procedure)]
    for title, lines in (
        ("Epochs", epochs),
        ("Suture runs", runs),
        ("Scene profile", profile_lines(procedure, costs)),
        ("Lattice", lattice),
        ("Notes", notes),
    ):
        if lines:
            parts.append("\n".join([title, *(f"  {line}" for line in lines)]))
    return "\n\n".join(parts)


def _timeline(procedure: Procedure) -> str:
    frames = len(procedure.frames())
    span = f"{number(procedure.start_time)} to {number(procedure.end_time)}"
    return f"time codes {span} at {number(procedure.fps)} per second, {frames} frame{'' if frames == 1 else 's'}"


def _tissue(procedure: Procedure) -> str:
    tissue = procedure.tissue
    lies = position_of(tissue.gravity_direction) or f"along {place(tissue.gravity_direction)}"
    gravity = f"gravity {number(tissue.gravity)} m/s², {lies.replace('_', ' ')}" if tissue.has_gravity else "no gravity"
    apart = ", kept from passing through itself" if tissue.self_contact else ""
    return (
        f"{_size(tissue.points)}, {len(tissue.points)} points, {len(tissue.face_vertex_counts)} faces, "
        f"of {tissue.material or 'no material'}, spacing {number(tissue.spacing)} mm, "
        f"bed {number(tissue.bed_stiffness)} kPa/mm, {number(tissue.bed_shear)} in shear, {gravity}{apart}"
    )


def _material(material: Material) -> str:
    youngs, poissons = number(material.youngs_modulus), number(material.poissons_ratio)
    text = f"{material.name}: {material.model}, E {youngs} kPa, ν {poissons}"
    if material.model == "mooneyRivlin":
        text += f", μ₀₁/μ₁₀ {number(material.mooney_ratio)}"
    if material.fiber_k1:
        k1, k2 = number(material.fiber_k1), number(material.fiber_k2)
        slack = f" from a stretch of {number(material.fiber_slack)}" if material.fiber_slack != 1.0 else ""
        aside = f" at {number(material.fiber_angle)}° to either side" if material.fiber_angle else ""
        text += f", fibers k₁ {k1} kPa, k₂ {k2}{slack}{aside} along {place(material.fiber_direction)}"
    if material.has_muscle:
        peak = max((value for _, value in material.muscle_activation), default=0.0)
        along = "" if material.has_fibers else f" along {place(material.fiber_direction)}"
        text += f", muscle of {number(material.muscle_stress)} kPa{along}, active up to {number(peak)}"
    if material.has_prestretch:
        text += f", prestretch {number(material.prestretch[0])} × {number(material.prestretch[1])}"
    return text + f", {number(material.density)} kg/m³"


def _region(region: Region) -> str:
    if math.isinf(region.depth_to):
        where = f"deeper than {number(region.depth_from)} mm below" if region.depth_from else "all below"
    else:
        where = f"{number(region.depth_from)} to {number(region.depth_to)} mm below"
    return f"{where} {region.faces} is of {region.material or 'no material'}"


def _vessel(vessel: Vessel) -> str:
    course = ", a typical course" if vessel.typical_course else ""
    label = f" {vessel.label!r}" if vessel.label else ""
    return f"{vessel.name}:{label} of radius {number(vessel.radius)} mm through {len(vessel.points)} points{course}"


def _muscle(muscle: Muscle) -> str:
    strands = f"{len(muscle.strands)} strand{'' if len(muscle.strands) == 1 else 's'}"
    thickest = max((radius for strand in muscle.strands for radius in strand.radii), default=0.0)
    return f"{muscle.name}: {strands} of {muscle.material or 'no material'}, radius up to {number(thickest)} mm"


def _flap(flap: LaidFlap) -> str:
    measures = ", ".join(f"{name} {number(value)}" for name, value in flap.measures)
    mirrored = ", mirrored" if flap.mirrored else ""
    return f"{flap.name}: {flap.design} at {place(flap.at)} mm, {measures}{mirrored}, {len(flap.events)} events"


def _plate(plate: Plate) -> str:
    panels = f"{len(plate.panels)} panels" if plate.panels else "the operation's steps"
    return f"{plate.name}: {plate.style}, {number(plate.width)} mm wide, {panels}, {len(plate.annotations)} annotations"


def _size(points: np.ndarray) -> str:
    if len(points) == 0:
        return "nothing"
    return " × ".join(number(float(v)) for v in np.ptp(points, axis=0)) + " mm"
