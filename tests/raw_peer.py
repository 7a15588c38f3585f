"""A client of the daemon that sends whatever it is told."""

from __future__ import annotations

from typing import Any

import zmq

from lappet.daemon.process import SolverDaemon
from lappet.daemon.wire import Message, decode, encode


class Raw:
    """A DEALER that says `hello` with the right token and then whatever it is told."""

    def __init__(self, daemon: SolverDaemon, *, greet: bool = True) -> None:
        self.context = zmq.Context()
        self.socket: zmq.Socket[bytes] = self.context.socket(zmq.DEALER)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.connect(daemon.address)
        self.ids = iter(range(1, 10_000))
        if greet:
            assert self.ask("hello", {"token": daemon.token, "client": "raw"}).type == "welcome"

    def receive(self, timeout: float = 10.0) -> Message:
        while self.socket.poll(int(timeout * 1000)):
            message = decode(self.socket.recv_multipart())
            if message.type != "progress":
                return message
        raise AssertionError(f"no reply within {timeout} s")

    def send(self, kind: str, fields: dict[str, Any] | None = None, arrays: dict[str, Any] | None = None) -> int:
        identifier = next(self.ids)
        self.socket.send_multipart(encode(Message(kind, identifier, None, fields or {}, arrays or {})))
        return identifier

    def ask(self, kind: str, fields: dict[str, Any] | None = None, arrays: dict[str, Any] | None = None) -> Message:
        identifier = self.send(kind, fields, arrays)
        reply = self.receive()
        assert reply.id == identifier
        return reply

    def refused(self, *frames: bytes) -> tuple[str, str]:
        self.socket.send_multipart(frames)
        reply = self.receive()
        assert reply.type == "error", reply
        return reply.fields["code"], reply.fields["message"]

    def close(self) -> None:
        self.context.destroy(linger=0)
