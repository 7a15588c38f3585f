"""The options that name a running daemon and the keys it is reached with."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click


def daemon_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--daemon`, `--server-key` and `--key`, which the command takes as one `RunningDaemon`.

    Parameters
    ----------
    command
        The command's function, with a parameter `daemon`.

    Returns
    -------
    Callable[..., Any]
        The function with the options.
    """

    @functools.wraps(command)
    def with_daemon(*arguments: Any, daemon: str | None, server_key: str | None, key: str | None, **given: Any) -> Any:
        if daemon is None:
            for option, value in (("--server-key", server_key), ("--key", key)):
                if value is not None:
                    raise click.UsageError(f"{option} is of no use without --daemon; give its address too.")
            return command(*arguments, daemon=None, **given)
        from lappet.daemon.running_daemon import RunningDaemon

        return command(*arguments, daemon=RunningDaemon(daemon, server_key or "", key or ""), **given)

    added = [
        click.option("--daemon", metavar="ADDR", help="Address of a running daemon, like tcp://127.0.0.1:5555."),
        click.option("--server-key", metavar="KEY|FILE", help="That daemon's public key, or the file that holds it."),
        click.option("--key", metavar="FILE", help="Your own key for that daemon (lappet keys new)."),
    ]
    for option in reversed(added):
        with_daemon = option(with_daemon)
    return with_daemon
