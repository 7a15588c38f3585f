"""Small valid procedures made at random end in frames that hold, or in a sentence; the daemon lives on.

LAPPET_FUZZ sets how many (200); the same ones every time. `lappet report stability --fuzz 5000` makes more. What fails
becomes a case of the stability matrix.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.process import SolverDaemon
from lappet.reports.stability import fuzz as stability_fuzz
from lappet.reports.stability.fuzz import PATIENT, fuzz, judge

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]
COUNT = int(os.environ.get("LAPPET_FUZZ", "200"))


@pytest.fixture
def running(binary: Path) -> Iterator[SolverDaemon]:
    with SolverDaemon(binary, arguments=PATIENT) as daemon:
        yield daemon


def test_procedures_end_in_frames_that_hold_or_in_a_sentence(binary: Path) -> None:
    found = fuzz(COUNT)
    assert not found["failures"], "\n\n".join(f"{each['wrong']}\n{each['procedure']}" for each in found["failures"])
    assert found["procedures"] == COUNT
    assert found["solved"] + sum(found["refused"].values()) == COUNT
    assert found["solved"] >= COUNT / 4


def test_a_fault_and_a_false_claim_are_failures(
    running: SolverDaemon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lappet.output.solve_to_cache import solve_procedure
    from small_procedure import small_procedure

    plain = small_procedure(end_time=2.0, events=())
    assert judge(plain, running, tmp_path) == stability_fuzz.Verdict()

    def looser(*arguments: object, **more: object) -> object:
        result = solve_procedure(*arguments, **more)  # type: ignore[arg-type]
        last = result.frames[-1]
        off = replace(last.solved, diagnostics=replace(last.solved.diagnostics, residual=0.5))
        return replace(result, frames=(*result.frames[:-1], replace(last, solved=off)))

    def faulty(*arguments: object, **more: object) -> object:
        raise IndexError("index 7 is out of bounds")

    def budget(*arguments: object, **more: object) -> object:
        raise refused(ProblemCode.SOLVER_TIME_BUDGET, "Frame 2", "It ran out of its time budget.")

    for stand_in, says in ((looser, "residual of 5.00e-01"), (faulty, "IndexError"), (budget, "Frame 2")):
        monkeypatch.setattr(stability_fuzz, "solve_procedure", stand_in)
        assert says in judge(plain, running, tmp_path).wrong
