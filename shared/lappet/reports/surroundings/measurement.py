"""How far the scar lies elsewhere where a rim is free, and where it is farther away.

Holding a rim adds a constraint, leaving out what lies beyond it takes energy away. Of linear elasticity it follows that
the energy in which whole tissue comes to rest lies between those of the two (Dirichlet-Neumann bracketing; Courant and
Hilbert 1953, Methods of Mathematical Physics, vol. 1, ch. VI). How far apart their scars lie is therefore taken for the
most that the cut-out can leave out; whether it is, in a nonlinear solve, is tried with a cut-out that reaches farther.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model
from lappet.output.solve_to_cache import solve_procedure
from lappet.procedure import Procedure, Suture, SutureRun
from lappet.reports.report_progress import ReportProgress
from lappet.reports.surroundings.free_rim import with_free_rim
from lappet.usd.cache_end import CacheEnd, read_cache_end
from lappet.usd.stage import read_procedure


@dataclass(frozen=True)
class SurroundingsRow:
    """An operation with its rim held, free and farther away, in its last frame.

    Parameters
    ----------
    name
        Name of the operation, or of the procedure's file.
    model
        The model that it is on; empty for a procedure's own tissue.
    free_mm, free_rms_mm
        Greatest and root mean square distance in mm between the scar with the rim free and held.
    held_mn, free_mn
        Force of the sutures that are resolved in all of the solves, in mN, with the rim held and free.
    reach
        How many times as far as usual the wider cut-out reaches; None where there is none.
    wider_mm, wider_rms_mm
        Distances in mm between the wider cut-out's scar, its rim held, and the usual one's; None where there is none.
    wider_mn
        Force of the same sutures in the wider cut-out in mN; None where there is none.
    problem
        Why something was not solved, a sentence; empty where nothing was in the way. What is missing is None.
    """

    name: str
    model: str
    free_mm: float | None = None
    free_rms_mm: float | None = None
    held_mn: float | None = None
    free_mn: float | None = None
    reach: float | None = None
    wider_mm: float | None = None
    wider_rms_mm: float | None = None
    wider_mn: float | None = None
    problem: str = ""

    @property
    def bounded(self) -> bool | None:
        """Whether the wider cut-out changes no more than the free rim; None where one was not solved."""
        if self.wider_mm is None or self.free_mm is None:
            return None
        return self.wider_mm <= self.free_mm


def solves_of(name: str, reach: float | None) -> int:
    """Count the solves that an operation takes: held, free, and of models farther away, if wanted.

    Parameters
    ----------
    name
        An operation on a model, or a procedure's file.
    reach
        How many times as far as usual the wider cut-out of a model reaches; None for none.

    Returns
    -------
    int
        Number of solves.
    """
    return 3 if reach is not None and name in REGIONAL_FLAPS else 2


def measure_surroundings(
    name: str, folder: Path, reach: float | None = None, progress: ReportProgress | None = None
) -> SurroundingsRow:
    """Solve an operation with its rim held and free, and with a wider cut-out if wanted.

    Parameters
    ----------
    name
        An operation on a model (`lappet.models.regional_flaps`), or a procedure's file.
    folder
        Where the caches go; it is there.
    reach
        How many times as far as usual the wider cut-out of a model reaches; None for none.
    progress
        Is told how the solves go, with a line of text for each; nothing is when None.

    Returns
    -------
    SurroundingsRow
        What was found.

    Raises
    ------
    RefusedError
        If there is no such operation, its rim cannot be let go, or it closes nothing.
    """
    progress = progress or ReportProgress()
    flap = REGIONAL_FLAPS.get(name)
    procedure = flap_on_model(name) if flap is not None else read_procedure(Path(name))
    label = name if flap is not None else Path(name).stem
    if not any(isinstance(event, (Suture, SutureRun)) for event in procedure.events):
        raise refused(ProblemCode.SURROUNDINGS_NO_SEAM, "", label)
    ways = {"held": procedure, "free": with_free_rim(procedure)}
    if flap is not None and reach is not None:
        ways["wider"] = flap_on_model(name, reach=reach)
    ends: dict[str, CacheEnd] = {}
    problem = ""
    for way, each in ways.items():
        try:
            ends[way] = _end(each, folder / f"{label}_{way}.usdc", progress)
        except RefusedError as error:
            problem = str(error.problems[0])
            progress.say(f"{label}, {way}: {problem}")
    row = SurroundingsRow(label, flap.model if flap is not None else "", reach=reach if flap is not None else None)
    return replace(row, problem=problem, **_compared(label, ends))


def _compared(name: str, ends: dict[str, CacheEnd]) -> dict[str, Any]:
    """The fields of a row that follow from the ends."""
    held = ends.pop("held", None)
    if held is None:
        return {}
    if not held.seams:
        raise refused(ProblemCode.SURROUNDINGS_NO_SEAM, "", name)
    common = set(held.forces).intersection(*(end.forces for end in ends.values()))
    fields: dict[str, Any] = {"held_mn": _force(held, common)}
    for way, end in ends.items():
        apart = _apart(held, end)
        fields[f"{way}_mm"] = float(apart.max())
        fields[f"{way}_rms_mm"] = float(np.sqrt(np.mean(apart**2)))
        fields[f"{way}_mn"] = _force(end, common)
    return fields


def _end(procedure: Procedure, cache: Path, progress: ReportProgress) -> CacheEnd:
    result = solve_procedure(procedure, cache, observer=progress.solve(cache.stem), error_estimate=False)
    if not result.complete:
        raise refused(ProblemCode.REPORT_NOT_CONVERGED, cache.name, str(result.reason))
    progress.say(f"{cache.stem}: {len(result.frames)} frames, {result.wall_seconds:.0f} s.")
    return read_cache_end(cache)


def _apart(one: CacheEnd, other: CacheEnd) -> NDArray[np.float64]:
    """Distances in mm between the scars of both, at as many places along each seam."""
    return np.concatenate(
        [np.linalg.norm(line - other.seams[name], axis=1) for name, line in one.seams.items() if name in other.seams]
    )


def _force(end: CacheEnd, sutures: Iterable[str]) -> float:
    return sum(end.forces[name] for name in sorted(sutures))
