"""What tests of commands share: a procedure's file, and a solver that stands in for the daemon."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure


@pytest.fixture
def solver(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> FakeSolver:
    """A solver that stands in for the daemon, and a store of its own."""
    fake = FakeSolver()
    for user in ("output.solve_to_cache", "output.inspect_procedure", "daemon.daemon_solver"):
        monkeypatch.setattr(f"lappet.{user}.connect_to", lambda address: fake.connect)
    monkeypatch.setattr("lappet.output.solve_to_cache.solver_identity", lambda address: "fake 1")
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "store"))
    return fake


@pytest.fixture
def procedure(tmp_path: Path) -> Path:
    path = tmp_path / "p.usda"
    write_procedure(small_procedure(), path)
    return path
