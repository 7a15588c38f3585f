"""Names that cannot be the names of prims, or that two things in one place have."""

from __future__ import annotations

from collections import Counter

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure.prim_paths import BONE, MATERIALS, TIMELINE, TISSUE
from lappet.procedure.procedure import Procedure


def name_problems(procedure: Procedure) -> list[Problem]:
    """A problem for every name that cannot be the name of a prim, or that two things in one place have."""
    places = [
        (TIMELINE, "event", [event.name for event in procedure.events]),
        (MATERIALS, "material", [material.name for material in procedure.materials]),
        (BONE, "bone", [bone.name for bone in procedure.bones]),
        (TISSUE, "face subset", list(procedure.tissue.subsets)),
    ]
    problems = []
    for place, kind, names in places:
        for name, times in Counter(names).items():
            if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
                sentence = f"The {kind} is named {name!r}, which cannot be the name of a prim."
                remedy = "Use letters, digits and underscores, and no digit first."
                problems.append(Problem(ProblemCode.UNSORTED, f"{place}/{name}", repr(name), sentence, remedy))
            if times > 1:
                sentence = f"{times} {kind}s are named {name!r}."
                problems.append(
                    Problem(ProblemCode.UNSORTED, f"{place}/{name}", repr(name), sentence, "Give each its own name.")
                )
    regions = Counter(region.faces for region in procedure.tissue.regions)
    for name, times in regions.items():
        if name not in procedure.tissue.subsets:
            known = ", ".join(procedure.tissue.subsets) or "none"
            sentence = f"A region lies below the face subset {name!r}, which the tissue does not have."
            problems.append(
                Problem(
                    ProblemCode.UNSORTED, f"{TISSUE}/{name}", repr(name), sentence, f"Name one of its subsets: {known}."
                )
            )
        elif times > 1:
            sentence = f"{times} regions lie below the face subset {name!r}."
            problems.append(
                Problem(
                    ProblemCode.UNSORTED, f"{TISSUE}/{name}", repr(name), sentence, "Give each a subset of its own."
                )
            )
    return problems
