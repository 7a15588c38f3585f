"""`lappet doctor`: what is installed, what is missing, and how to get it."""

from __future__ import annotations

import json
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from lappet.commands.refusals import sentences

if TYPE_CHECKING:
    from lappet.installation.finding import Finding

_WIDTH = 16  # characters of a finding's name


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
@click.pass_context
def doctor(context: click.Context, /, as_json: bool) -> None:
    """Say what is installed and what is missing, and solve something small.

    The exit status is 1 if something is broken that Lappet needs; an extra that is missing is no fault.
    """
    with sentences(context):
        from lappet.core.machine import machine
        from lappet.core.version import version
        from lappet.installation.packages import check_packages
        from lappet.installation.places import check_places
        from lappet.installation.solver import check_solver

        here, found = machine(), [*check_packages(), *check_places(), *check_solver()]
        if as_json:
            told = {"lappet": version(), "machine": here, "findings": [asdict(each) for each in found]}
            click.echo(json.dumps(told, indent=1))
        else:
            memory = here["memory_bytes"]
            size = "" if memory is None else f", {memory / 2**30:.0f} GiB"
            click.echo(
                f"Lappet {version()} with Python {here['python']} on {here['system']}, {here['cores']} cores{size}"
            )
            for each in found:
                _print(each)
    if any(each.state == "broken" for each in found):
        context.exit(1)


def _print(finding: Finding) -> None:
    color = {"ok": "green", "missing": "yellow", "broken": "red"}[finding.state]
    head = click.style(f"{finding.state:8}", fg=color) + f"{finding.name:{_WIDTH}}"
    indent = " " * (8 + _WIDTH)
    lines = textwrap.wrap(finding.value, 100 - len(indent), break_long_words=False, break_on_hyphens=False) or [""]
    click.echo(head + f"\n{indent}".join(lines))
    if finding.remedy:
        click.echo(f"{indent}-> {finding.remedy}")
