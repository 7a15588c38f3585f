"""`lappet follow`: see the frames that somebody else solves, and write their skin cache."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.daemon_options import daemon_options
from lappet.commands.parameters import FILE
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.commands.solve_options import setting_options
from lappet.foreign.limits import ReadLimits
from lappet.program.settings import SolverSettings
from lappet.usd.procedure_file import ProcedureFile

if TYPE_CHECKING:
    from lappet.daemon.running_daemon import RunningDaemon


@click.command()
@click.argument("procedure", type=FILE)
@click.argument("session", type=click.IntRange(min=1))
@click.option(
    "-o", "--output", type=FILE, help="The skin cache (.usdc, .usda or .usd).  [default: PROCEDURE.cache.usdc]"
)
@daemon_options
@setting_options
@reading_options
@click.pass_context
def follow(
    context: click.Context,
    /,
    procedure: Path,
    session: int,
    output: Path | None,
    daemon: RunningDaemon | None,
    settings: SolverSettings,
    limits: ReadLimits,
) -> None:
    """Follow what somebody else solves and write its skin cache.

    SESSION is the number that `lappet solve --share` says. PROCEDURE and the options of the solver are those of its
    author.
    """
    if daemon is None:
        raise click.UsageError("There is nothing to follow without --daemon; give the address of the author's daemon.")
    with sentences(context):
        reading = context.with_resource(ProcedureFile(procedure, limits))  # it runs while the rest is loaded
        from lappet.commands.run_solve import result_lines
        from lappet.commands.solve_progress import solve_progress
        from lappet.output.follow_to_cache import follow_procedure

        cache = output or procedure.with_suffix(".cache.usdc")
        with solve_progress() as observer:
            result = follow_procedure(reading, cache, daemon, session, settings, observer=observer)
        total = len(result.frames)
        followed = f"{total} frame{'' if total == 1 else 's'} followed, {result.wall_seconds:.1f} s."
        click.echo(result_lines(followed, result))
    if not result.complete:
        context.exit(1)
