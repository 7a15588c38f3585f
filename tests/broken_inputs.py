"""The corpus `checks/broken_inputs`: what is broken in each file, and what must be found in it.

Beside each file stands `<name>.expected`: a block of lines `prim:`, `code:`, `severity:` where it is not error, and the
fragments `says:` and `remedy:` of its texts, for each problem. A case without an input file is a file that does not
exist. Add a file here for every input that once crashed something.
"""

from __future__ import annotations

from pathlib import Path

from lappet.checks.validation import check_read
from lappet.core.problem import Problem, RefusedError
from lappet.usd.stage import read_here

CORPUS = Path(__file__).with_name("checks") / "broken_inputs"
CASES = sorted(CORPUS.glob("*.expected"))


def broken_input(expected: Path) -> Path:
    """Return the file of a case; it need not exist."""
    found = [file for file in CORPUS.glob(f"{expected.stem}.*") if file != expected]
    assert len(found) <= 1, f"{expected.stem} has several input files"
    return found[0] if found else expected.with_suffix(".usda")


def expected_problems(expected: Path) -> list[dict[str, str]]:
    """Return the blocks of a case, with the severity of each."""
    blocks = []
    for text in expected.read_text(encoding="utf-8").split("\n\n"):
        block = dict(line.split(": ", 1) for line in text.strip().splitlines())
        assert {"prim", "code", "says", "remedy"} <= set(block) <= {"prim", "code", "says", "remedy", "severity"}, text
        assert all(block.values()), text
        blocks.append({"severity": "error", **block})
    return blocks


def found_problems(file: Path) -> list[Problem]:
    """Return what is found in a file, opened or not."""
    try:
        return check_read(read_here(file))
    except RefusedError as error:
        return list(error.problems)


def answers(problem: Problem, block: dict[str, str]) -> bool:
    """Whether a problem is that of a block, whatever its wording."""
    return (
        problem.code == block["code"] and problem.severity == block["severity"] and problem.prim.endswith(block["prim"])
    )
