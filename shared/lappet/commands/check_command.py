"""`lappet check`: every problem of a procedure, each with its remedy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.parameters import FILE
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits

if TYPE_CHECKING:
    from lappet.core.problem import Problem


@click.command()
@click.argument("procedure", type=FILE)
@reading_options
@click.pass_context
def check(context: click.Context, /, procedure: Path, limits: ReadLimits) -> None:
    """Validate a procedure: every problem, each with its remedy."""
    with sentences(context):
        from lappet.program.full_check import full_check

        notes: list[Problem] = []
        problems = full_check(procedure, notes, limits)
        for note in notes:
            click.echo(f"{note.severity}: {note}")
        for problem in problems:
            click.echo(f"{problem.severity}: {problem}")
        errors = sum(problem.severity == "error" for problem in problems)
        if not problems:
            click.echo(f"{procedure}: no problem found.")
    if errors:
        context.exit(1)
