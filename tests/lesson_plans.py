"""Plans with a fault, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.core.problem import Problem, RefusedError
from lappet.lessons.plan_file import read_plan


def changed(folder: Path, old: str, new: str) -> Path:
    """The plan of a folder with another text in place of the first `old`."""
    text = (folder / "lesson.toml").read_text(encoding="utf-8")
    assert old in text
    path = folder / "plan.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def problems_of(path: Path) -> tuple[Problem, ...]:
    """What is wrong with a plan."""
    with pytest.raises(RefusedError) as refused:
        read_plan(path)
    return refused.value.problems
