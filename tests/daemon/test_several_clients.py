"""Clients of one daemon do not disturb each other's numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.daemon.process import SolverDaemon
from several_clients import compare

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]


def test_each_of_four_clients_gets_every_bit_that_a_lone_client_gets(binary: Path) -> None:
    """With a BLAS that is not safe to call from several threads, two to three of a hundred frames differed."""
    with SolverDaemon(binary, arguments=("--max-clients", "5")) as daemon:
        found = compare(daemon, clients=4, frames=800)
    assert found.solved >= 800
    assert found.differing == []
