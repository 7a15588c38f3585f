"""What is suspicious about the places of events: each may be solved, but is probably not meant."""

from __future__ import annotations

import math
from itertools import pairwise

from lappet.checks.event_problems import at
from lappet.checks.narrow_flaps import narrow_flaps
from lappet.checks.suspicious_cuts import CutCheck
from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Incision, Procedure, Suture
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.rest_space import RestSpace

# Of the tissue's diagonal. Chosen: between a point and what holds the tissue lies half a diagonal at most, so a longer
# way stretches it to twice its length; human skin tears at 1.5 (Ní Annaidh et al. 2012, 10.1016/j.jmbbm.2011.08.016).
FAR = 0.5


def suspicious_events(
    procedure: Procedure, rest: RestSpace, thickness: float, spacing: float, wrong: set[str]
) -> list[Problem]:
    """Find events that may be solved, but whose places are probably not meant.

    Parameters
    ----------
    procedure
        The procedure.
    rest
        Its tissue at rest.
    thickness
        Mean thickness of the tissue in mm.
    spacing
        Lattice spacing in mm.
    wrong
        Paths of the prims with errors, which are left out.

    Returns
    -------
    list[Problem]
        The warnings.
    """
    events = [event for event in procedure.events if f"{TIMELINE}/{event.name}" not in wrong]
    found = CutCheck(rest, thickness, spacing).check([event for event in events if isinstance(event, Incision)])
    found += narrow_flaps(procedure, wrong)
    most = FAR * rest.diagonal
    for event in events:
        path = f"{TIMELINE}/{event.name}"
        if isinstance(event, Hook):
            time, target = max(event.targets, key=lambda sample: math.dist(event.anchor, sample[1]))
            away = math.dist(event.anchor, target)
            if away > most:
                where = Place.at(target, event.anchor)
                code = ProblemCode.HOOK_TARGET_FAR
                found.append(problem(code, path, f"{away:.4g}", place=where, where=at(target), time=time, most=most))
        elif isinstance(event, Suture):
            apart, *ends = max((math.dist(a, b), a, b) for a, b in pairwise(event.anchors))
            if apart > most:
                code = ProblemCode.SUTURE_LONG
                where, named = Place.at(*ends), " and ".join(map(at, ends))
                found.append(problem(code, path, f"{apart:.4g}", place=where, where=named, most=most))
    return found
