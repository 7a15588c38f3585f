"""A daemon that runs already, as a user names it, and the keys with which a client and it know each other."""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.key_files import KeyPair, read_pair, read_public

# A port is digits: "tcp://127.0.0.1:0;elsewhere:5570" is ZeroMQ's way to name another computer.
_LOOPBACK = re.compile(r"tcp://(127\.\d{1,3}\.\d{1,3}\.\d{1,3}|\[::1\]|localhost):\d{1,5}")
_SOCKET = "ipc://"


@dataclass(frozen=True)
class ClientKeys:
    """What a client proves itself with, and what it demands of the daemon.

    Parameters
    ----------
    server
        The daemon's public key, Z85.
    own
        The client's pair.
    """

    server: str
    own: KeyPair


@dataclass(frozen=True)
class RunningDaemon:
    """A daemon that runs already.

    Parameters
    ----------
    address
        Its address.
    server_key
        Its public key (Z85), or a file that holds it; empty for a daemon without keys.
    key
        File of the user's own key pair; empty for a daemon without keys.
    """

    address: str
    server_key: str = ""
    key: str = ""

    def keys(self) -> ClientKeys | None:
        """Read the keys.

        Returns
        -------
        ClientKeys | None
            The keys; None where neither is named and the daemon is on this computer.

        Raises
        ------
        RefusedError
            If one of them is missing or no key, or both are and the address is another computer's.
        """
        if not self.server_key and not self.key:
            require_no_stranger(self.address)
            return None
        if not self.server_key or not self.key:
            missing = "the server's key (--server-key)" if not self.server_key else "your own key (--key)"
            raise refused(ProblemCode.DAEMON_KEY_MISSING, "", self.address, missing=missing)
        try:
            return ClientKeys(read_public(self.server_key), read_pair(Path(self.key).expanduser()))
        except OSError as error:
            path, reason = error.filename or self.key, error.strerror or error
            raise refused(ProblemCode.KEY_UNREADABLE, path, reason) from error


def require_no_stranger(address: str) -> None:
    """Refuse an address at which anybody but this user's own programs may listen, since the token goes there in clear.

    Parameters
    ----------
    address
        The address.

    Raises
    ------
    RefusedError
        If it is another computer's, or a socket of another user.
    """
    if _LOOPBACK.fullmatch(address):
        return
    if not address.startswith(_SOCKET):
        if "://" in address:  # else it is no address, as the connection says
            raise refused(ProblemCode.DAEMON_NEEDS_KEYS, "", address)
        return
    path = address.removeprefix(_SOCKET)
    if os.name == "posix" and (path.startswith("@") or not _is_own(Path(path).parent)):
        raise refused(ProblemCode.DAEMON_OF_ANOTHER, "", address)


def _is_own(folder: Path) -> bool:
    """Whether nobody else can put a socket there; where there is no folder nobody listens."""
    try:
        found = folder.stat()
    except OSError:
        return True
    return found.st_uid in (os.geteuid(), 0) and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
