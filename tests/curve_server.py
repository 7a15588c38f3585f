"""A server with keys in place of a daemon: it greets whom its folder of keys knows, and keeps what reached it."""

from __future__ import annotations

import threading
from typing import Any

import zmq
from zmq.auth.thread import ThreadAuthenticator

from lappet.daemon.key_files import KeyPair
from lappet.daemon.keys_folder import KeysFolder
from lappet.daemon.wire import Message, decode, encode

WELCOME = {"version": "9.9", "threads": 2, "isa": "avx2", "compiler": "GNU", "max_message_bytes": 1 << 20}


class CurveServer:
    """A context manager: `address`; `messages` that arrived; `replies` by type, where they are not the usual ones."""

    def __init__(self, pair: KeyPair | None, folder: KeysFolder | None = None, *, port: int = 0) -> None:
        self.messages: list[Message] = []
        self.replies: dict[str, Message] = {}
        self._folder = folder
        self._context = zmq.Context()
        self._authenticator = ThreadAuthenticator(self._context)
        self._socket: zmq.Socket[bytes] = self._context.socket(zmq.ROUTER)
        if pair is not None:
            self._authenticator.start()
            self._authenticator.configure_curve_callback("*", self)
            self._socket.setsockopt(zmq.CURVE_SERVER, 1)
            self._socket.setsockopt_string(zmq.CURVE_SECRETKEY, pair.secret)
        self._socket.bind(f"tcp://127.0.0.1:{port}")
        self.address = self._socket.getsockopt_string(zmq.LAST_ENDPOINT)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._answer)

    def callback(self, domain: str, key: bytes) -> bool:
        """What the authenticator asks: whether a public key is a user's."""
        assert self._folder is not None
        return key.decode() in [user.public for user in self._folder.users()[0]]

    def __enter__(self) -> CurveServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        self._socket.close(0)
        if self._authenticator.is_alive():
            self._authenticator.stop()
        self._context.term()

    def _answer(self) -> None:
        while not self._stop.is_set():
            if not self._socket.poll(20):
                continue
            identity, *frames = self._socket.recv_multipart()
            message = decode(frames)
            self.messages.append(message)
            usual: dict[str, Any] = WELCOME if message.type == "hello" else {}
            kind = {"hello": "welcome", "ping": "pong"}.get(message.type, "accepted")
            reply = self.replies.get(message.type, Message(kind, 0, None, usual, {}))
            answer = Message(reply.type, message.id, None, reply.fields, {})
            self._socket.send_multipart([identity, *encode(answer)])
