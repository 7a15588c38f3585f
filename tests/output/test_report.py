"""The report has every key that is promised, with plain JSON values of the right kind."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lappet.output.report import report, write_report
from lappet.output.solve_to_cache import SolveResult
from lappet.program.compile import compile_program
from lappet.solve.measures import Gauges
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from report_shape import FRAME, REPORT, misfits
from small_procedure import FakeSolver, small_procedure


def result(folder: Path, solver: FakeSolver, procedure: Any = None) -> SolveResult:
    procedure = procedure or small_procedure()
    program = compile_program(procedure)
    found = solve_program(program, FrameStore(folder), solver.connect, "fake", SolveObserver())
    gauges = Gauges(program)
    measures = tuple(gauges.measure(frame.solved, tension=True) for frame in found.frames)
    return SolveResult(
        procedure, program, found.frames, found.reason, found.interrupted, found.failed, measures=measures
    )


def test_the_report_has_every_key_and_kind(tmp_path: Path) -> None:
    write_report(result(tmp_path / "store", FakeSolver()), tmp_path / "r.json")
    values = json.loads((tmp_path / "r.json").read_text())
    assert misfits(values, REPORT) == []
    assert len(values["frames"]) == 8
    assert values["complete"] is True


def test_the_values_are_those_of_the_solve(tmp_path: Path) -> None:
    values = report(result(tmp_path, FakeSolver()))
    frame = values["frames"][5]
    assert frame["time_code"] == 6
    assert (frame["newton_iterations"], frame["pcg_iterations"], frame["residual"]) == (3, 40, 1e-4)
    assert frame["suture_forces_mn"] == {"stitch": 5.0}
    assert frame["suture_force_vectors_mn"] == {"stitch": [0.0, 5.0, 0.0]}
    assert frame["hook_forces_mn"] == {"hook": [2.0, 2.0, 2.0]}
    # Nothing was estimated: an error is not known, which is not 0.
    assert frame["suture_force_errors_mn"] == {"stitch": None}
    assert frame["hook_force_errors_mn"] == {"hook": None}
    assert [(each["total_mn"], each["total_error_mn"]) for each in values["sutures"]] == [(5.0, None)] * 4
    assert frame["landmarks"].keys() == {"corner"}
    assert frame["landmarks"]["corner"][:2] == [-8.0, 4.0]
    assert values["lattice"]["cells"] == 20
    assert [epoch["lattice"]["cells"] for epoch in values["epochs"]] == [10, 20]
    assert values["peak_memory_bytes"] == 1008.0
    assert values["settings"]["spacing"] == 1.0
    assert values["scene_profile"]["sutures"] is True
    assert values["scene_profile"]["retractors"] is False
    assert values["scene_profile"]["explicit_mesh"] is True
    assert (values["frames_solved"], values["cache_hits"]) == (8, 0)


def test_looked_up_frames_are_cache_hits_and_keep_what_they_took(tmp_path: Path) -> None:
    result(tmp_path, FakeSolver())
    values = report(result(tmp_path, FakeSolver()))
    assert all(frame["cache_hit"] for frame in values["frames"])
    assert (values["frames_solved"], values["cache_hits"]) == (0, 8)
    assert values["frames"][0]["newton_iterations"] == 3
    assert values["lattice"]["cells"] == 20


def test_an_unconverged_frame_is_reported_apart_with_its_reason(tmp_path: Path) -> None:
    values = report(result(tmp_path, FakeSolver(unconverged=frozenset({4.0}))))
    assert values["complete"] is False
    assert "Frame 4" in values["reason"]
    assert len(values["frames"]) == 3
    assert misfits(values["failed"], FRAME) == []
    assert values["failed"]["converged"] is False


def test_what_is_not_finite_is_null(tmp_path: Path) -> None:
    made = result(tmp_path, FakeSolver())
    first = made.frames[0]
    said = replace(first.solved.diagnostics, residual=math.nan, energy=np.float64(np.inf))
    lost = replace(first, solved=replace(first.solved, diagnostics=said))
    frame = report(replace(made, frames=(lost, *made.frames[1:])))["frames"][0]
    assert frame["residual"] is None
    assert frame["energy_mn_mm"] is None


def test_a_report_without_frames_is_a_report(tmp_path: Path) -> None:
    values = report(result(tmp_path, FakeSolver(unconverged=frozenset({1.0}))))
    assert values["frames"] == []
    assert values["lattice"]["cells"] is None
    assert values["peak_memory_bytes"] is None


def test_a_report_that_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "r.json").mkdir()
    with pytest.raises(OSError):  # noqa: PT011 - the system's own words differ
        write_report(result(tmp_path / "store", FakeSolver()), tmp_path / "r.json")
    assert [each.name for each in tmp_path.iterdir() if each.name.startswith(".report")] == []
