"""`lappet keys`: who may use a daemon: new keys, users who are let in and shut out."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.parameters import FILE
from lappet.commands.refusals import sentences

if TYPE_CHECKING:
    from lappet.daemon.keys_folder import User

_FOLDER = click.option("--keys", "folder", type=FILE, required=True, metavar="DIR", help="The daemon's folder of keys.")


@click.group()
def keys() -> None:
    """Make keys, and say who may use a daemon."""


@keys.command()
@click.argument("name", required=False)
@click.option("--server", is_flag=True, help="Make the keys of a daemon, for lappet-solverd --keys DIR.")
@click.option("--keys", "folder", type=FILE, metavar="DIR", help="Folder for them.  [default: the user's own]")
@click.pass_context
def new(context: click.Context, /, name: str | None, server: bool, folder: Path | None) -> None:
    """Make the key pair of NAME, or of a daemon."""
    if server and folder is None:
        raise click.UsageError("--server needs a folder of its own for the daemon; give --keys DIR.")
    if not server and name is None:
        raise click.UsageError("The keys need a name; give yours, like anna, or --server for those of a daemon.")
    with sentences(context):
        from lappet.daemon.key_writing import default_folder, new_own

        if server:
            assert folder is not None
            _new_server(folder, name)
            return
        assert name is not None
        secret, public, pair = new_own(folder or default_folder(), name)
        click.echo(f"Your secret key: {secret.resolve()} (give it to nobody)")
        click.echo(f"Your public key: {public.resolve()} (send it to whoever runs the daemon)")
        click.echo(f"or in 40 characters: {pair.public}")


def _new_server(folder: Path, name: str | None) -> None:
    from lappet.daemon.key_files import require_name
    from lappet.daemon.keys_folder import KeysFolder
    from lappet.daemon.process import BINARY, DaemonMissing, find_daemon

    if name is not None:
        require_name(name)
    made = KeysFolder(folder)
    pair = made.make_server(name or "a Lappet daemon")
    try:
        program = str(find_daemon())
    except DaemonMissing:
        program = BINARY
    click.echo(f"The daemon's secret key: {made.server_key.resolve()} (give it to nobody)")
    click.echo(f"The daemon's public key: {made.server_public.resolve()} (send it to every user)")
    click.echo(f"or in 40 characters: {pair.public}")
    command = [program, "--listen", "tcp://0.0.0.0:5570", "--keys", str(folder.resolve())]
    click.echo(f"Start it with: {shlex.join(command)}")


@keys.command()
@click.argument("name")
@click.option("--key", required=True, metavar="KEY|FILE", help="Their public key, or the file that holds it.")
@click.option(
    "--role",
    type=click.Choice(["follower", "author", "admin"]),
    required=True,
    help="What they may do: follow, also solve, or also end the daemon.",
)
@click.option("--memory-gib", type=float, metavar="GIB", help="Memory of a session, 0.01 to 65536.")
@click.option("--threads", type=int, metavar="N", help="Threads of a session, 1 to 1024.")
@click.option("--sessions", type=int, metavar="N", help="Sessions at a time, 0 to 1024.")
@click.option("--seconds", type=float, metavar="S", help="Seconds of one frame or epoch, 0.01 to 1000000.")
@_FOLDER
@click.pass_context
def allow(
    context: click.Context,
    /,
    name: str,
    key: str,
    role: str,
    folder: Path,
    memory_gib: float | None,
    threads: int | None,
    sessions: int | None,
    seconds: float | None,
) -> None:
    """Let the user NAME use a daemon.

    For one who is known it changes what they may do. The daemon need not be started anew.
    """
    with sentences(context):
        from lappet.daemon.key_files import read_public
        from lappet.daemon.keys_folder import KeysFolder, Quotas, Role, User

        user = User(name, read_public(key), Role(role), Quotas(memory_gib, threads, sessions, seconds))
        before = KeysFolder(folder).allow(user)
        click.echo(
            f"{name} may use the daemon as {_said(user)}{'' if before is None else f', before as {_said(before)}'}."
        )


@keys.command()
@click.argument("name")
@_FOLDER
@click.pass_context
def revoke(context: click.Context, /, name: str, folder: Path) -> None:
    """Shut the user NAME out of a daemon.

    It refuses their next message, and need not be started anew.
    """
    with sentences(context):
        from lappet.daemon.keys_folder import KeysFolder

        KeysFolder(folder).revoke(name)
        click.echo(f"{name} may no longer use the daemon.")


@keys.command("list")
@_FOLDER
@click.pass_context
def list_users(context: click.Context, /, folder: Path) -> None:
    """List who may use a daemon, and its public key."""
    with sentences(context):
        from lappet.daemon.keys_folder import KeysFolder

        read = KeysFolder(folder)
        click.echo(f"The daemon's public key: {read.server()}")
        users, wrong = read.users()
        width = max((len(user.name) for user in users), default=0)
        for user in users:
            click.echo(f"{user.name:{width}}  {user.public}  {_said(user)}")
        if not users and not wrong:
            click.echo("Nobody may use it yet.")
        for each in wrong:
            click.echo(str(each), err=True)
    if wrong:
        context.exit(1)


def _said(user: User) -> str:
    quotas = {
        "memory_gib": "{:g} GiB a session",
        "threads": "{} threads a session",
        "sessions": "{} sessions",
        "seconds": "{:g} s a frame",
    }
    values = {name: getattr(user.quotas, name) for name in quotas}
    return ", ".join([user.role, *(quotas[name].format(value) for name, value in values.items() if value is not None)])
