"""The benchmark's numbers are those of the frames."""

from __future__ import annotations

from typing import Any

import pytest

from lappet.bench import measure, revision
from lappet.refused import RefusedError


def header(**changes: Any) -> dict[str, Any]:
    lattice = {"cells": 100, "grid_cells": 90, "mesh_cells": 10, "nodes": 150, "blocks": 20, "fine_voxels": 6400}
    plain = {
        "converged": True,
        "newton": 4,
        "pcg": 30,
        "seconds": {"total": 2.0, "linear": 1.5},
        "residual": 1e-4,
        "largest_gap": 1e-5,
        "minimum_j": 0.9,
        "peak_bytes": 1000.0,
        "lattice": lattice,
    }
    return {**plain, **changes}


def test_a_row_sums_work_and_takes_the_worst_of_the_frames() -> None:
    cut = {"cells": 120, "grid_cells": 80, "mesh_cells": 40, "nodes": 190, "blocks": 26, "fine_voxels": 6300}
    row = measure(
        "flap",
        1.0,
        2,
        3,
        9.0,
        [
            header(),
            header(newton=6, residual=5e-4),
            header(lattice=cut, largest_gap=2e-4, minimum_j=0.4, peak_bytes=2400),
        ],
    )
    assert row.converged
    assert row.reason is None
    assert (row.frames, row.epochs) == (3, 3)
    assert (row.cells, row.mesh_cells, row.nodes) == (120, 40, 190)
    assert (row.newton_iterations, row.pcg_iterations) == (14, 90)
    assert row.solver_seconds == 6.0
    assert row.linear_seconds == 4.5
    assert row.newton_iteration_s == pytest.approx(6.0 / 14)
    assert (row.residual, row.largest_gap_mm, row.minimum_j) == (5e-4, 2e-4, 0.4)
    assert row.peak_bytes == 2400
    assert row.bytes_per_cell == 20


def test_a_frame_that_did_not_converge_makes_the_row_say_why() -> None:
    row = measure("flap", 1.0, 2, 3, 9.0, [header(), header(converged=False, reason="the line search found no step")])
    assert not row.converged
    assert row.reason == "the line search found no step"


def test_no_frame_is_refused_by_the_scene_s_name() -> None:
    with pytest.raises(RefusedError, match="flap: no frame was solved"):
        measure("flap", 1.0, 2, 3, 9.0, [])


def test_the_revision_is_a_git_name_or_nothing() -> None:
    found = revision()
    assert found is None or len(found.rstrip("+")) == 12
