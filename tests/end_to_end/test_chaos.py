"""A solve that is disturbed in any way leaves nothing partial behind, and the next one gives the same cache."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from chaos import chaos

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(280),
    pytest.mark.skipif(sys.platform != "linux", reason="it looks for processes in /proc"),
]


def test_half_a_minute_of_chaos_changes_no_bit_and_leaves_nothing(tmp_path: Path, binary: Path) -> None:
    """`python tests/chaos.py --seed N --seconds 120` goes on for longer."""
    found = chaos(tmp_path, seed=7, seconds=30.0)
    assert found.done.total() >= 3
    assert found.broken == []
