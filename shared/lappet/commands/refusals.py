"""How a command ends that is refused, stopped or broken: a sentence on standard error and exit status 1."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import click


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
    """
    try:
        yield
    except (click.ClickException, click.exceptions.Exit, click.Abort):
        raise
    except KeyboardInterrupt:
        click.echo("Stopped.", err=True)
        context.exit(1)
    except Exception as error:
        debug = bool(context.find_root().obj)
        if debug:
            raise
        click.echo(sentence(error), err=True)
        context.exit(1)


def sentence(error: Exception) -> str:
    """Tell what to say to the user about an error.

    Parameters
    ----------
    error
        The error.

    Returns
    -------
    str
        Its own sentence where it has one, else a request for a report.
    """
    own = type(error).__module__.partition(".")[0] == "lappet"
    if own and str(error):
        return str(error)
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename or 'A file'}: {error.strerror.lower()}; look at the path and its permissions."
    if isinstance(error, (OSError, ImportError)) and str(error):
        return str(error)
    said = f"{type(error).__name__}: {error}".splitlines()[0]
    return f"Lappet failed ({said}); run it as `lappet --debug ...` and report what it shows."
