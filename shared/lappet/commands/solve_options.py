"""The options that every command that solves has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from lappet.commands.parameters import FILE


def solve_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that every command that solves has.

    Parameters
    ----------
    command
        The command's function.

    Returns
    -------
    Callable[..., Any]
        The function with the options.
    """
    options = [
        click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm."),
        click.option(
            "--tolerance",
            type=click.FloatRange(min=0, max=1, min_open=True, max_open=True),
            default=1e-3,
            show_default=True,
            help="Residual over the scene's force scale.",
        ),
        click.option(
            "--quadrature", type=click.Choice(["1", "4", "8"]), default="1", show_default=True, help="Points per cell."
        ),
        click.option(
            "--precision",
            type=click.Choice(["float", "double"]),
            default="float",
            show_default=True,
            help="Arithmetic.",
        ),
        click.option(
            "--store", type=FILE, help="Folder for solved frames.  [default: LAPPET_STORE or the user's cache]"
        ),
        click.option("--daemon", metavar="ADDR", help="Address of a running daemon, like tcp://127.0.0.1:5555."),
        click.option(
            "--error-estimate/--no-error-estimate",
            default=True,
            show_default=True,
            help="Estimate the displacement error with a coarser solve.",
        ),
        click.option(
            "--strain/--no-strain",
            default=True,
            show_default=True,
            help="Compute strain, stress and tension on the surface.",
        ),
        click.option(
            "--whole", is_flag=True, help="Solve every frame everywhere, also where its changes do not reach."
        ),
    ]
    for option in reversed(options):
        command = option(command)
    return command


def is_given(context: click.Context, name: str) -> bool:
    """Tell whether the user gave an option.

    Parameters
    ----------
    context
        The command's context.
    name
        Name of the parameter.

    Returns
    -------
    bool
        Whether it was on the command line or in the environment.
    """
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"
