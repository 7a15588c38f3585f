"""The daemon is started and solves something small; what does not work is a finding and no exception."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.installation import check_solver


def test_the_daemon_tells_its_instructions_and_a_hook_lifts_a_patch() -> None:
    daemon, solve = check_solver()
    assert daemon.state == "ok"
    assert " instructions, " in daemon.value
    assert solve.state == "ok"
    lifted = float(solve.value.split(" by ")[1].split(" mm")[0])
    assert 0.5 < lifted <= 1.01


def test_a_daemon_that_is_not_there_is_broken_with_its_remedy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(tmp_path / "none"))
    (found,) = check_solver()
    assert (found.name, found.state) == ("daemon", "broken")
    assert str(tmp_path / "none") in found.value
    assert found.remedy


def test_a_daemon_that_ends_at_once_is_broken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program = tmp_path / "lappet-solverd"
    program.write_text("#!/bin/sh\nexit 3\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("LAPPET_SOLVERD", str(program))
    (found,) = check_solver()
    assert (found.name, found.state) == ("daemon", "broken")
