"""The stability report: its files, that a false expectation or a false claim shows, and its exit status."""

from __future__ import annotations

import csv
import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.reports.stability import run as stability_run
from lappet.reports.stability.case import Case, Demand, Row, Scene, totals
from lappet.reports.stability.files import write_stability
from lappet.reports.stability.measurement import _disproved as disproved
from lappet.reports.stability.measurement import run_case
from lappet.reports.stability.run import all_cases, chosen_cases
from lappet.reports.stability.scenes import material, stretched
from lappet.reports.stability.starts import STARTS, as_from_rest
from refusals import refuses

SETTLES = Case("a bar", "cheap", lambda: stretched(1.2))
REFUSES = Case(
    "a bar of what is no skin",
    "cheap",
    lambda: stretched(1.2, materials=(material(poissons_ratio=0.6),)),
    ProblemCode.SOLVER_INVALID_INPUT,
)
ROOT = Path(__file__).resolve().parents[2]


def test_there_are_at_least_sixty_cases_with_names_of_their_own() -> None:
    cases = all_cases()
    assert len(cases) >= 60
    assert len({(case.group, case.name) for case in cases}) == len(cases)
    assert all(isinstance(case.demands, Demand | ProblemCode) for case in cases)  # one outcome each
    assert {"poisson", "buckling", "contrast", "fibers", "starts", "floating", "bone", "scale", "cuts"} <= {
        c.group for c in cases
    }


def test_the_slow_cases_are_left_out_where_it_is_to_be_quick() -> None:
    assert any(case.slow for case in chosen_cases(("spacing",), quick=False))
    assert not any(case.slow for case in chosen_cases(("spacing",), quick=True))
    with refuses(ProblemCode.REPORT_UNKNOWN):
        chosen_cases(("spacings",), quick=False)


@pytest.mark.slow
def test_what_is_expected_is_ok_and_what_is_not_is_not(binary: Path) -> None:
    row = run_case(SETTLES)
    assert (row.ok, row.outcome, row.reason) == (True, "converges", "")
    assert row.residual is not None
    assert row.verified_residual == pytest.approx(row.residual, rel=0.05)
    refused = run_case(REFUSES)
    assert (refused.ok, refused.outcome) == (True, "refuses")
    assert "Poisson's ratio" in refused.reason
    demands = (ProblemCode.SOLVER_INVALID_INPUT, Demand.BUCKLES, Demand.IS_SENSITIVE)
    assert not any(run_case(replace(SETTLES, demands=each)).ok for each in demands)
    assert not run_case(replace(REFUSES, demands=Demand.CONVERGES)).ok
    assert not run_case(replace(REFUSES, demands=ProblemCode.SOLVER_MEMORY_BUDGET)).ok
    assert not run_case(replace(SETTLES, budget=1e-3)).ok


@pytest.mark.slow
def test_a_check_that_fails_is_a_wrong_claim(binary: Path) -> None:
    case = Case("a bar", "cheap", lambda: Scene(stretched(1.2), check=lambda solved: "It is not a bar."))
    row = run_case(case)
    assert (row.ok, row.outcome, row.reason) == (False, "wrong", "It is not a bar.")


@pytest.mark.slow
def test_an_exception_in_a_case_is_a_crash_and_ends_nothing(binary: Path) -> None:
    def scene() -> Scene:
        raise KeyError("a fault of ours")

    row = run_case(Case("a fault", "cheap", scene, ProblemCode.INTERNAL))
    assert (row.ok, row.outcome) == (False, "crashes")
    assert "KeyError" in row.reason


@pytest.mark.slow
def test_a_mirrored_start_ends_where_rest_does_and_a_shifted_twin_is_noticed(binary: Path) -> None:
    def scene(share: float, factor: float) -> Scene:
        program = stretched(1.3, tolerance=1e-4)
        twin = stretched(factor, tolerance=1e-4)
        return Scene(program, STARTS["mirrored"], as_from_rest(share), twin)

    assert run_case(Case("as from rest", "cheap", lambda: scene(0.02, 1.3))).ok
    row = run_case(Case("not as from rest", "cheap", lambda: scene(0.02, 1.31)))
    assert (row.ok, row.outcome) == (False, "wrong")
    assert "another equilibrium" in row.reason


def solution(**changes: float) -> SolvedFrame:
    said = {"converged": True, "residual": 1e-4, "largest_gap": 1e-4, "energy": 1.0, **changes}
    none = np.zeros((0, 3))
    state = SolverState("float", none, np.full((1, 3), np.nan), none, np.zeros(0), np.zeros(1))
    return SolvedFrame(1.0, np.zeros((2, 3), np.float32), diagnostics=Diagnostics(**said), state=state)  # type: ignore[arg-type]


HARD = (
    "bar of 200 x 1 x 1 cells, stretched to twice its length",
    "bar one cell wide, pressed to 80 %",
    "corotated bar pressed to 80 % in 1",
    "corotated bar to 20 %, which buckles, in 8",
    "excision of a wedge with a tip of 4°",
    "suture between two held sides",
    "suture between what retractors pull apart",
)


@pytest.mark.parametrize("name", HARD)
def test_a_case_that_asks_much_of_the_solver_ends_as_physics_asks(name: str, binary: Path) -> None:
    (case,) = (each for each in all_cases() if each.name == name)
    row = run_case(case)
    assert row.ok, row.reason


def test_a_claim_of_convergence_is_held_against_its_own_numbers() -> None:
    program = stretched(1.2)
    assert disproved(solution(), program) == ""
    assert "residual of 2.00e-03" in disproved(solution(residual=2e-3), program)
    assert "residual of nan" in disproved(solution(residual=np.nan), program)
    assert "gap of 0.5 mm" in disproved(solution(largest_gap=0.5), program)
    assert "0.7 mm deep in bone" in disproved(solution(largest_penetration=0.7), program)
    assert "energy" in disproved(solution(energy=np.inf), program)
    assert "is unstable" in disproved(solution(lowest_stiffness=-0.2), program)
    assert disproved(solution(lowest_stiffness=0.01), program) == ""
    lost = solution(converged=False, residual=np.inf)
    assert disproved(lost, program) == ""
    lost.points[0, 0] = np.nan
    assert "'points'" in disproved(lost, program)


ROWS = (
    Row("one", "a", "buckles", "buckles", "", 1e-4, 0.3, 1e-4, 0.0, 1, 10, 0.5, 60.0, True),
    Row("two", "a", "refuses: thin", "refuses", "too thin", None, None, None, None, 0, 0, 0.5, 60.0, True),
    Row("three", "b", "converges", "crashes", "ended by SIGSEGV", None, None, None, None, 0, 0, 0.5, 60.0, False),
)


def test_the_files_hold_every_row_and_the_totals(tmp_path: Path) -> None:
    head = {"machine": {"processor": "a", "cores": 1, "memory_bytes": 1 << 30}, "compiler": "c", "isa": "scalar",
            "threads": 1, "revision": "r", "date": "d"}  # fmt: skip
    files = write_stability(tmp_path, head, ROWS)
    assert [file.name for file in files] == ["stability.json", "stability.csv", "stability.md"]
    values = json.loads(files[0].read_text())
    assert {"machine", "compiler", "isa", "threads", "revision", "rows", "totals"} <= set(values)
    wanted = {"case", "group", "expected", "outcome", "reason", "residual", "gap_mm", "seconds", "ok"}
    assert wanted <= set(values["rows"][0])
    assert [row["ok"] for row in values["rows"]] == [True, True, False]
    assert values["totals"]["all"] == {"cases": 3, "ok": 2, "converged": 1, "buckled": 1, "refused": 1}
    assert totals(ROWS)["b"] == {"cases": 1, "ok": 0, "converged": 0, "buckled": 0, "refused": 0}
    with files[1].open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [set(line) for line in lines] == [{field.name for field in fields(Row)}] * 3
    text = files[2].read_text()
    assert "**three**: crashes. ended by SIGSEGV" in text
    assert "| all | 3 | 2 | 1 | 1 | 1 |" in text


def test_the_kept_report_has_every_case_and_the_readme_its_totals() -> None:
    kept = (ROOT / "docs" / "stability.md").read_text(encoding="utf-8")
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in kept.splitlines() if line.startswith("| ")
    ]
    listed = {row[0]: row[1] for row in rows if ": " in row[0]}
    assert listed == {f"{case.group}: {case.name}": case.expected for case in chosen_cases((), quick=True)}
    (total,) = [row for row in rows if row[0] == "all"]
    cases, ok, converged, buckled, refused = (int(cell) for cell in total[1:])
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"{ok} of {cases} stiff and extreme cases end as demanded" in readme
    # What is refused and should converge is not refused for the right reason.
    demanded = ok - converged
    assert refused - demanded == cases - ok
    assert (
        f"{converged} converge, {buckled} of them by buckling, and {demanded} are refused for the right reason"
        in readme
    )


@pytest.mark.slow
def test_the_command_ends_with_1_where_a_case_is_not_ok(
    binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stability_run, "all_cases", lambda: [SETTLES, REFUSES])
    run = CliRunner().invoke(cli, ["report", "stability", "-o", str(tmp_path / "good")])
    assert run.exit_code == 0, run.output
    assert "| all | 2 | 2 | 1 | 0 | 1 |" in run.output
    assert (tmp_path / "good" / "stability.json").is_file()
    monkeypatch.setattr(stability_run, "all_cases", lambda: [replace(SETTLES, demands=ProblemCode.INTERNAL)])
    run = CliRunner().invoke(cli, ["report", "stability", "-o", str(tmp_path / "bad")])
    assert run.exit_code == 1
    assert "NOT a bar: converges" in run.output
