from __future__ import annotations

from pathlib import Path

import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.models import body_package
from lappet.models.new_model import new_model


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(body_package.FOLDER_VARIABLE, str(tmp_path))
    return tmp_path


def test_a_body_model_without_the_package_is_refused_with_the_command_that_fetches_it(folder: Path) -> None:
    with pytest.raises(RefusedError) as refused:
        new_model("nose")
    (problem,) = refused.value.problems
    assert problem.code == ProblemCode.MODELS_NOT_FETCHED
    assert "lappet models fetch" in problem.remedy
    assert str(folder) in problem.message


def test_a_patch_and_a_dome_need_no_package(folder: Path) -> None:
    assert new_model("patch").tissue.spacing == new_model("dome").tissue.spacing == 1.0


def test_another_file_of_the_same_size_is_refused(folder: Path) -> None:
    with (folder / body_package.WHEEL).open("wb") as file:
        file.truncate(body_package.SIZE)
    with pytest.raises(RefusedError) as refused:
        body_package.body_package()
    assert refused.value.problems[0].code == ProblemCode.MODELS_OTHER_FILE


def test_what_is_there_is_not_fetched_again(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("pip was started")

    monkeypatch.setattr(body_package.subprocess, "run", forbidden)
    assert body_package.fetch() == body_package.body_package()
