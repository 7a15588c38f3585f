"""What a test expects to be refused: by its code, and where it matters its prim, never by its wording."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from lappet.core.problem import Problem, ProblemsError
from lappet.core.problem_code import ProblemCode


@contextmanager
def refuses(code: ProblemCode, prim: str | None = None) -> Iterator[list[Problem]]:
    """Expect a refusal with this code, of this prim; the list holds its problems afterwards."""
    problems: list[Problem] = []
    with pytest.raises(ProblemsError) as caught:
        yield problems
    problems += caught.value.problems
    assert code in [each.code for each in problems], (
        f"refused with {[str(each.code) for each in problems]}: {caught.value}"
    )
    if prim is not None:
        assert prim in [each.prim for each in problems if each.code is code], str(caught.value)
