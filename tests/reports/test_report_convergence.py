"""Converged frames at the default settings lie within 0.05 mm of the exact ones; the files of the report."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from lappet.reports.convergence.files import totals, write_convergence
from lappet.reports.convergence.measurement import ConvergenceRow, compare, compare_twins
from lappet.reports.convergence.scenes import BeamScene, FlapScene, Kind, scenes, twins

SMALL, LARGE = (60.0, 40.0), (100.0, 80.0)


def right(rows: list[ConvergenceRow]) -> None:
    for row in rows:
        assert row.ok, f"{row.scene}, frame {row.frame:g}: {row.error_mm:.3g} mm of {row.allowed_mm:.3g}. {row.reason}"
        assert row.to_come_mm <= 0.02 * row.spacing_mm
        # What is said to be still to come is what is missing; small things are lost in the rounding of points.
        assert row.error_mm <= 3.0 * row.to_come_mm + 0.01


@pytest.mark.parametrize(
    ("kind", "size", "taut", "modulus"),
    [
        ("freed", LARGE, False, 500.0),  # took no step before, as its residual hid in that of the patch
        ("freed", SMALL, False, 5.0),
        ("hanging", SMALL, True, 5000.0),
        ("lifted", SMALL, True, 50.0),  # rested too high for ever once the hook had let go
        ("released", SMALL, True, 500.0),
        ("released", SMALL, True, 50.0),  # ended 1.5 mm off, after a step with a definite tangent that told nothing
    ],
)
def test_a_flap_at_default_settings_is_where_the_exact_solution_has_it(
    kind: Kind, size: tuple[float, float], taut: bool, modulus: float
) -> None:
    rows = compare(FlapScene(kind, size, taut, modulus))
    right(rows)
    assert max(row.moved_mm for row in rows) > 2.0


def test_a_flap_that_settles_slowly_is_not_left_halfway() -> None:
    # Two iterations of its last linear solve had told of a twentieth of what was still to come.
    rows = compare(FlapScene("lifted", (160.0, 40.0), True, 500.0, flaps=((-40.0, 0.0),)))
    assert all(row.ok for row in rows), rows


def test_a_beam_in_bending_is_not_spoiled_by_a_solve_that_ends_too_soon() -> None:
    right(compare(BeamScene(1.5)))
    right(compare(BeamScene(1.5, youngs_modulus=20.0)))


def test_two_flaps_far_apart_move_as_one_alone_does() -> None:
    one, two = next(iter(twins(quick=True)))
    rows = compare_twins(one, two)
    assert all(row.ok for row in rows), rows


def test_the_campaign_has_every_kind_in_small_and_large_patches_slack_and_taut() -> None:
    campaign = [scene for scene in scenes(quick=False) if isinstance(scene, FlapScene)]
    assert {scene.kind for scene in campaign} == {"released", "hanging", "freed", "lifted"}
    assert {scene.taut for scene in campaign} == {False, True}
    assert min(scene.size[0] for scene in campaign) == 60.0
    assert max(scene.size[0] for scene in campaign) == 400.0
    assert (min(s.youngs_modulus for s in campaign), max(s.youngs_modulus for s in campaign)) == (5.0, 5000.0)
    assert len(list(scenes(quick=True))) < len(list(scenes(quick=False)))


def test_the_files_hold_every_row_and_its_totals(tmp_path: Path) -> None:
    row = ConvergenceRow("freed", "a flap", 2.0, 2.0, True, "", 12.0, 0.02, 0.1, 0.03, 9, 12, 1.0, True)
    rows = [row, replace(row, error_mm=0.2, ok=False), replace(row, kind="twins", moved_mm=float("nan"))]
    assert totals(rows)["freed"] == {"frames": 2, "ok": 1, "error_mm": 0.2, "share": pytest.approx(2.0)}
    assert totals(rows)["all"]["frames"] == 3
    machine = {"processor": "p", "cores": 2, "memory_bytes": 2**30}
    head = {"machine": machine, "compiler": "c", "isa": "i", "threads": 1, "revision": "r", "date": "d"}
    files = write_convergence(tmp_path, head, rows)
    written = json.loads(files[0].read_text(encoding="utf-8"))
    assert [each["error_mm"] for each in written["rows"]] == [0.02, 0.2, 0.02]
    assert written["rows"][2]["moved_mm"] is None
    assert len(files[1].read_text(encoding="utf-8").splitlines()) == 4
    assert "NO" in files[2].read_text(encoding="utf-8")
