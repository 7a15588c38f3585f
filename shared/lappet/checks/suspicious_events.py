"""What is suspicious about the places of events: each may be solved, but is probably not meant."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from lappet.checks.event_problems import at
from lappet.checks.narrow_flaps import narrow_flaps
from lappet.checks.suspicious_cuts import CutCheck
from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Incision, Point, Procedure, Suture, Undermine
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.rest_space import RestSpace

# Of the tissue's diagonal. Chosen: between a point and what holds the tissue lies half a diagonal at most, so a longer
# way stretches it to twice its length; human skin tears at 1.5 (Ní Annaidh et al. 2012, 10.1016/j.jmbbm.2011.08.016).
FAR = 0.5
# A flap that is freed and turned about its base goes up to twice as far as it is long, without any stretch.
_TURNED = 2.0


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
    freed = min((event.time for event in events if isinstance(event, Undermine)), default=math.inf)
    hooks = [event for event in events if isinstance(event, Hook)]
    for event in events:
        path = f"{TIMELINE}/{event.name}"
        if isinstance(event, Hook):
            time, target = max(event.targets, key=lambda sample: math.dist(event.anchor, sample[1]))
            away = math.dist(event.anchor, target)
            if away > (_TURNED if event.start >= freed else 1.0) * most:
                where = Place.at(target, event.anchor)
                code = ProblemCode.HOOK_TARGET_FAR
                found.append(problem(code, path, f"{away:.4g}", place=where, where=at(target), time=time, most=most))
        elif isinstance(event, Suture):
            apart, one, other = max((math.dist(a, b), a, b) for a, b in pairwise(event.anchors))
            if apart > most and not any(_brings(hook, event.start, one, other, most) for hook in hooks):
                code = ProblemCode.SUTURE_LONG
                where, named = Place.at(one, other), f"{at(one)} and {at(other)}"
                found.append(problem(code, path, f"{apart:.4g}", place=where, where=named, most=most))
    return found


def _brings(hook: Hook, time: float, one: Point, other: Point, most: float) -> bool:
    """Tell whether a hook on the skin near one point has carried it near the other when a suture begins to draw."""
    way = np.subtract(hook.targets[-1][1], hook.anchor)
    if hook.start >= time:
        return False
    return any(
        math.dist(hook.anchor, here) < most and float(np.linalg.norm(np.add(here, way) - there)) < most
        for here, there in ((one, other), (other, one))
    )
