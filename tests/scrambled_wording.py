"""The fixture `wording`: a test that asks for it runs with the program's texts and with meaningless ones.

What another process reads of a procedure's file comes without texts, with codes; so a file is read once for both.
"""

from __future__ import annotations

import random
import string
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from lappet.core import problem_text
from lappet.core.problem_code import ProblemCode
from lappet.core.problem_text import ProblemText
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.usd import procedure_file


def scrambled(code: ProblemCode) -> ProblemText:
    """Return random words in place of the texts of a code, the same ones every time; its severity stays."""
    words = random.Random(str(code))

    def sentence() -> str:
        chosen = ["".join(words.choices(string.ascii_lowercase, k=words.randint(3, 9))) for _ in range(6)]
        return " ".join(chosen).capitalize() + "."

    return replace(problem_text.catalogue()[code], title=sentence(), message=sentence(), remedy=sentence())


class KeptReading(ReadingProcess):
    """A process that reads a file, or what one handed over that read the same file before."""

    _kept: ClassVar[dict[tuple[object, ...], bytes]] = {}

    def __init__(
        self, module: str, reader: str, file: Path, limits: ReadLimits = DEFAULT_LIMITS, option: str = ""
    ) -> None:
        written = file.stat().st_mtime_ns if file.exists() else 0
        self._key = (module, reader, file.absolute(), written, limits, option)
        if self._key not in self._kept:
            super().__init__(module, reader, file, limits, option)

    def close(self) -> None:
        if hasattr(self, "_process"):
            super().close()

    def _answer(self) -> bytes:
        if self._key not in self._kept:
            self._kept[self._key] = super()._answer()
        return self._kept[self._key]


@pytest.fixture(params=["as written", "scrambled"])
def wording(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run the test twice; what it asks for must not depend on how a message or remedy is worded."""
    monkeypatch.setattr(procedure_file, "ReadingProcess", KeptReading)
    if request.param == "scrambled":
        monkeypatch.setattr(problem_text, "text_of", scrambled)
    return str(request.param)
