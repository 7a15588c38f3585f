"""Choose lattice spacing, quadrature and tolerance so that the displacement error meets a target.

A pilot at twice the tissue's own spacing is solved with each quadrature that may pay; its estimated error e at the
spacing h says the spacing that the target needs, h (target / e)^(1/p), and its seconds what that will cost. The
cheapest is solved in full, and refined again where its own estimate misses the target.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import Connect
from lappet.procedure import Procedure
from lappet.program.compile import DEFAULT, compile_program
from lappet.program.settings import SolverSettings
from lappet.solve.coarse_program import expected_order
from lappet.solve.error_estimate import ErrorEstimate, estimate_errors
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore

PILOT = 2.0  # of the tissue's spacing
CAUTION = 0.85  # of the spacing that the pilot asks for
ALGEBRAIC_SHARE = 0.25  # of the target that stopping early may take
TOLERANCE = SolverSettings.tolerance
MIN_TOLERANCE = {"float": 1e-5, "double": 1e-9}
QUADRATURES = (1, 4)
TRIES = 3
COST_ORDER = 3.0  # seconds grow as h^-3


@dataclass(frozen=True)
class Choice:
    """What to solve with.

    Parameters
    ----------
    settings
        The settings.
    expected
        Root mean square error in mm that the pilot foresees.
    sentence
        Says what was chosen.
    """

    settings: SolverSettings
    expected: float
    sentence: str


@dataclass(frozen=True)
class _Pilot:
    settings: SolverSettings
    needed: float
    error: float
    algebraic: float
    order: float
    cost: float


def worst_rms(errors: ErrorEstimate) -> float:
    """Find the greatest root mean square error of all frames.

    Parameters
    ----------
    errors
        The estimate.

    Returns
    -------
    float
        Error in mm; infinite where a frame has no discretization part.
    """
    if errors.reason is not None or any(error is None for error in errors.frames):
        return float("inf")
    return max((error.rms for error in errors.frames if error is not None), default=0.0)


def choose(
    procedure: Procedure,
    target: float,
    connect: Connect,
    solver: str,
    store: FrameStore,
    settings: SolverSettings = DEFAULT,
    *,
    until: float | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Choice:
    """Choose the settings that a target error needs, by pilots.

    Parameters
    ----------
    procedure
        The procedure.
    target
        Root mean square error in mm over the skin in the worst frame.
    connect
        Makes the solver.
    solver
        What identifies it.
    store
        Where frames are kept.
    settings
        What else they hold; spacing, quadrature and tolerance are chosen.
    until
        Last time code of the pilots.
    say
        Is told of every pilot.

    Returns
    -------
    Choice
        The choice.

    Raises
    ------
    RefusedError
        If the target is no length or no pilot can be solved.
    """
    if not target > 0.0:
        raise refused(ProblemCode.TARGET_ERROR_NOT_POSITIVE, "", f"{target:g}")
    spacing = PILOT * procedure.tissue.spacing
    pilots: list[_Pilot] = []
    reasons: list[Problem] = []
    while not pilots:
        for quadrature in QUADRATURES:
            chosen = SolverSettings(spacing=spacing, quadrature=quadrature, tolerance=TOLERANCE, correction=True)
            pilot = _pilot(procedure, chosen, target, connect, solver, store, until)
            if isinstance(pilot, Problem):
                reasons.append(pilot)
            else:
                pilots.append(pilot)
                say(
                    f"Pilot at {spacing:.3g} mm with {quadrature} point{'s' * (quadrature > 1)}: {pilot.error:.2g} mm; "
                    f"the target needs {pilot.needed:.3g} mm."
                )
        spacing /= 2.0
        if not pilots and spacing < procedure.tissue.spacing / 4.0:
            raise refused(ProblemCode.TARGET_ERROR_NO_PILOT, "", said=reasons[-1])
    best = min(pilots, key=lambda pilot: pilot.cost)
    tolerance = TOLERANCE
    if best.algebraic > ALGEBRAIC_SHARE * target:
        tolerance = max(TOLERANCE * ALGEBRAIC_SHARE * target / best.algebraic, MIN_TOLERANCE[settings.precision])
    quadrature = best.settings.quadrature
    return Choice(
        replace(settings, spacing=best.needed, quadrature=quadrature, tolerance=tolerance),
        best.error * (best.needed / best.settings.spacing) ** best.order,
        f"Chosen for an error of {target:g} mm: spacing {best.needed:.3g} mm, {quadrature} quadrature "
        f"point{'s' * (quadrature > 1)}, tolerance {tolerance:.1e}.",
    )


def finer(choice: Choice, reached: float, target: float, order: float) -> Choice:
    """Make the next choice after a solve that did not reach the target.

    Parameters
    ----------
    choice
        What was solved with.
    reached
        Root mean square error that was reached in mm.
    target
        Root mean square error that is wanted in mm.
    order
        Order of convergence.

    Returns
    -------
    Choice
        The finer choice.
    """
    spacing = _round(CAUTION * choice.settings.spacing * (target / reached) ** (1.0 / order))
    sentence = f"The estimate is {reached:.2g} mm, above {target:g} mm: once more with a spacing of {spacing:.3g} mm."
    return Choice(replace(choice.settings, spacing=spacing), target, sentence)


def _pilot(
    procedure: Procedure,
    settings: SolverSettings,
    target: float,
    connect: Connect,
    solver: str,
    store: FrameStore,
    until: float | None,
) -> _Pilot | Problem:
    """The pilot, or why there is none."""
    spacing = settings.spacing
    program = compile_program(procedure, settings=settings, until=until)
    solved = solve_program(program, store, connect, solver, SolveObserver())
    if solved.interrupted:
        raise KeyboardInterrupt
    if solved.reason is not None:
        return solved.reason
    errors = estimate_errors(program, solved.frames, store, connect, solver)
    error = worst_rms(errors)
    if error == float("inf"):
        return errors.reason or problem(ProblemCode.ESTIMATE_OF_NO_FRAME)
    algebraic = max((each.algebraic_rms or 0.0 for each in errors.frames if each is not None), default=0.0)
    order = expected_order(program, solved.frames[0].solved.lattice)
    needed = _round(CAUTION * spacing * (target / error) ** (1.0 / order)) if error > 0.0 else spacing
    needed = min(needed, 2.0 * spacing)
    seconds = sum(frame.solved.diagnostics.seconds.total for frame in solved.frames)
    return _Pilot(settings, needed, error, algebraic, order, seconds * (spacing / needed) ** COST_ORDER)


def _round(spacing: float) -> float:
    """To three significant digits, so that the choice can be typed."""
    return float(f"{spacing:.3g}")
