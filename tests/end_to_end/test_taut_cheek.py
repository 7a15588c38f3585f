"""Skin of the cheek under its whole tension: its rim enters some cells of the lattice by a sliver only."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.models.body_package import is_fetched
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import new_model
from lappet.output.solve_to_cache import solve_procedure
from lappet.solve.store import FrameStore

SPACING = 1.5  # mm; with a penalty that does not grow a sliver stays open here, and on finer lattices

pytestmark = [
    pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch"),
    pytest.mark.slow,
    pytest.mark.timeout(300),
]


def test_taut_skin_is_held_at_its_rim_by_the_slivers_too(tmp_path: Path) -> None:
    taut = new_model("cheek", ModelChoice(laxity=0.0, spacing=SPACING))
    result = solve_procedure(
        taut, tmp_path / "cheek.usdc", frames=(1, 1), store=FrameStore(tmp_path / "store"), error_estimate=False
    )
    assert result.complete, result.reason
    (frame,) = result.frames
    assert frame.solved.converged
    assert frame.solved.diagnostics.largest_gap <= 1e-3 * SPACING
