"""What `lappet solve` does once its options are read: solves with a progress bar, writes the report, sums up."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lappet.core.value_with_error import with_error

MOST_ALIKE = 3  # warnings of a kind that the summary gives in full

if TYPE_CHECKING:
    from lappet.core.problem import Problem
    from lappet.output.solve_to_cache import SolveResult
    from lappet.procedure import Procedure
    from lappet.program.settings import SolverSettings
    from lappet.solve.error_estimate import ErrorEstimate
    from lappet.solve.measures import FrameMeasures
    from lappet.solve.seam_measures import SeamMeasure
    from lappet.usd.procedure_file import ProcedureFile


def run_solve(
    procedure: Path | Procedure | ProcedureFile,
    cache: Path,
    report_path: Path | None,
    settings: SolverSettings,
    **options: Any,
) -> SolveResult:
    """Solve with progress on standard error, and write the report.

    Parameters
    ----------
    procedure
        The procedure, its file, or its file that is being read.
    cache
        The skin cache.
    report_path
        File of the report, or None.
    settings
        How to solve.
    **options
        The other options of `solve_options`.

    Returns
    -------
    SolveResult
        What the solve gave.
    """
    from lappet.commands.solve_progress import solve_progress
    from lappet.output.solve_to_cache import solve_procedure
    from lappet.solve.store import FrameStore

    options["store"] = FrameStore(options["store"])
    with solve_progress() as observer:
        result = solve_procedure(procedure, cache, settings, observer=observer, **options)
    if report_path is not None:
        from lappet.output.report import write_report

        write_report(result, report_path)
    return result


def run_to_target(
    procedure: Procedure | ProcedureFile,
    cache: Path,
    report_path: Path | None,
    settings: SolverSettings,
    target: float,
    **options: Any,
) -> SolveResult:
    """Solve with the settings that a target error needs, and say which.

    Parameters
    ----------
    procedure
        The procedure, or its file that is being read.
    cache
        The skin cache.
    report_path
        File of the report, or None.
    settings
        How to solve, but for spacing, quadrature and tolerance.
    target
        Root mean square error in mm that must be reached.
    **options
        The other options of `solve_options`.

    Returns
    -------
    SolveResult
        What the last solve gave.

    Raises
    ------
    RefusedError
        If the target is not reached.
    """
    from lappet.core.problem import refused
    from lappet.core.problem_code import ProblemCode
    from lappet.daemon.daemon_solver import connect_to, solver_identity
    from lappet.solve.store import FrameStore
    from lappet.solve.target_error import TRIES, choose, finer, worst_rms
    from lappet.usd.procedure_file import ProcedureFile

    daemon = options["daemon"]
    choice = choose(
        procedure.procedure() if isinstance(procedure, ProcedureFile) else procedure,
        target,
        connect_to(daemon),
        solver_identity(daemon),
        FrameStore(options["store"]),
        settings,
        until=options["frames"][1],
        say=lambda line: click.echo(line, err=True),
    )
    for attempt in range(1, TRIES + 1):
        with contextlib.suppress(OSError):  # a full disk or a closed pipe is no reason to lose the solve
            click.echo(choice.sentence)
        result = run_solve(procedure, cache, report_path, choice.settings, **options)
        if not result.complete or result.errors is None or worst_rms(result.errors) <= target:
            return result
        if attempt < TRIES:
            choice = finer(choice, worst_rms(result.errors), target, result.errors.order)
    assert result.errors is not None
    reached, code = worst_rms(result.errors), ProblemCode.TARGET_ERROR_MISSED
    raise refused(code, cache, f"{target:g}", reached=reached, spacing=choice.settings.spacing)


def summary(result: SolveResult) -> str:
    """Sum up a solve in a line or three.

    Parameters
    ----------
    result
        What the solve gave.

    Returns
    -------
    str
        The text.
    """
    total = len(result.frames)
    return result_lines(
        f"{total} frame{'' if total == 1 else 's'} done: {result.solved} solved, {result.looked_up} looked up, "
        f"{result.wall_seconds:.1f} s.",
        result,
    )


def result_lines(first: str, result: SolveResult) -> str:
    """Say what was found, and where it is; why there is no more is said on standard error.

    Parameters
    ----------
    first
        The first line.
    result
        What was found.

    Returns
    -------
    str
        The text.
    """
    lines = [first]
    if result.errors is not None:
        lines += error_lines(result.errors)
    lines += force_lines(result.measures)
    lines += seam_lines(result.seams)
    lines += told_lines(result.notes)
    if result.output is not None:
        lines.append(f"Skin cache: {result.output.resolve()}")
    if result.reason is not None:
        click.echo(str(result.reason), err=True)
    return "\n".join(lines)


def write_tables(
    result: SolveResult,
    *,
    sutures: Path | None = None,
    hooks: Path | None = None,
    seams: Path | None = None,
    reactions: Path | None = None,
    sections: Path | None = None,
) -> None:
    """Write the tables of a solve that are asked for as CSV.

    Parameters
    ----------
    result
        What the solve gave.
    sutures
        File for the force on each suture.
    hooks
        File for the force of each hook.
    seams
        File for what is measured at each seam.
    reactions
        File for the force of whatever holds or loads the tissue.
    sections
        File for the force across each section.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    from lappet.output.tables import write_table
    from lappet.solve.hook_forces import HookForce
    from lappet.solve.reactions import Reaction
    from lappet.solve.seam_measures import SeamMeasure
    from lappet.solve.section_tension import SectionTension
    from lappet.solve.suture_forces import SutureForce

    for path, kind, rows in (
        (sutures, SutureForce, result.suture_forces),
        (hooks, HookForce, result.hook_forces),
        (seams, SeamMeasure, result.seams),
        (reactions, Reaction, result.reactions),
        (sections, SectionTension, result.sections),
    ):
        if path is not None:
            write_table(path, kind, rows)


def force_lines(measures: Sequence[FrameMeasures]) -> list[str]:
    """Say what sutures and hooks pull in the last frame, each with its estimated error.

    Parameters
    ----------
    measures
        What is measured at each frame.

    Returns
    -------
    list[str]
        Lines of text; none where nothing pulls.
    """
    lines = []
    last = measures[-1] if measures else None
    sums = None if last is None else last.sums
    if sums is not None and sums.greatest_suture is not None:
        total, most = with_error(sums.total_mn, sums.total_error_mn), sums.greatest_suture
        line = f"Sutures: {total} mN in all, {with_error(sums.greatest_mn, sums.greatest_error_mn)} mN at most ({most})"
        if sums.unresolved:
            line += f"; without {', '.join(sums.unresolved)}, which the lattice does not resolve"
        lines.append(f"{line}, in the last frame.")
    hooks = [] if last is None else sorted(last.hooks, key=lambda row: -row.force_mn)
    if hooks:
        pulls = [f"{row.hook} {with_error(row.force_mn, row.force_error_mn)} mN" for row in hooks[:MOST_ALIKE]]
        more = f" and {len(hooks) - MOST_ALIKE} more" if len(hooks) > MOST_ALIKE else ""
        lines.append(f"Hooks: {', '.join(pulls)}{more}, in the last frame.")
    return lines


def seam_lines(seams: Sequence[SeamMeasure]) -> list[str]:
    """Say what is measured at the seams in their last frame, each value with its estimated error.

    Parameters
    ----------
    seams
        The measures of all frames.

    Returns
    -------
    list[str]
        A line of text, or none where nothing is sewn.
    """
    if not seams or all(row.tension_n_per_mm is None for row in seams):
        return []
    last = [row for row in seams if row.time == seams[-1].time]
    scar = sum(row.scar_length_mm for row in last)
    parts = [
        f"Scar: {with_error(scar, _sum(row.scar_length_error_mm for row in last))} mm",
        f"{with_error(sum(row.open_area_mm2 for row in last), _sum(row.open_area_error_mm2 for row in last))} mm² "
        "still open",
    ]
    steps = [(row.step_off_mm, row.step_off_error_mm) for row in last if row.step_off_mm is not None]
    ears = [
        (ear, error)
        for row in last
        for ear, error in (
            (row.start_dog_ear_mm, row.start_dog_ear_error_mm),
            (row.end_dog_ear_mm, row.end_dog_ear_error_mm),
        )
        if ear is not None
    ]
    for name, values in (("step-off", steps), ("dog-ear", ears)):
        parts += [f"{name} {with_error(*max(values, key=lambda pair: pair[0]))} mm"] if values else []
    drawn = [row for row in last if row.tension_n_per_mm is not None]
    pull = sum((row.tension_n_per_mm or 0.0) * row.scar_length_mm for row in drawn) / scar
    errors = (_times(row.tension_error_n_per_mm, row.scar_length_mm / scar) for row in drawn)
    mean = with_error(pull, _sum(errors))
    return [", ".join(parts) + f" at most, closing tension {mean} N/mm in the mean, in the last frame."]


def _sum(errors: Iterable[float | None]) -> float | None:
    """The sum of errors; None where one is not known."""
    known = list(errors)
    return None if any(each is None for each in known) else sum(each for each in known if each is not None)


def _times(error: float | None, share: float) -> float | None:
    return None if error is None else error * share


def told_lines(notes: Sequence[Problem]) -> list[str]:
    """Say what is suspicious or not to be trusted, a line each, and in one line what was done otherwise than told.

    Parameters
    ----------
    notes
        Warnings and notes of a solve.

    Returns
    -------
    list[str]
        Lines of text.
    """
    warnings = [each for each in notes if each.severity == "warning"]
    lines = []
    for code in dict.fromkeys(each.code for each in warnings):
        alike = [each for each in warnings if each.code == code]
        lines += [f"warning: {each}" for each in alike[:MOST_ALIKE]]
        if len(alike) > MOST_ALIKE:
            lines.append(
                f"warning: {len(alike) - MOST_ALIKE} more of the kind {code}; lappet check and the report name all."
            )
    told = [f"{each.prim}: {each.message}" if each.prim else each.message for each in notes if each.severity == "note"]
    if told:
        lines.append("Besides: " + " ".join(told))
    return lines


def error_lines(errors: ErrorEstimate) -> list[str]:
    """Say what the estimate of a solve says, for people.

    Parameters
    ----------
    errors
        The estimate.

    Returns
    -------
    list[str]
        Lines of text.
    """
    lines = []
    known = [error for error in errors.frames if error is not None]
    if known:
        worst = max(error.greatest for error in known)
        last = known[-1]
        lines.append(
            f"Estimated displacement error: {last.greatest:.2g} mm at most and {last.rms:.2g} mm root mean square over "
            f"the skin in the last frame, {worst:.2g} mm at most in all; {errors.seconds:.1f} s for the estimate."
        )
    if errors.reason is not None:
        lines.append(f"Without a discretization error from some frame on. {errors.reason}")
    return lines
