"""The options that every command that solves has: those of the solver's settings, and of the solve itself."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import Field, replace
from typing import Any

import click

from lappet.commands.daemon_options import daemon_options
from lappet.commands.parameters import FILE
from lappet.program.settings import Option, SolverSettings, options


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
    added: list[Callable[[Callable[..., Any]], Callable[..., Any]]] = [
        setting_options,
        click.option(
            "--store", type=FILE, help="Folder for solved frames.  [default: LAPPET_STORE or the user's cache]"
        ),
        daemon_options,
        click.option(
            "--error-estimate/--no-error-estimate",
            default=True,
            show_default=True,
            help="Estimate the displacement error with a coarser solve.",
        ),
    ]
    for option in reversed(added):
        command = option(command)
    return command


def setting_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of the solver's settings, which the command takes as one `SolverSettings`.

    Parameters
    ----------
    command
        The command's function, with a parameter `settings`.

    Returns
    -------
    Callable[..., Any]
        The function with the options.
    """

    @functools.wraps(command)
    def with_settings(*arguments: Any, **given: Any) -> Any:
        chosen = {
            item.name: _setting(item, option, value)
            for item, option in options()
            if (value := given.pop(item.name)) is not None
        }
        settings = SolverSettings(**chosen)
        if settings.friction and settings.self_contact is None:
            settings = replace(settings, self_contact=True)
        if settings.friction and not settings.self_contact:
            raise click.UsageError("--friction acts where tissue presses on tissue; leave --no-self-contact out.")
        return command(*arguments, settings=settings, **given)

    for item, option in reversed(list(options())):
        with_settings = _setting_option(item, option)(with_settings)
    return with_settings


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


def _setting_option(item: Field[Any], option: Option) -> Callable[..., Any]:
    """Return a setting's option as click has it."""
    name, default = "--" + item.name.replace("_", "-"), item.default
    if option.value is not None:
        return click.option(option.flags or name, item.name, is_flag=True, help=option.help)
    if default is None or isinstance(default, bool):
        flags = option.flags or f"{name}/--no-{item.name.replace('_', '-')}"
        return click.option(flags, item.name, default=default, show_default=default is not None, help=option.help)
    if option.choices:
        kind: click.ParamType = click.Choice([str(each) for each in option.choices])
        default = str(default)
    else:
        ends = {"min": option.least if option.above is None else option.above, "max": option.below}
        open_ends = {"min_open": option.above is not None, "max_open": option.below is not None}
        kind = (click.IntRange if isinstance(default, int) else click.FloatRange)(**ends, **open_ends)  # type: ignore[arg-type]
    shown = default if option.shown else None
    return click.option(
        option.flags or name, item.name, type=kind, default=shown, show_default=option.shown, help=option.help
    )


def _setting(item: Field[Any], option: Option, value: Any) -> Any:
    """Return the value of a setting whose option has this one."""
    if option.value is not None:
        return option.value if value else item.default
    kind: Any = bool if item.default is None else type(item.default)
    return kind(value)
