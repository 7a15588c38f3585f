"""Exactly what is broken in each file of the corpus `broken_inputs` is found, however it is worded."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from broken_inputs import CASES, CORPUS, answers, broken_input, expected_problems, found_problems
from lappet.checks.validation import check
from lappet.core.problem import RefusedError
from lappet.usd.stage import read_procedure
from scrambled_wording import wording  # noqa: F401  (a fixture)


def test_the_corpus_is_found() -> None:
    assert len(CASES) > 50
    inputs = {file.stem for file in CORPUS.iterdir() if file.suffix != ".expected"}
    assert inputs <= {case.stem for case in CASES}


@pytest.mark.usefixtures("wording")
@pytest.mark.parametrize("expected", CASES, ids=lambda path: path.stem)
def test_exactly_what_is_broken_is_found(expected: Path) -> None:
    problems = found_problems(broken_input(expected))
    said = "\n".join(f"{each.severity} {each.code}: {each}" for each in problems)
    unanswered = list(problems)
    for block in expected_problems(expected):
        match = next((each for each in unanswered if answers(each, block)), None)
        assert match is not None, f"expected {block}, but was told:\n{said}"
        unanswered.remove(match)
    assert not unanswered, "also told: " + "; ".join(map(str, unanswered))


@pytest.mark.usefixtures("wording")
@pytest.mark.parametrize("expected", CASES, ids=lambda path: path.stem)
def test_what_is_broken_is_refused_before_solving(expected: Path) -> None:
    errors = [block for block in expected_problems(expected) if block["severity"] == "error"]
    try:
        problems = check(read_procedure(broken_input(expected)))
    except RefusedError as error:
        problems = list(error.problems)
        assert problems
    assert any(each.severity == "error" for each in problems) == bool(errors)


@pytest.mark.parametrize("expected", CASES, ids=lambda path: path.stem)
def test_what_is_broken_is_said_in_sentences_with_its_remedy(expected: Path) -> None:
    unsaid = found_problems(broken_input(expected))
    for block in expected_problems(expected):
        told = [each for each in unsaid if answers(each, block)]
        match = next((each for each in told if block["says"] in each.message and block["remedy"] in each.remedy), None)
        assert match is not None, f"expected {block}, but was told:\n" + "\n".join(map(str, told))
        unsaid.remove(match)
        assert re.match(r"[A-Z0-9]|lappet:|primvars:|curveVertexCounts", match.message), match
        assert match.message.endswith("."), match
        assert match.remedy[0].isupper(), match
        assert match.remedy.endswith("."), match
        assert "\n" not in str(match), match
