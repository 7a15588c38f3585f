"""What a daemon says is checked, and shown as text whatever it is."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import zmq

from lappet.core.printable import printable
from lappet.daemon.client import SolverClient, SolverRefused
from lappet.daemon.wire import Message, WireError, decode, encode

WELCOME = {"version": "1.0", "threads": 2, "isa": "avx2", "compiler": "GNU", "max_message_bytes": 1 << 20}
Serve = Callable[[str, dict[str, Any]], str]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Starts a daemon that answers everything with one message; gives its address."""
    context = zmq.Context()
    threads: list[threading.Thread] = []
    stop = threading.Event()

    def start(kind: str, fields: dict[str, Any]) -> str:
        socket = context.socket(zmq.ROUTER)
        port = socket.bind_to_random_port("tcp://127.0.0.1")

        def answer() -> None:
            while not stop.is_set():
                if socket.poll(20):
                    identity, *frames = socket.recv_multipart()
                    reply = Message(kind, decode(frames).id, None, fields, {})
                    socket.send_multipart([identity, *encode(reply)])
            socket.close(0)

        threads.append(threading.Thread(target=answer))
        threads[-1].start()
        return f"tcp://127.0.0.1:{port}"

    yield start
    stop.set()
    for thread in threads:
        thread.join()
    context.term()


@pytest.mark.parametrize("missing", sorted(WELCOME))
def test_a_welcome_without_a_field_is_named(serve: Serve, missing: str) -> None:
    address = serve("welcome", {name: value for name, value in WELCOME.items() if name != missing})
    with (
        pytest.raises(WireError, match=f"no {type(WELCOME[missing]).__name__} '{missing}'"),
        SolverClient(address, "t"),
    ):
        pass


def test_a_welcome_with_a_field_of_another_kind_is_named(serve: Serve) -> None:
    address = serve("welcome", {**WELCOME, "max_message_bytes": "many"})
    with pytest.raises(WireError, match="no int 'max_message_bytes'"), SolverClient(address, "t"):
        pass


def test_what_a_terminal_would_obey_is_shown_as_text(serve: Serve) -> None:
    address = serve("error", {"code": "internal", "message": "\x1b]0;title\x07\x1b[2Jgone\r\u202eback\nnext"})
    with pytest.raises(SolverRefused) as error, SolverClient(address, "t"):
        pass
    assert "?]0;title??[2Jgone??back\nnext" in str(error.value)


def test_ordinary_text_stays_as_it_is() -> None:
    text = "Größe µm² → 1/3\n„zwei“ 面"
    assert printable(text) == text
