"""The stages of a solve are timed one by one, and together they are the solve."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest

from lappet.bench import __main__ as bench
from lappet.bench import tables
from lappet.bench.pipeline import STAGES, StageMeasure, measure_pipeline
from lappet.core.problem import RefusedError
from lappet.procedure import Procedure
from lappet.usd import write_procedure
from small_procedure import small_procedure


def row(stage: str, seconds: float, spacing: float = 0.5) -> StageMeasure:
    return StageMeasure("flap", spacing, 1000, 8, 2, "avx2", stage, seconds, seconds / 2, seconds / 10.0)


def rows_of(*spacings: float) -> list[StageMeasure]:
    return [row(stage, float(k), spacing) for spacing in spacings for k, stage in enumerate(STAGES)]


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_every_stage_is_timed_and_the_shares_make_a_whole(binary: Path, tmp_path: Path) -> None:
    file = tmp_path / "small.usda"
    write_procedure(small_procedure(), file)
    begun = time.perf_counter()
    rows = measure_pipeline(file, 2.0, tmp_path)
    took = time.perf_counter() - begun
    assert tuple(each.stage for each in rows) == STAGES
    assert all(each.seconds > 0.0 and each.own_seconds >= 0.0 for each in rows)
    assert sum(each.share for each in rows) == pytest.approx(1.0)
    assert sum(each.seconds for each in rows) < took
    assert {(each.scene, each.frames) for each in rows} == {("small", 8)}
    assert rows[0].cells > 0
    assert rows[0].isa
    assert (tmp_path / "small.usdc").is_file()


def test_a_procedure_with_errors_is_refused_before_it_is_cut(tmp_path: Path) -> None:
    file = tmp_path / "empty.usda"
    procedure = small_procedure()
    write_procedure(Procedure(**{**vars(procedure), "end_time": procedure.start_time - 2.0}), file)
    with pytest.raises(RefusedError):
        measure_pipeline(file, 2.0, tmp_path)


def test_the_table_has_a_row_for_each_size_and_a_column_for_each_stage() -> None:
    text = tables.pipeline_markdown(rows_of(1.0, 0.5))
    header, _, coarse, fine = [line for line in text.splitlines() if line.startswith("|")]
    assert all(f"| {stage} " in header for stage in STAGES)
    assert coarse.startswith("| flap at 1 mm ")
    assert fine.startswith("| flap at 0.5 mm ")
    assert "7.00 (3.50, 70 %)" in fine


def test_the_rows_are_written_under_the_head_of_the_other_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench.pipeline_suite, "pipeline", lambda examples, folder, until: rows_of(0.5))
    monkeypatch.setattr(bench.kernel_suite, "find_benchmarks", lambda: Path("solverd_benchmarks"))
    monkeypatch.setattr(bench.kernel_suite, "run_suite", lambda program, only, **hurry: limits())
    assert bench.run(("pipeline",), tmp_path, Path("examples"), False, False) == []
    written = json.loads((tmp_path / "pipeline.json").read_text("utf-8"))
    assert {"machine", "compiler", "isa", "threads", "revision"} <= set(written)
    assert [each["stage"] for each in written["rows"]] == list(STAGES)
    assert (tmp_path / "pipeline.csv").read_text("utf-8").count("\n") == 1 + len(STAGES)


def limits() -> dict[str, Any]:
    """What solverd_benchmarks prints of the machine's limits alone."""

    def entry(name: str, **counters: float) -> dict[str, Any]:
        timed = {"run_type": "iteration", "cpu_time": 1e6, "real_time": 1e6, "time_unit": "ns"}
        return {"name": name, **timed, **counters}

    return {
        "context": {"compiler": "g++ 12", "isa": "avx2", "instruction_sets": "avx2", "stream_bytes": "1"},
        "benchmarks": [
            entry("copy/bytes/any/cache", cells=5e7, set_bytes=1.0),
            entry("copy/bytes/any/stream", cells=5e6, set_bytes=1.0),
            entry("multiply_add/float/avx2/cache", cells=1.0, operations=5e7, set_bytes=1.0),
        ],
    }
