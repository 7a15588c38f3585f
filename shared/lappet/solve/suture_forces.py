"""The force on each suture: along each closure, in all, at most, and the share of the donor site.

A closure is what is sewn by sutures of one name with numbers: `skin_near_1`, `skin_near_2`. Its curve goes through the
middles of their anchors at rest.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Procedure, Suture
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.program import Program
from lappet.solve.bite_forces import bite_forces, bite_points

# A suture whose two ends hold more of the same tissue than this is not parted by the lattice (chosen).
MOST_SHARED = 0.1


@dataclass(frozen=True)
class SutureForce:
    """The force on one suture in one frame, a row of the table.

    Parameters
    ----------
    time
        Time code.
    suture
        Name of the suture.
    closure
        Name of the closure that it belongs to.
    along_mm
        Where it is along the closure at rest in mm.
    force_mn
        Its pull in mN; the tension of a thread.
    force_x_mn, force_y_mn, force_z_mn
        The force on the tissue at its first end in mN; of two ends the second has the opposite one.
    apart_mm
        Distance of its ends in mm; of a thread with several bites, its length through them.
    share
        Its share of the forces of all sutures of the frame that the lattice resolves.
    limit_mn
        Tension at which it cuts through the tissue in mN.
    resolved
        Whether the lattice parts its two ends; the force is meaningless where it does not.
    bite_mn
        The greatest force on one of its bites in mN: where a thread turns back, twice its tension.
    """

    time: float
    suture: str
    closure: str
    along_mm: float
    force_mn: float
    force_x_mn: float
    force_y_mn: float
    force_z_mn: float
    apart_mm: float
    share: float
    limit_mn: float
    resolved: bool
    bite_mn: float


def closure_of(name: str) -> str:
    """Name the closure of a suture: its name without its number.

    Parameters
    ----------
    name
        Name of the suture.

    Returns
    -------
    str
        Name of the closure.
    """
    return re.sub(r"[_ -]*\d+$", "", name) or name


def suture_number(name: str) -> int:
    """Find the number of a suture in its closure.

    Parameters
    ----------
    name
        Name of the suture.

    Returns
    -------
    int
        The number that its name ends with, 0 where there is none.
    """
    digits = re.search(r"\d+$", name)
    return int(digits.group()) if digits else 0


def suture_forces(procedure: Procedure, program: Program, frame: SolvedFrame) -> list[SutureForce]:
    """List the forces on the sutures of a frame.

    Parameters
    ----------
    procedure
        The procedure.
    program
        Its program.
    frame
        A frame of it.

    Returns
    -------
    list[SutureForce]
        A row for each suture that is placed, closure by closure and along each.
    """
    events = {event.name: event for event in procedure.events if isinstance(event, Suture)}
    along = _along_closures(list(events.values()))
    names = [program.sutures[i] for i in frame.suture_index]
    shared = frame.suture_shared if len(frame.suture_shared) == len(names) else np.zeros(len(names))
    resolved = shared <= MOST_SHARED
    total = float(frame.suture_forces[resolved].sum())
    apart = [np.linalg.norm(np.diff(points, axis=0), axis=1).sum() for points in bite_points(frame)]
    vectors = frame.suture_force_vectors
    vectors = vectors if len(vectors) == len(names) else np.full((len(names), 3), np.nan)
    rows = [
        SutureForce(
            frame.time,
            name,
            closure_of(name),
            along[name],
            float(force),
            float(vector[0]),
            float(vector[1]),
            float(vector[2]),
            float(gap),
            float(force) / total if part and total > 0.0 else 0.0,
            events[name].pull_through_limit,
            bool(part),
            float(bites.max()),
        )
        for name, force, vector, gap, part, bites in zip(
            names, frame.suture_forces, vectors, apart, resolved, bite_forces(frame), strict=True
        )
    ]
    return sorted(rows, key=lambda row: (row.closure, row.along_mm))


def summary(rows: Sequence[SutureForce]) -> dict[str, Any]:
    """Sum up the forces of a frame.

    Parameters
    ----------
    rows
        Its rows.

    Returns
    -------
    dict[str, Any]
        `total_mn`, `greatest_mn` and its `greatest_suture`, `donor_share` (None where no closure is a donor site's),
        `unresolved` sutures, which are left out of all sums, and `closures`: for each `total_mn`, `greatest_mn`,
        `share`, `tension_n_per_mm` (over its length between first and last suture, None for a single one) and the
        curve, `along_mm` and `force_mn`.
    """
    kept = [row for row in rows if row.resolved]
    total = sum(row.force_mn for row in kept)
    closures: dict[str, dict[str, Any]] = {}
    for name in dict.fromkeys(row.closure for row in kept):
        own = [row for row in kept if row.closure == name]
        forces, along = [row.force_mn for row in own], [row.along_mm for row in own]
        length = along[-1] - along[0]
        closures[name] = {
            "total_mn": sum(forces),
            "greatest_mn": max(forces),
            "share": sum(forces) / total if total > 0.0 else 0.0,
            # Each suture carries the piece half way to its neighbors; the ends have half a piece more outside.
            "tension_n_per_mm": sum(forces) / (length * len(own) / (len(own) - 1)) / 1000.0 if length > 0.0 else None,
            "along_mm": along,
            "force_mn": forces,
        }
    donors = [values["share"] for name, values in closures.items() if "donor" in name.lower()]
    greatest = max(kept, key=lambda row: row.force_mn, default=None)
    return {
        "total_mn": total,
        "greatest_mn": greatest.force_mn if greatest else 0.0,
        "greatest_suture": greatest.suture if greatest else None,
        "donor_share": sum(donors) if donors else None,
        "unresolved": [row.suture for row in rows if not row.resolved],
        "closures": closures,
    }


def suture_warnings(procedure: Procedure, rows: Sequence[SutureForce]) -> list[Problem]:
    """Warn of sutures that may cut through the tissue, and of those whose ends the lattice does not part.

    Parameters
    ----------
    procedure
        The procedure.
    rows
        The rows of all frames.

    Returns
    -------
    list[Problem]
        One for each such suture, of the frame in which it pulls most.
    """
    events = {event.name: event for event in procedure.events if isinstance(event, Suture)}
    most: dict[str, SutureForce] = {}
    for row in rows:
        if row.suture not in most or row.bite_mn > most[row.suture].bite_mn:
            most[row.suture] = row
    found = []
    for name, row in most.items():
        prim, place = f"{TIMELINE}/{name}", Place.at(*events[name].anchors)
        if not row.resolved:
            code, force = ProblemCode.SUTURE_UNRESOLVED, f"{row.force_mn:.4g}"
            found.append(problem(code, prim, force, place=place, time=row.time))
        elif row.bite_mn > row.limit_mn:
            code, force = ProblemCode.SUTURE_PULLS_THROUGH, f"{row.bite_mn:.4g}"
            found.append(problem(code, prim, force, place=place, time=row.time, limit=row.limit_mn))
    return found


def _along_closures(sutures: Sequence[Suture]) -> dict[str, float]:
    """Where each suture is along its closure in mm, in order of their numbers."""
    along: dict[str, float] = {}
    for closure in dict.fromkeys(closure_of(suture.name) for suture in sutures):
        own = sorted(
            (each for each in sutures if closure_of(each.name) == closure), key=lambda each: suture_number(each.name)
        )
        middles = np.array([np.mean(each.anchors, axis=0) for each in own])
        steps = np.linalg.norm(np.diff(middles, axis=0), axis=1)
        places: NDArray[np.float64] = np.concatenate([[0.0], np.cumsum(steps)])
        along.update({each.name: float(place) for each, place in zip(own, places, strict=True)})
    return along
