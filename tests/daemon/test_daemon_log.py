"""What a client says is one line of printable text in the daemon's log, whatever it is."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from lappet.daemon.process import SolverDaemon, find_daemon
from raw_peer import Raw

NAME = "\x1b]0;title\x07\x1b[2Jgone\r\nlappet-solverd: critical: forged\u202eback\x7f\x9b2J"


def test_nothing_that_a_client_says_reaches_the_daemons_log_as_control_characters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a terminal gets it: the daemon's own standard error, in full."""
    log = tmp_path / "log"
    starts = tmp_path / "starts"
    starts.write_text(f'#!/bin/sh\nexec {shlex.quote(str(find_daemon()))} "$@" 2>{shlex.quote(str(log))}\n')
    starts.chmod(0o755)
    monkeypatch.setenv("SPDLOG_LEVEL", "info")
    with SolverDaemon(starts) as daemon:
        peer = Raw(daemon, greet=False)
        assert peer.ask("hello", {"token": daemon.token, "client": NAME}).type == "welcome"
        assert peer.ask(NAME).type == "error"
        assert peer.ask("open", {NAME: NAME}).type == "error"
        assert peer.ask("ping", {NAME: 1}).type == "error"
        peer.close()
    said = log.read_bytes()
    assert b"says hello" in said
    assert said.count(b"?]0;title??[2Jgone??lappet") >= 2
    assert [byte for byte in said if byte != 0x0A and not 0x20 <= byte <= 0x7E] == []
    assert [
        line for line in said.splitlines() if b"forged" in line and not line.startswith(b"lappet-solverd: info")
    ] == []
