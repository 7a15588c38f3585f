"""The options that every command that reads files has: what reading may take, and whether it leaves the folder."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits

_GIB, _MIB = 1 << 30, 1 << 20


def reading_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of `ReadLimits` to a command, which gets them as `limits`.

    Parameters
    ----------
    command
        The command's function.

    Returns
    -------
    Callable[..., Any]
        The function with the options.
    """

    @functools.wraps(command)
    def with_limits(
        *arguments: Any, read_memory: float, read_seconds: int, read_size: float, allow_external: bool, **given: Any
    ) -> Any:
        limits = ReadLimits(round(read_memory * _GIB), read_seconds, round(read_size * _MIB), allow_external)
        return command(*arguments, limits=limits, **given)

    added = [
        click.option(
            "--allow-external", is_flag=True, help="Follow references to files outside the folder of the file read."
        ),
        click.option(
            "--read-memory",
            type=click.FloatRange(min=0.5, max=1 << 20),
            default=DEFAULT_LIMITS.memory / _GIB,
            show_default=True,
            metavar="GIB",
            help="Memory that reading a file may take.",
        ),
        click.option(
            "--read-seconds",
            type=click.IntRange(min=1, max=1 << 20),
            default=DEFAULT_LIMITS.seconds,
            show_default=True,
            metavar="S",
            help="Seconds of a processor that reading a file may take.",
        ),
        click.option(
            "--read-size",
            type=click.FloatRange(min=1, max=1 << 30),
            default=DEFAULT_LIMITS.size / _MIB,
            show_default=True,
            metavar="MIB",
            help="Size that a file, and what is read of it, may have.",
        ),
    ]
    for option in reversed(added):
        with_limits = option(with_limits)
    return with_limits
