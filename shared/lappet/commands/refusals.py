"""How a command ends that is refused, stopped or broken: a sentence on standard error and exit status 1."""

from __future__ import annotations

import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click

from lappet.core.problem import Problem, ProblemsError, file_problem, problem
from lappet.core.problem_code import ProblemCode


@contextmanager
def sentences(context: click.Context) -> Iterator[None]:
    """End the command with exit status 1 and a sentence on standard error where work is refused or stopped.

    Parameters
    ----------
    context
        The command's context.

    Yields
    ------
    None
        Nothing.

    Raises
    ------
    ClickException
        If the command raises one of click's own; click shows it.
    Exit
        If the command ends itself.
    Abort
        If the user aborts at a prompt.
    BrokenPipeError
        If the reader of standard output has left, as `head` does; click ends the command without a word.
    """
    try:
        yield
    except (click.ClickException, click.exceptions.Exit, click.Abort):
        raise
    except KeyboardInterrupt:
        click.echo("Stopped.", err=True)
        context.exit(1)
    except Exception as error:
        if isinstance(error, BrokenPipeError) and _reader_left():
            raise
        debug = bool(context.find_root().obj)
        if debug:
            raise
        for each in problems_of(error):
            click.echo(str(each), err=True)
        context.exit(1)


def _reader_left() -> bool:
    """Whether nobody reads standard output any more, as a pipe's poll tells."""
    try:
        watched = select.poll()
        watched.register(sys.stdout.fileno(), 0)
        return any(events & select.POLLERR for _, events in watched.poll(0))
    except (AttributeError, OSError, ValueError):  # Windows has no poll; a test's output has no file
        return False


def problems_of(error: Exception) -> tuple[Problem, ...]:
    """Find what to tell the user about an error.

    Parameters
    ----------
    error
        The error.

    Returns
    -------
    tuple[Problem, ...]
        Its own problems, else what the system says, else that Lappet is at fault.
    """
    if isinstance(error, ProblemsError):
        return error.problems
    if isinstance(error, OSError):
        return (file_problem(error),)
    said = f"{type(error).__name__}: {error}".splitlines()[0]
    return (problem(ProblemCode.INTERNAL, "", said),)
