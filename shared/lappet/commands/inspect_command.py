"""`lappet inspect`: storyboard, epochs, scene profile and lattice counts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.daemon_options import daemon_options
from lappet.commands.parameters import FILE
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits

if TYPE_CHECKING:
    from lappet.daemon.running_daemon import RunningDaemon


@click.command()
@click.argument("procedure", type=FILE)
@click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm.")
@click.option("--no-lattice", is_flag=True, help="Leave out the lattice counts (they need the daemon).")
@daemon_options
@click.option(
    "--economy", type=FILE, metavar="FILE", help="Add the costs from this economy.json of `lappet report economy`."
)
@reading_options
@click.pass_context
def inspect(
    context: click.Context,
    /,
    procedure: Path,
    spacing: float | None,
    no_lattice: bool,
    daemon: RunningDaemon | None,
    economy: Path | None,
    limits: ReadLimits,
) -> None:
    """Print a procedure's storyboard, epochs, scene profile and lattice counts."""
    with sentences(context):
        from lappet.core.printable import printable
        from lappet.output.inspect_procedure import inspect_procedure

        told = inspect_procedure(
            procedure, spacing=spacing, lattice=not no_lattice, daemon=daemon, economy=economy, limits=limits
        )
        click.echo(printable(told))
