"""Names that cannot be the names of prims, or that two things in one place have."""

from __future__ import annotations

from collections import Counter

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure.prim_paths import (
    ANATOMY,
    BONE,
    FLAPS,
    MATERIALS,
    MUSCLES,
    PLATES,
    SCENERY,
    SKIN_LINES,
    TIMELINE,
    TISSUE,
)
from lappet.procedure.procedure import Procedure


def name_problems(procedure: Procedure) -> list[Problem]:
    """Find names that no prim can have, and names that two things in one place share.

    Parameters
    ----------
    procedure
        The procedure to check.

    Returns
    -------
    list[Problem]
        A problem for each such name.
    """
    places = [
        (TIMELINE, "event", [event.name for event in procedure.events]),
        (MATERIALS, "material", [material.name for material in procedure.materials]),
        (BONE, "bone", [bone.name for bone in procedure.bones]),
        (SKIN_LINES, "skin line", [line.name for line in procedure.skin_lines]),
        (ANATOMY, "vessel", [vessel.name for vessel in procedure.vessels]),
        (MUSCLES, "muscle", [muscle.name for muscle in procedure.muscles]),
        (FLAPS, "flap", [flap.name for flap in procedure.flaps]),
        (PLATES, "plate", [plate.name for plate in procedure.plates]),
        *_of_plates(procedure),
        (SCENERY, "scenery", [each.name for each in procedure.scenery]),
        (TISSUE, "face subset", list(procedure.tissue.subsets)),
    ]
    problems = []
    for place, kind, names in places:
        for name, times in Counter(names).items():
            prim = f"{place}/{name}"
            if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
                problems.append(problem(ProblemCode.NAME_NOT_A_PRIM, prim, repr(name), kind=kind))
            if times > 1:
                problems.append(problem(ProblemCode.NAME_TWICE, prim, repr(name), kind=kind, times=times))
    known = ", ".join(procedure.tissue.subsets) or "none"
    for name, times in Counter(region.faces for region in procedure.tissue.regions).items():
        prim = f"{TISSUE}/{name}"
        if name not in procedure.tissue.subsets:
            problems.append(problem(ProblemCode.REGION_NO_SUBSET, prim, repr(name), known=known))
        elif times > 1:
            problems.append(problem(ProblemCode.REGION_SUBSET_TWICE, prim, repr(name), times=times))
    regions = {region.faces for region in procedure.tissue.regions}
    for name, times in Counter(roller.faces for roller in procedure.tissue.rollers).items():
        prim = f"{TISSUE}/{name}"
        if name not in procedure.tissue.subsets:
            problems.append(problem(ProblemCode.ROLLER_FACES_UNKNOWN, prim, name, known=known))
        elif times > 1 or name in regions:
            problems.append(problem(ProblemCode.ROLLER_SUBSET_TWICE, prim, name))
    return problems


def _of_plates(procedure: Procedure) -> list[tuple[str, str, list[str]]]:
    """The places of panels and annotations, and the names there."""
    places = []
    for plate in procedure.plates:
        places.append((f"{PLATES}/{plate.name}/Panels", "panel", [panel.name for panel in plate.panels]))
        names = [each.name for each in plate.annotations]
        places.append((f"{PLATES}/{plate.name}/Annotations", "annotation", names))
    return places
