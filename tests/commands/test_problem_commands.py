"""What the command line does with problems does not depend on their wording: exit statuses, prims, severities."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from broken_inputs import CASES, broken_input, expected_problems
from lappet.commands.cli import cli
from lappet.commands.refusals import problems_of
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook
from lappet.usd.stage import write_procedure
from scrambled_wording import wording  # noqa: F401  (a fixture)
from small_procedure import EXCISED, TOP, small_procedure

pytestmark = pytest.mark.usefixtures("wording")


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(each) for each in arguments])


@pytest.mark.parametrize("expected", CASES, ids=lambda path: path.stem)
def test_check_names_the_prim_and_severity_of_each_problem(expected: Path) -> None:
    blocks = expected_problems(expected)
    done = run("check", broken_input(expected))
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line]
    # Cutting the tissue may find more than the corpus, which nothing is cut for.
    refused = done.stderr or any(line.startswith("error: ") for line in lines)
    assert done.exit_code == int(bool(refused))
    assert refused or not any(block["severity"] == "error" for block in blocks)
    for block in blocks:
        match = next((line for line in lines if block["prim"] in line), None)
        assert match is not None, f"{block['prim']} is not named in {lines}"
        lines.remove(match)
        if match.startswith(("error: ", "warning: ")):
            assert match.startswith(f"{block['severity']}: ")


def test_a_wrong_procedure_is_refused_by_solve_with_its_prim(tmp_path: Path) -> None:
    hook = Hook("late", (1.0, 0.5, TOP), ((1.0, (1.0, 0.5, TOP)),), 1.0, 8.0)
    write_procedure(small_procedure(events=(*EXCISED, hook)), tmp_path / "p.usda")
    for command in ("check", "solve"):
        done = run(command, tmp_path / "p.usda")
        assert done.exit_code == 1
        assert "/Procedure/Timeline/late: " in done.stdout + done.stderr


@pytest.mark.parametrize("output", ["c.png", "folder.usdc", "file/c.usdc", "p.usda"])
def test_a_cache_that_cannot_be_written_is_refused_with_its_path(tmp_path: Path, output: str) -> None:
    write_procedure(small_procedure(), tmp_path / "p.usda")
    (tmp_path / "folder.usdc").mkdir()
    (tmp_path / "file").write_text("in the way")
    done = run("solve", tmp_path / "p.usda", "-o", tmp_path / output)
    assert done.exit_code == 1
    assert done.stderr.startswith(f"{tmp_path / output}: ")
    assert len(done.stderr.splitlines()) == 1


def test_errors_of_the_system_and_our_own_get_codes() -> None:
    (full,) = problems_of(OSError(28, "No space left on device", "cache.usdc"))
    assert (full.code, full.prim, full.value) == (ProblemCode.FILE_ERROR, "cache.usdc", "No space left on device")
    (own,) = problems_of(ZeroDivisionError("division by zero"))
    assert (own.code, own.value) == (ProblemCode.INTERNAL, "ZeroDivisionError: division by zero")
