"""The force on each suture: along each closure, in all, at most, and the share of the donor site.

A closure is what is sewn by sutures of one name with numbers: `skin_near_1`, `skin_near_2`, or a layer of a suture run:
`flap/skin/1`, `flap/skin/2`. Its curve goes through the middles of their anchors at rest.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Suture
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.program import Program
from lappet.program.thread_pieces import bites_at_wounds, thread_pieces
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
    pull_mn
        What it draws the edges of the wound together with in mN: of a thread with several bites its tension times the
        pieces that cross the wound, each by the cosine of its angle to the direction across at rest.
    force_error_mn
        Estimated error of `force_mn` in mN, or None without an estimate.
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
    pull_mn: float
    force_error_mn: float | None = None


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
    return re.sub(r"[/_ -]*\d+$", "", name) or name


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


def suture_forces(program: Program, frame: SolvedFrame) -> list[SutureForce]:
    """List the forces on the sutures of a frame.

    Parameters
    ----------
    program
        The program.
    frame
        A frame of it.

    Returns
    -------
    list[SutureForce]
        A row for each suture that is placed, closure by closure and along each.
    """
    events = {suture.name: suture for suture in program.stitches}
    along = _along_closures(program.stitches)
    names = [program.sutures[i] for i in frame.suture_index]
    crossing = _Crossing.of(program, frame)
    resolved = _resolved(frame, crossing)
    pulls = frame.suture_forces * crossing.pulls()
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
            float(pull),
        )
        for name, force, vector, gap, part, bites, pull in zip(
            names, frame.suture_forces, vectors, apart, resolved, bite_forces(frame), pulls, strict=True
        )
    ]
    return sorted(rows, key=lambda row: (row.closure, row.along_mm))


@dataclass(frozen=True, eq=False)
class _Crossing:
    """How the pieces of the sutures of a frame cross wounds.

    inner: number of bites of each suture between its ends (A,). row: suture of each piece (p,). across: cosine of the
    angle of each to the direction across the wound, 0 where it crosses none (p,).
    """

    inner: NDArray[np.int32]
    row: NDArray[np.int64]
    across: NDArray[np.float64]

    @classmethod
    def of(cls, program: Program, frame: SolvedFrame) -> _Crossing:
        count = len(frame.suture_index)
        inner = frame.suture_inner_bites if len(frame.suture_inner_bites) else np.zeros(count, np.int32)
        row = np.repeat(np.arange(count), inner + 1)
        across = np.zeros(len(row))
        constraints = next((each for each in program.frames if each.time == frame.time), None)
        if constraints is not None and inner.any():
            surface = next(epoch.surface for epoch in program.epochs if epoch.index == constraints.epoch)
            pieces = thread_pieces(constraints)
            points, triangles = pieces.points.reshape(-1, 3), pieces.triangles.reshape(-1)
            held = bites_at_wounds(surface, points, triangles, program.settings.spacing)
            across = across if held is None else held.across()
        return cls(inner, row, across)

    def pulls(self) -> NDArray[np.float64]:
        """How many times its force each suture draws a wound's edges together with (A,); once where it crosses none."""
        sums = np.bincount(self.row, self.across, len(self.inner))
        return np.where((self.inner > 0) & (sums > 0.0), sums, 1.0)


def _resolved(frame: SolvedFrame, crossing: _Crossing) -> NDArray[np.bool_]:
    """Which sutures the lattice resolves (A,); all where it is not known.

    Between two bites on either side of a cut's end the cell may not be cut: what they hold is then the same tissue in
    part, and the force between them that cell's own. Of a thread with more bites the pieces count that cross a wound,
    or all where none does; it is resolved where one of them is, since it slides.
    """
    row, count = crossing.row, len(crossing.inner)
    if len(frame.suture_shared) != len(row):
        return np.ones(count, bool)
    crosses = np.bincount(row, crossing.across, count) > 0.0
    counts = ~crosses[row] | (crossing.across > 0.0)
    found = np.zeros(count, bool)
    found[row[counts & (frame.suture_shared <= MOST_SHARED)]] = True
    return found


def closing_tension(rows: Sequence[SutureForce], scar_length: float) -> float | None:
    """Compute the closing tension of a seam or of one of its closures: the pull of its sutures per length of the scar.

    A suture that the lattice does not resolve takes its share of its closure's length with it.

    Parameters
    ----------
    rows
        The rows of its sutures that are placed, of one closure or of several that lie over each other.
    scar_length
        Length of the scar in mm.

    Returns
    -------
    float | None
        The tension in N/mm, or None while no suture that the lattice resolves is placed.
    """
    tension = None
    for closure in dict.fromkeys(row.closure for row in rows):
        own = [row for row in rows if row.closure == closure]
        resolved = [row.pull_mn for row in own if row.resolved]
        if resolved and scar_length > 0.0:
            part = sum(resolved) / (scar_length * len(resolved) / len(own)) / 1000.0
            tension = part + (tension or 0.0)
    return tension


def suture_warnings(program: Program, rows: Sequence[SutureForce]) -> list[Problem]:
    """Warn of sutures that may cut through the tissue, and of those whose ends the lattice does not part.

    Parameters
    ----------
    program
        The program.
    rows
        The rows of all frames.

    Returns
    -------
    list[Problem]
        One for each such suture, of the frame in which it pulls most.
    """
    events = {suture.name: suture for suture in program.stitches}
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
