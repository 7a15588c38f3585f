"""What tests of the background solver share."""

from __future__ import annotations

from pathlib import Path

import pytest

from background_owner import long_procedure
from lappet.output.solve_to_cache import solve_procedure
from lappet.solve.store import FrameStore


@pytest.fixture(scope="module")
def foreground(tmp_path_factory: pytest.TempPathFactory, binary: Path) -> Path:
    """The store of `lappet solve` for the long procedure."""
    folder = tmp_path_factory.mktemp("foreground")
    result = solve_procedure(
        long_procedure(), folder / "c.usdc", store=FrameStore(folder / "store"), error_estimate=False
    )
    assert result.complete
    return folder / "store"
