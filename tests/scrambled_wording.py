"""The fixture `wording`: a test that asks for it runs with the program's texts and with meaningless ones."""

from __future__ import annotations

import random
import string
from dataclasses import replace

import pytest

from lappet.core import problem_text
from lappet.core.problem_code import ProblemCode
from lappet.core.problem_text import ProblemText


def scrambled(code: ProblemCode) -> ProblemText:
    """Return random words in place of the texts of a code, the same ones every time; its severity stays."""
    words = random.Random(str(code))

    def sentence() -> str:
        chosen = ["".join(words.choices(string.ascii_lowercase, k=words.randint(3, 9))) for _ in range(6)]
        return " ".join(chosen).capitalize() + "."

    return replace(problem_text.catalogue()[code], title=sentence(), message=sentence(), remedy=sentence())


@pytest.fixture(params=["as written", "scrambled"])
def wording(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run the test twice; what it asks for must not depend on how a message or remedy is worded."""
    if request.param == "scrambled":
        monkeypatch.setattr(problem_text, "text_of", scrambled)
    return str(request.param)
