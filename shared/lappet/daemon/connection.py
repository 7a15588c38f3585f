"""The connection to a daemon: requests and their replies, heartbeats, and the discovery that the daemon is dead."""

from __future__ import annotations

import contextlib
import itertools
import os
import threading
import time
from collections.abc import Callable
from typing import Any, Self

import zmq
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import FrameRefusedError
from lappet.daemon.handshake import DaemonRefuses, Handshake
from lappet.daemon.process import DaemonDied, DaemonMissing, SolverDaemon
from lappet.daemon.running_daemon import ClientKeys, require_no_stranger
from lappet.daemon.wire import DEFAULT_MAX_MESSAGE_BYTES, Message, WireError, decode, encode

_POLL_MS = 50
_PING_SECONDS = 2.0
_CANCEL_SECONDS = 3.0
_HEARTBEAT_SECONDS = 5.0
# What is not sent when the socket is closed waits so long. At 0 libzmq may throw away the rest of a message of which it
# has sent a part, and aborts the process when the connection is cut just then (session_base.cpp, clean_pipes).
_LINGER_MS = 200


ERROR_CODES = {
    "malformed": ProblemCode.SOLVER_MALFORMED,
    "out_of_order": ProblemCode.SOLVER_OUT_OF_ORDER,
    "unauthorized": ProblemCode.SOLVER_UNAUTHORIZED,
    "invalid_input": ProblemCode.SOLVER_INVALID_INPUT,
    "memory_budget": ProblemCode.SOLVER_MEMORY_BUDGET,
    "time_budget": ProblemCode.SOLVER_TIME_BUDGET,
    "cancelled": ProblemCode.SOLVER_CANCELLED,
    "internal": ProblemCode.SOLVER_INTERNAL,
}
"""What an `error` of PROTOCOL.md is, by its code."""


_WELCOME = {"version": str, "threads": int, "isa": str, "compiler": str, "max_message_bytes": int}


class SolverRefused(FrameRefusedError):
    """An error that the daemon answered with."""

    @property
    def code(self) -> str:
        """The code of PROTOCOL.md, "Errors"."""
        return next(code for code, known in ERROR_CODES.items() if known is self.problems[0].code)


class SolveCancelled(SolverRefused):
    """The solve was cancelled; the session keeps the state from before it."""


class DaemonConnection:
    """The requests to one daemon and their replies.

    `welcome` holds the fields of the daemon's greeting, `session` the number that goes into every header, or None. One
    thread at a time makes requests; `cancel` may be called from any.

    Parameters
    ----------
    address
        Address of a running daemon; without one a daemon is started here and ended with the connection.
    token
        Token of a running daemon without keys; None for the environment's `LAPPET_TOKEN`.
    keys
        The running daemon's key and the user's own, where it has keys; then no token is sent.
    daemon
        A daemon of the caller's; it is started where it does not run, and not ended here.
    name
        What the daemon calls this client in its log.
    silence
        Seconds without an answer after which the daemon counts as dead.
    """

    def __init__(
        self,
        address: str | None = None,
        token: str | None = None,
        *,
        keys: ClientKeys | None = None,
        daemon: SolverDaemon | None = None,
        name: str = "lappet",
        silence: float = 20.0,
    ) -> None:
        self._daemon = daemon if daemon is not None or address is not None else SolverDaemon()
        self._owns_daemon = daemon is None and address is None
        self._address = address
        self._token = token
        self._keys = keys
        self._name = name
        self._silence = silence
        self._lock = threading.RLock()
        self._ids = itertools.count(1)
        self._context: zmq.Context[Any] | None = None
        self._socket: zmq.Socket[Any] | None = None
        self._handshake: Handshake | None = None
        self._stop = threading.Event()
        self._cancel_wanted = threading.Event()
        self._heartbeat: threading.Thread | None = None
        self._unanswered_since: float | None = None
        self._pinged = 0.0
        self._max_message_bytes = DEFAULT_MAX_MESSAGE_BYTES
        self.session: int | None = None
        self.welcome: dict[str, Any] = {}

    def connect(self) -> Self:
        """Start the daemon where there is none, connect and say hello.

        Returns
        -------
        Self
            This connection.

        Raises
        ------
        DaemonMissing
            If the address is none, or there is no daemon to start.
        DaemonRefuses
            If the daemon does not know the user's key, or does not have the key that it should have.
        WireError
            If its greeting breaks PROTOCOL.md.
        """
        if self._socket is not None:
            return self
        try:
            if self._daemon is not None:
                self._daemon.start()
                self._address, self._token, self._keys = self._daemon.address, self._daemon.token, self._daemon.keys
            self._context = zmq.Context()
            self._socket = self._context.socket(zmq.DEALER)
            self._open(self._socket, str(self._address))
            self._pinged = time.monotonic()
            hello = {"client": self._name}
            if self._keys is None:
                hello["token"] = self._token or os.environ.get("LAPPET_TOKEN", "")
            self.welcome = expect(self.request("hello", hello), "welcome").fields
            for name, kind in _WELCOME.items():
                if not isinstance(self.welcome.get(name), kind):
                    raise WireError(
                        f"The daemon's 'welcome' has no {kind.__name__} '{name}'; install one release of both."
                    )
            self._max_message_bytes = self.welcome["max_message_bytes"]
            self._heartbeat = threading.Thread(target=self._beat, name="lappet-heartbeat", daemon=True)
            self._heartbeat.start()
        except BaseException:
            self.close()
            raise
        return self

    def _open(self, socket: zmq.Socket[Any], address: str) -> None:
        """Connect the socket, and wait until both sides have proved themselves: before that nothing is sent."""
        socket.setsockopt(zmq.LINGER, _LINGER_MS)
        socket.setsockopt(zmq.IPV6, int("[" in address))
        if self._keys is None:
            require_no_stranger(address)
        else:
            socket.setsockopt_string(zmq.CURVE_SERVERKEY, self._keys.server)
            socket.setsockopt_string(zmq.CURVE_PUBLICKEY, self._keys.own.public)
            socket.setsockopt_string(zmq.CURVE_SECRETKEY, self._keys.own.secret)
        self._handshake = Handshake(socket, address, self._keys is not None)
        try:
            socket.connect(address)
        except zmq.ZMQError as error:
            raise DaemonMissing.of(ProblemCode.DAEMON_ADDRESS, "", address, reason=error) from error
        self._unanswered_since = time.monotonic()
        while not self._handshake.succeeded(_POLL_MS):
            self._check_alive()
        self._unanswered_since = None

    def close(self) -> None:
        """Take leave, and end the daemon that was started here; may be called twice."""
        self._stop.set()
        if self._heartbeat is not None and self._heartbeat is not threading.current_thread():
            self._heartbeat.join(timeout=2.0)
            self._heartbeat = None
        with self._lock:
            if self._socket is not None:
                if not self._owns_daemon and self.welcome:
                    with contextlib.suppress(DaemonDied, zmq.ZMQError):
                        self._send("bye", next(self._ids))
                if self._handshake is not None:
                    self._handshake.close()
                    self._handshake = None
                self._socket.close()
                self._socket = None
            if self._context is not None:
                self._context.term()
                self._context = None
        if self._owns_daemon and self._daemon is not None:
            self._daemon.stop()

    def cancel(self) -> None:
        """Cancel the solve that runs; from any thread."""
        self._cancel_wanted.set()

    def request(
        self,
        kind: str,
        fields: dict[str, Any] | None = None,
        arrays: dict[str, NDArray[Any]] | None = None,
        on_progress: Callable[[Message], None] | None = None,
    ) -> Message:
        """Send a message and wait for the last reply to it; replies to earlier ones that were given up are dropped.

        Whatever `on_progress` raises, and Ctrl-C, cancels the request first.

        Parameters
        ----------
        kind
            Type of the message.
        fields
            Fields of its header.
        arrays
            Arrays by name.
        on_progress
            Called with every message `progress`.

        Returns
        -------
        Message
            The reply.

        Raises
        ------
        DaemonDied
            If the daemon is gone or fell silent.
        DaemonRefuses
            If it lets the user in no longer.
        SolverRefused
            If the daemon answers with an error.
        SolveCancelled
            If the request was cancelled.
        WireError
            If the reply breaks PROTOCOL.md.
        """
        with self._lock:
            if self._socket is None:
                raise DaemonDied.of(ProblemCode.DAEMON_CLOSED)
            identifier = next(self._ids)
            self._cancel_wanted.clear()
            try:
                self._send(kind, identifier, fields, arrays)
                reply = self._wait(identifier, on_progress)
            except (DaemonDied, DaemonRefuses, WireError):
                raise
            except BaseException:
                self._give_up(identifier)
                raise
        return _without_error(reply)

    def follow(self, session: int, on_message: Callable[[Message], None]) -> None:
        """Follow a session of another connection until it is over; this connection is of no other use after that.

        What `on_message` raises, and Ctrl-C, ends it too.

        Parameters
        ----------
        session
            Number of the session.
        on_message
            Called with every `lattice`, `progress` and `frame` that the session's own client is answered with.

        Raises
        ------
        DaemonDied
            If the daemon is gone or fell silent.
        DaemonRefuses
            If it lets the user in no longer.
        SolverRefused
            If there is no such session that the user may follow, or the daemon has no keys.
        WireError
            If a message breaks PROTOCOL.md.
        """
        with self._lock:  # else the heartbeat would read what comes
            self.session = session
            identifier = expect(self.request("follow"), "accepted").id
            while True:
                message = self._wait(identifier, on_message)
                try:
                    on_message(_without_error(message))
                except SolveCancelled:
                    return

    def _send(
        self,
        kind: str,
        identifier: int,
        fields: dict[str, Any] | None = None,
        arrays: dict[str, NDArray[Any]] | None = None,
    ) -> None:
        message = Message(kind, identifier, self.session, fields or {}, arrays or {})
        frames = encode(message, self._max_message_bytes)
        assert self._socket is not None
        try:
            self._socket.send_multipart(frames, zmq.DONTWAIT, copy=False)
        except zmq.Again:
            raise DaemonDied.of(ProblemCode.DAEMON_FULL, "", self._address) from None
        if self._unanswered_since is None:
            self._unanswered_since = time.monotonic()

    def _wait(self, identifier: int, on_progress: Callable[[Message], None] | None) -> Message:
        cancelled = False
        while True:
            message = self._receive(_POLL_MS)
            if message is None:
                self._check_alive()
                if self._handshake is not None:
                    self._handshake.succeeded()  # or it says why not: a connection that was lost is made again
            elif message.id == identifier or (message.type == "error" and message.id == 0):
                if message.type != "progress":
                    return message
                if on_progress is not None:
                    on_progress(message)
            if self._cancel_wanted.is_set() and not cancelled:
                cancelled = True
                self._send("cancel", next(self._ids))
            self._ping_if_due(_PING_SECONDS)

    def _receive(self, timeout_ms: int) -> Message | None:
        assert self._socket is not None
        if not self._socket.poll(timeout_ms):
            return None
        frames = self._socket.recv_multipart(zmq.DONTWAIT)
        self._unanswered_since = None
        # A follower may send little, and is sent whole frames.
        return decode(frames, max(self._max_message_bytes, DEFAULT_MAX_MESSAGE_BYTES))

    def _check_alive(self) -> None:
        if self._daemon is not None and not self._daemon.alive():
            raise DaemonDied.of(ProblemCode.DAEMON_DIED, "", self._daemon.death())
        if self._unanswered_since is not None and time.monotonic() - self._unanswered_since > self._silence:
            raise DaemonDied.of(ProblemCode.DAEMON_SILENT, "", self._address, seconds=self._silence)

    def _ping_if_due(self, interval: float) -> None:
        now = time.monotonic()
        if now - self._pinged >= interval:
            self._pinged = now
            self._send("ping", next(self._ids))

    def _give_up(self, identifier: int) -> None:
        """Cancel a request and wait a moment for its end, so that the session can go on."""
        try:
            self._send("cancel", next(self._ids))
            end = time.monotonic() + _CANCEL_SECONDS
            while time.monotonic() < end:
                message = self._receive(_POLL_MS)
                if message is None:
                    self._check_alive()
                elif message.id == identifier and message.type != "progress":
                    return
        except (DaemonDied, DaemonRefuses, WireError, zmq.ZMQError):
            return

    def _beat(self) -> None:
        """Keep the daemon from ending while nothing is asked of it; a request that runs pings by itself."""
        while not self._stop.wait(_HEARTBEAT_SECONDS):
            if not self._lock.acquire(blocking=False):
                continue
            try:
                if self._socket is None:
                    return
                self._ping_if_due(_PING_SECONDS)
                while self._receive(0) is not None:
                    pass
                if self._handshake is not None:
                    self._handshake.succeeded()
            except (DaemonDied, DaemonRefuses, WireError, zmq.ZMQError):
                continue  # the next request says so
            finally:
                self._lock.release()


def _without_error(message: Message) -> Message:
    """The message, unless it is an error."""
    if message.type != "error":
        return message
    code = ERROR_CODES.get(str(message.fields.get("code")), ProblemCode.SOLVER_INTERNAL)
    error = SolveCancelled if code is ProblemCode.SOLVER_CANCELLED else SolverRefused
    raise error.of(code, "", str(message.fields.get("message", "The daemon gave no reason.")))


def expect(message: Message, kind: str) -> Message:
    """Refuse a message of another kind.

    Parameters
    ----------
    message
        The message.
    kind
        The type that it must have.

    Returns
    -------
    Message
        The message.

    Raises
    ------
    WireError
        If it is of another type.
    """
    if message.type != kind:
        raise WireError(f"The daemon answered '{message.type}' where '{kind}' was due; install both from one release.")
    return message
