"""The folder that says who may use a daemon (`lappet-solverd --keys`): its own key pair, and a file for each user.

    server.key       0600  public, secret
    server.pub       0644  public: what users are given, and their clients pin
    users/NAME.pub   0644  public, role, and quotas

The daemon reads `users` again at each handshake, so nobody has to start it anew (PROTOCOL.md, "Keys").
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import Any

from lappet.core.durable import sync_folder
from lappet.core.problem import Problem, RefusedError, file_problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.key_files import KeyPair, key_in, new_pair, read_entries, read_pair, require_name
from lappet.daemon.key_writing import OPEN, pair_text, private_folder, public_text, write_new, write_over, write_pair

_ENDING = ".pub"


class Role(StrEnum):
    """What a user may do; each may what those before it may."""

    FOLLOWER = "follower"
    AUTHOR = "author"
    ADMIN = "admin"


@dataclass(frozen=True)
class Quotas:
    """What a user may take of a daemon; None: what the daemon's own options say.

    Parameters
    ----------
    memory_gib
        Memory of a session in GiB.
    threads
        Threads of a session.
    sessions
        Sessions at a time.
    seconds
        Seconds of one frame or epoch.
    """

    memory_gib: float | None = None
    threads: int | None = None
    sessions: int | None = None
    seconds: float | None = None


QUOTA_RANGES: Mapping[str, tuple[float, float]] = {
    "memory_gib": (0.01, 65536.0),
    "threads": (1, 1024),
    "sessions": (0, 1024),
    "seconds": (0.01, 1e6),
}
"""Least and greatest value of each quota, as the daemon takes it."""
_WHOLE = ("threads", "sessions")


@dataclass(frozen=True)
class User:
    """Somebody who may use a daemon.

    Parameters
    ----------
    name
        What the daemon calls them.
    public
        Their public key, Z85.
    role
        What they may do.
    quotas
        What they may take.
    """

    name: str
    public: str
    role: Role
    quotas: Quotas = Quotas()


class KeysFolder:
    """The keys of a daemon.

    Parameters
    ----------
    path
        The folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.server_key = path / "server.key"
        self.server_public = path / "server.pub"
        self.users_path = path / "users"

    def make_server(self, remark: str = "a Lappet daemon") -> KeyPair:
        """Make the daemon's key pair, and the folder where there is none.

        Parameters
        ----------
        remark
            What the daemon is called in the files.

        Returns
        -------
        KeyPair
            The pair.

        Raises
        ------
        RefusedError
            If the folder is open to others, or there is a pair.
        OSError
            If the file system refuses.
        """
        private_folder(self.path)
        private_folder(self.users_path)
        pair = new_pair()
        text = pair_text(pair, f"The key of {remark}. Nobody else may read it.")
        told = public_text(pair.public, f"The public key of {remark}: for its users.")
        write_pair(self.server_key, text, self.server_public, told)
        return pair

    def server(self) -> str:
        """Read the daemon's public key.

        Returns
        -------
        str
            The key, Z85.

        Raises
        ------
        RefusedError
            If there is none, or its file is damaged.
        """
        self._require()
        return read_pair(self.server_key, links=False).public

    def users(self) -> tuple[list[User], list[Problem]]:
        """Read who may use the daemon.

        Returns
        -------
        tuple[list[User], list[Problem]]
            The users by name, and what is wrong with the files of others, whom the daemon does not know.

        Raises
        ------
        RefusedError
            If the folder has no keys of a daemon, or others may enter it.
        """
        self._require()
        found: list[User] = []
        wrong: list[Problem] = []
        for path in sorted(self.users_path.glob(f"*{_ENDING}")):
            if path.name.startswith("."):
                continue
            try:
                found.append(_read_user(path))
            except RefusedError as error:
                wrong += error.problems
            except OSError as error:
                wrong.append(file_problem(error, path))
        return found, wrong

    def allow(self, user: User) -> User | None:
        """Let somebody use the daemon, or change what they may do.

        Parameters
        ----------
        user
            The user.

        Returns
        -------
        User | None
            What they were before; None for a new user.

        Raises
        ------
        RefusedError
            If the name or a quota is none, or the name has another key, or the key another name.
        OSError
            If the file system refuses.
        """
        require_name(user.name)
        _require_quotas(user.quotas)
        known = {each.name: each for each in self.users()[0]}
        before = known.get(user.name)
        path = self.users_path / f"{user.name}{_ENDING}"
        if before is not None and before.public != user.public:
            raise refused(ProblemCode.USER_HAS_KEY, path, user.name)
        for other in known.values():
            if other.public == user.public and other.name != user.name:
                raise refused(ProblemCode.KEY_OF_ANOTHER, path, other.name)
        (write_new if before is None else write_over)(path, _user_text(user), OPEN)
        return before

    def revoke(self, name: str) -> None:
        """Let somebody no longer use the daemon.

        Parameters
        ----------
        name
            The user's name.

        Raises
        ------
        RefusedError
            If nobody has that name.
        OSError
            If the file system refuses.
        """
        self._require()
        require_name(name)
        path = self.users_path / f"{name}{_ENDING}"
        try:
            path.unlink()
        except FileNotFoundError:
            raise refused(ProblemCode.USER_UNKNOWN, self.users_path, name) from None
        sync_folder(self.users_path)

    def _require(self) -> None:
        if not self.server_key.is_file():
            raise refused(ProblemCode.KEYS_NO_SERVER, self.path)
        private_folder(self.path)
        private_folder(self.users_path)


def _require_quotas(quotas: Quotas) -> None:
    for name, (low, high) in QUOTA_RANGES.items():
        value = getattr(quotas, name)
        if value is not None and not (math.isfinite(value) and low <= value <= high):
            raise refused(ProblemCode.USER_QUOTA, "", value, name=name, low=low, high=high)


def _read_user(path: Path) -> User:
    quotas = [each.name for each in fields(Quotas)]
    entries = read_entries(path, ("public", "role", *quotas), links=False)
    name = path.name.removesuffix(_ENDING)
    require_name(name)
    if entries.get("role") not in tuple(Role):
        raise refused(ProblemCode.USER_ROLE, path, entries.get("role", ""), known=", ".join(Role))
    values: dict[str, Any] = {each: _number(each, entries[each], path) for each in quotas if each in entries}
    user = User(name, key_in(entries, "public", path), Role(entries["role"]), Quotas(**values))
    _require_quotas(user.quotas)
    return user


def _number(name: str, text: str, path: Path) -> float | int:
    try:
        return int(text) if name in _WHOLE else float(text)
    except ValueError:
        low, high = QUOTA_RANGES[name]
        raise refused(ProblemCode.USER_QUOTA, path, text[:40], name=name, low=low, high=high) from None


def _user_text(user: User) -> str:
    lines = [f"# {user.name} may use this daemon.", f"public = {user.public}", f"role = {user.role}"]
    for each in fields(Quotas):
        value = getattr(user.quotas, each.name)
        if value is not None:
            lines.append(f"{each.name} = {value!r}")
    return "\n".join(lines) + "\n"
