"""The corpus `broken_inputs`: what is broken in each file, and what must be said about it.

Beside each file stands `<name>.expected`: a block of lines `prim:`, `says:`, `remedy:` (fragments), and `severity:`
where it is not error, for each problem. Exactly these problems must be reported, no more, no fewer. A case without an
input file is a file that does not exist. Add a file here for every input that once crashed something.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from lappet.checks.validation import check, check_file
from lappet.core.problem import Problem, RefusedError
from lappet.usd.stage import read_procedure

CORPUS = Path(__file__).with_name("broken_inputs")
CASES = sorted(CORPUS.glob("*.expected"))


def _input(expected: Path) -> Path:
    found = [file for file in CORPUS.glob(f"{expected.stem}.*") if file != expected]
    assert len(found) <= 1, f"{expected.stem} has several input files"
    return found[0] if found else expected.with_suffix(".usda")


def _blocks(expected: Path) -> list[dict[str, str]]:
    blocks = []
    for text in expected.read_text(encoding="utf-8").split("\n\n"):
        block = dict(line.split(": ", 1) for line in text.strip().splitlines())
        assert {"prim", "says", "remedy"} <= set(block) <= {"prim", "says", "remedy", "severity"}, text
        assert all(block.values()), text
        blocks.append(block)
    return blocks


def _answers(problem: Problem, block: dict[str, str]) -> bool:
    return (
        problem.prim.endswith(block["prim"])
        and block["says"] in problem.message
        and block["remedy"] in problem.remedy
        and problem.severity == block.get("severity", "error")
    )


def _problems(file: Path) -> list[Problem]:
    try:
        return check_file(file)
    except RefusedError as error:
        return list(error.problems)


def test_the_corpus_is_found() -> None:
    assert len(CASES) > 50
    inputs = {file.stem for file in CORPUS.iterdir() if file.suffix != ".expected"}
    assert inputs <= {case.stem for case in CASES}


@pytest.mark.parametrize("expected", CASES, ids=lambda path: path.stem)
def test_exactly_what_is_broken_is_said_with_its_repair(expected: Path) -> None:
    problems, blocks = _problems(_input(expected)), _blocks(expected)
    said = "\n".join(f"{problem.severity}: {problem}" for problem in problems)
    unanswered = list(problems)
    for block in blocks:
        match = next((problem for problem in unanswered if _answers(problem, block)), None)
        assert match is not None, f"expected {block}, but was told:\n{said}"
        unanswered.remove(match)
    assert not unanswered, "also told: " + "; ".join(map(str, unanswered))
    for problem in problems:
        assert re.match(r"[A-Z0-9]|lappet:|primvars:|curveVertexCounts", problem.message), said
        assert problem.message.endswith("."), said
        assert problem.remedy[0].isupper(), said
        assert problem.remedy.endswith("."), said
        assert "\n" not in str(problem), said


@pytest.mark.parametrize("expected", CASES, ids=lambda path: path.stem)
def test_what_is_broken_is_refused_before_solving(expected: Path) -> None:
    errors = [block for block in _blocks(expected) if block.get("severity", "error") == "error"]
    try:
        problems = check(read_procedure(_input(expected)))
    except RefusedError as error:
        problems = list(error.problems)
        assert problems
    assert any(problem.severity == "error" for problem in problems) == bool(errors)
