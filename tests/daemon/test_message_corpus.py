"""The corpus is what its script makes, has every message, and harms no daemon that it is sent to."""

from __future__ import annotations

import contextlib
from pathlib import Path

import msgpack
import pytest

from corpus_messages import file_of, messages_of
from lappet.daemon.process import SolverDaemon
from message_corpus import CONVERSATIONS, FOLDER
from raw_peer import Raw

FILES = sorted(FOLDER.glob("*.messages"))
TYPES = {"hello", "open", "epoch", "state", "solve", "cancel", "ping", "close", "bye", "shutdown"}


def type_of(header: bytes) -> str | None:
    """The type of a message, where its header is a map that has one."""
    try:
        found = msgpack.unpackb(header)
    except ValueError:
        return None
    return found.get("type") if isinstance(found, dict) and isinstance(found.get("type"), str) else None


def test_the_files_are_what_the_script_makes() -> None:
    kept = {path.stem: path.read_bytes() for path in FILES if not path.stem.startswith("found_")}
    made = {name: file_of(make()) for name, make in CONVERSATIONS.items()}
    assert kept.keys() == made.keys()
    assert [name for name in made if kept[name] != made[name]] == []


def test_every_conversation_and_every_finding_says_what_it_is_for() -> None:
    assert [name for name, make in CONVERSATIONS.items() if not make.__doc__] == []
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert [path.name for path in FILES if path.stem.startswith("found_") and f"`{path.name}`" not in page] == []


def test_every_message_that_a_client_may_send_is_in_the_corpus() -> None:
    found = {type_of(message[0]) for path in FILES for message in messages_of(path.read_bytes()) if message}
    assert found >= TYPES


@pytest.mark.slow
@pytest.mark.timeout(240)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_daemon_answers_each_message_once_and_lives(binary: Path, path: Path) -> None:
    """Also malformed ones; the exceptions are `bye`, after which it answers that there is no client, and `shutdown`."""
    with SolverDaemon(binary) as daemon, contextlib.closing(Raw(daemon)) as peer:
        for message in messages_of(path.read_bytes()):
            if not message:
                continue  # ZeroMQ sends no message without a part
            peer.socket.send_multipart(message)
            reply = peer.receive(100.0)
            assert reply.type != "error" or reply.fields["code"] != "internal", reply.fields
            if type_of(message[0]) == "shutdown" and reply.type == "accepted":
                return
        with contextlib.closing(Raw(daemon)) as another:
            assert another.ask("ping").type == "pong"
        assert daemon.alive(), daemon.death()
