"""Small valid procedures made at random end in frames that hold, or in a sentence; the daemon lives on.

LAPPET_FUZZ sets how many (200); the same ones every time. `lappet report stability --fuzz 5000` makes more. What fails
becomes a case of the stability matrix.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings

from lappet.daemon import SolverDaemon
from lappet.procedure import Procedure
from lappet.refused import RefusedError
from lappet.reports import stability_fuzz
from lappet.reports.stability_fuzz import PATIENT, fuzz, judge, procedures, told

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]
COUNT = int(os.environ.get("LAPPET_FUZZ", "200"))


@pytest.fixture
def running(binary: Path) -> Iterator[SolverDaemon]:
    with SolverDaemon(binary, arguments=PATIENT) as daemon:
        yield daemon


@settings(
    max_examples=COUNT,
    derandomize=True,
    deadline=None,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(procedure=procedures())
def test_a_procedure_ends_in_frames_that_hold_or_in_a_sentence(
    running: SolverDaemon, tmp_path: Path, procedure: Procedure
) -> None:
    running.start()
    verdict = judge(procedure, running, tmp_path)
    assert not verdict.wrong, f"{verdict.wrong}\n{told(procedure)}"


def test_many_of_the_procedures_are_solved_to_the_end(binary: Path) -> None:
    found = fuzz(40)
    assert found["procedures"] == 40
    assert found["solved"] >= 10
    assert found["solved"] + sum(found["refused"].values()) == 40
    assert not found["failures"]


def test_a_fault_and_a_false_claim_are_failures(
    running: SolverDaemon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lappet.solve import solve_procedure
    from small_procedure import small_procedure

    plain = small_procedure(end_time=2.0, events=())
    assert judge(plain, running, tmp_path) == stability_fuzz.Verdict()

    def looser(*arguments: object, **more: object) -> object:
        result = solve_procedure(*arguments, **more)  # type: ignore[arg-type]
        result.frames[-1].header["residual"] = 0.5
        return result

    def faulty(*arguments: object, **more: object) -> object:
        raise IndexError("index 7 is out of bounds")

    def budget(*arguments: object, **more: object) -> object:
        raise RefusedError("frame 2 ran out of its time budget of 20 s at relative residual 1.00e-02")

    for stand_in, says in ((looser, "residual of 5.00e-01"), (faulty, "IndexError"), (budget, "time budget")):
        monkeypatch.setattr(stability_fuzz, "solve_procedure", stand_in)
        assert says in judge(plain, running, tmp_path).wrong
