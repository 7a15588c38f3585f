"""The command `lappet`: thin, each subcommand loads what it needs when it runs.

Exit status: 0 done, 1 refused or not converged, 2 usage.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import click

from lappet.commands.check_command import check
from lappet.commands.compare_command import compare
from lappet.commands.completion_command import VARIABLE, add_shells, completion
from lappet.commands.demo_command import demo
from lappet.commands.doctor_command import doctor
from lappet.commands.export_command import export
from lappet.commands.film_command import film
from lappet.commands.flap_command import flap
from lappet.commands.follow_command import follow
from lappet.commands.inspect_command import inspect
from lappet.commands.keys_command import keys
from lappet.commands.lesson_command import lesson
from lappet.commands.models_command import models
from lappet.commands.new_command import new
from lappet.commands.plate_command import plate
from lappet.commands.render_command import render
from lappet.commands.report_command import report
from lappet.commands.solve_command import solve


class _Version(click.Option):
    """`--version`, which looks the version up only when it is asked for."""

    def __init__(self, *declarations: Any, **attributes: Any) -> None:
        attributes.update(is_flag=True, expose_value=False, is_eager=True, help="Show the version and exit.")
        super().__init__(*declarations, callback=self._show, **attributes)

    @staticmethod
    def _show(context: click.Context, _: click.Parameter, value: bool) -> None:
        if value and not context.resilient_parsing:
            from lappet.core.version import version

            click.echo(f"lappet {version()}")
            context.exit()


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option("--version", cls=_Version)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def cli(context: click.Context, debug: bool) -> None:
    """Plan a skin-flap operation, solve how the tissue moves, and render figures of it."""
    context.obj = debug


def main() -> None:
    """Run the console script."""
    if VARIABLE in os.environ:
        add_shells()
    try:
        cli.main(prog_name="lappet")
    except OSError as error:  # of standard output, where no command stands between: help, a script for completion
        from lappet.commands.refusals import problems_of

        for each in problems_of(error):
            click.echo(str(each), err=True)
        sys.exit(1)


_MAKING = (solve, follow, demo, check, inspect, render, plate, film, export, lesson, compare, new, models, flap, report)
for _command in (*_MAKING, keys, doctor, completion):
    cli.add_command(_command)
