"""What became of the handshake with a daemon: ZeroMQ repeats it in silence, and says so only to who watches."""

from __future__ import annotations

from typing import Any

import zmq
from zmq.utils.monitor import recv_monitor_message

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode

_WATCHED = (
    zmq.Event.HANDSHAKE_SUCCEEDED
    | zmq.Event.HANDSHAKE_FAILED_NO_DETAIL
    | zmq.Event.HANDSHAKE_FAILED_PROTOCOL
    | zmq.Event.HANDSHAKE_FAILED_AUTH
)
_NOT_KNOWN = 400  # of ZAP
_OTHER_MECHANISM = int(zmq.PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH)
_TRIES = 3  # that end without a word, as where keys do not match; a daemon that is busy may end one


class DaemonRefuses(RefusedError):
    """The daemon does not know this client, or is not the one that the client knows."""


class Handshake:
    """The handshakes of a socket.

    Parameters
    ----------
    socket
        The socket, not connected yet.
    address
        Where it will connect to, for messages.
    with_keys
        Whether both sides are to prove themselves.
    """

    def __init__(self, socket: zmq.Socket[Any], address: str, with_keys: bool) -> None:
        self._socket, self._address, self._with_keys = socket, address, with_keys
        self._monitor: zmq.Socket[Any] = socket.get_monitor_socket(_WATCHED)
        self._failed = 0

    def close(self) -> None:
        """Watch no longer; before the socket is closed."""
        self._socket.disable_monitor()
        self._monitor.close(0)

    def succeeded(self, timeout_ms: int = 0) -> bool:
        """Look what has become of it.

        Parameters
        ----------
        timeout_ms
            Milliseconds to wait for news.

        Returns
        -------
        bool
            Whether one has succeeded since the last call.

        Raises
        ------
        DaemonRefuses
            If the daemon refuses this client, or has not proved to have the key that it should have.
        """
        while self._monitor.poll(timeout_ms):
            timeout_ms = 0
            news = recv_monitor_message(self._monitor)
            if news["event"] == zmq.Event.HANDSHAKE_SUCCEEDED:
                self._failed = 0
                return True
            self._failed += 1
            code = self._problem(news["event"], news["value"])
            if code is not None:
                raise DaemonRefuses.of(code, "", self._address)
        return False

    def _problem(self, event: int, value: int) -> ProblemCode | None:
        """What is wrong for good; whether a side without keys says so, or only hangs up, is a matter of luck."""
        if event == zmq.Event.HANDSHAKE_FAILED_AUTH and value == _NOT_KNOWN:
            return ProblemCode.DAEMON_KEY_UNKNOWN
        other_mechanism = event == zmq.Event.HANDSHAKE_FAILED_PROTOCOL and value == _OTHER_MECHANISM
        if other_mechanism or self._failed >= _TRIES:
            return ProblemCode.DAEMON_OTHER_KEY if self._with_keys else ProblemCode.DAEMON_WITH_KEYS
        return None
