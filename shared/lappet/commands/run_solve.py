"""What `lappet solve` does once its options are read: solves with a progress bar, writes the report, sums up."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

MOST_ALIKE = 3  # warnings of a kind that the summary gives in full

if TYPE_CHECKING:
    from lappet.core.problem import Problem
    from lappet.output.solve_to_cache import SolveResult
    from lappet.program.settings import SolverSettings
    from lappet.solve.error_estimate import ErrorEstimate
    from lappet.solve.seam_measures import SeamMeasure


def run_solve(
    procedure: Path, cache: Path, report_path: Path | None, settings: SolverSettings, **options: Any
) -> SolveResult:
    """Solve with progress on standard error, and write the report.

    Parameters
    ----------
    procedure
        The procedure's file.
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
    procedure: Path, cache: Path, report_path: Path | None, settings: SolverSettings, target: float, **options: Any
) -> SolveResult:
    """Solve with the settings that a target error needs, and say which.

    Parameters
    ----------
    procedure
        The procedure's file.
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
    from lappet.usd.stage import read_procedure

    daemon = options["daemon"]
    choice = choose(
        read_procedure(procedure),
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
    lines = []
    total = len(result.frames)
    lines.append(
        f"{total} frame{'' if total == 1 else 's'} done: {result.solved} solved, {result.looked_up} looked up, "
        f"{result.wall_seconds:.1f} s."
    )
    if result.errors is not None:
        lines += error_lines(result.errors)
    lines += seam_lines(result.seams)
    lines += told_lines(result.notes)
    if result.output is not None:
        lines.append(f"Skin cache: {result.output.resolve()}")
    if result.reason is not None:
        click.echo(str(result.reason), err=True)
    return "\n".join(lines)


def write_tables(
    result: SolveResult, *, sutures: Path | None = None, hooks: Path | None = None, seams: Path | None = None
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

    Raises
    ------
    OSError
        If the file system refuses.
    """
    from lappet.output.tables import write_table
    from lappet.solve.hook_forces import HookForce
    from lappet.solve.seam_measures import SeamMeasure
    from lappet.solve.suture_forces import SutureForce

    for path, kind, rows in (
        (sutures, SutureForce, result.suture_forces),
        (hooks, HookForce, result.hook_forces),
        (seams, SeamMeasure, result.seams),
    ):
        if path is not None:
            write_table(path, kind, rows)


def seam_lines(seams: Sequence[SeamMeasure]) -> list[str]:
    """Say what is measured at the seams in their last frame.

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
    scar, area = sum(row.scar_length_mm for row in last), sum(row.open_area_mm2 for row in last)
    parts = [f"Scar: {scar:.0f} mm, {area:.1f} mm² still open"]
    steps = [row.step_off_mm for row in last if row.step_off_mm is not None]
    ears = [ear for row in last for ear in (row.start_dog_ear_mm, row.end_dog_ear_mm) if ear is not None]
    pull = sum(row.tension_n_per_mm * row.scar_length_mm for row in last if row.tension_n_per_mm is not None)
    parts += [f"step-off {max(steps):.1f} mm"] if steps else []
    parts += [f"dog-ear {max(ears):.1f} mm"] if ears else []
    return [", ".join(parts) + f" at most, closing tension {pull / scar:.2g} N/mm in the mean, in the last frame."]


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
