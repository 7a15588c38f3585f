"""Every code has its texts, its place in the code and its entry in docs/problems.md."""

from __future__ import annotations

import ast
import copy
import pickle
import string
from collections.abc import Iterator
from pathlib import Path

import pytest

import problem_page
from lappet.core.array_codec import CodecError
from lappet.core.problem import Place, Problem, ProblemsError, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.core.problem_text import catalogue
from lappet.core.value_codec import pack, unpack
from lappet.daemon.frame_solver import FrameRefusedError
from lappet.daemon.process import DaemonDied, DaemonMissing
from lappet.daemon.wire import WireError
from lappet.usd.stage import UsdMissingError

ROOT = Path(__file__).resolve().parents[2]
SOURCES = [file for folder in ("shared", "addon") for file in sorted((ROOT / folder).rglob("*.py"))]
OWN_FIELDS = {"code", "prim", "value", "place", "operator", "arguments"}
MAKERS = {"problem", "refused", "of"}


def fields(template: str) -> set[str]:
    """The names in braces of a template."""
    return {name for _, name, _, _ in string.Formatter().parse(template) if name}


def raised() -> set[str]:
    """The names of all codes that the sources mention outside the enum itself."""
    found = set()
    for file in SOURCES:
        if file.name == "problem_code.py":
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "ProblemCode":
                found.add(node.attr)
    return found


def calls() -> Iterator[tuple[str, ast.Call, ProblemCode]]:
    """Each call that makes a problem of a code that it names itself, with all its fields."""
    for file in SOURCES:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Attribute)):
                continue
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            code = node.args[0]
            named = isinstance(code.value, ast.Name) and code.value.id == "ProblemCode"
            if named and name in MAKERS and all(each.arg is not None for each in node.keywords):
                yield f"{file.relative_to(ROOT)}:{node.lineno}", node, ProblemCode[code.attr]


def test_every_code_has_its_texts_and_no_text_is_without_a_code() -> None:
    assert set(catalogue()) == set(ProblemCode)


def test_every_code_is_used_somewhere() -> None:
    assert {code.name for code in ProblemCode} - raised() == set()


def test_a_code_is_its_name_in_lower_case() -> None:
    assert all(code == code.name.lower().replace("_", "-") for code in ProblemCode)


def test_each_place_that_names_a_code_gives_the_fields_of_its_texts() -> None:
    seen = 0
    for where, call, code in calls():
        text = catalogue()[code]
        needed = (fields(text.message) | fields(text.remedy)) - {"prim", "value"}
        given = {each.arg for each in call.keywords if each.arg is not None} - OWN_FIELDS
        assert needed == given, f"{where}: {code} needs {sorted(needed)} and gets {sorted(given)}"
        seen += 1
    assert seen > 120


@pytest.mark.parametrize("code", list(ProblemCode), ids=str)
def test_texts_are_sentences_and_say_what_to_do(code: ProblemCode) -> None:
    text = catalogue()[code]
    assert text.title
    assert not text.title.endswith(".")
    assert text.message.endswith((".", "}")), text.message
    assert (
        text.message[0].isupper()
        or text.message[0] == "{"
        or text.message.startswith(("curveVertexCounts", "primvars:st"))
    )
    assert text.remedy or text.advice, "say what to do"
    for remedy in filter(None, (text.remedy, text.advice)):
        assert remedy.endswith("."), remedy
        assert remedy[0].isupper() or remedy[0] == "{", remedy
    assert text.severity in ("error", "warning", "note")


def test_the_page_of_problems_is_up_to_date() -> None:
    assert (ROOT / problem_page.PAGE).read_text(encoding="utf-8") == problem_page.problem_page(), "run `make docs`"


def test_the_page_lists_every_code_by_code_and_by_message() -> None:
    by_message, _, by_code = problem_page.problem_page().partition("## By code")
    for code in ProblemCode:
        assert by_code.count(f"\n### {code}\n") == 1
        assert by_message.count(f"](#{code}) |") == 1


def test_the_text_of_an_error_is_made_of_its_problems() -> None:
    error = RefusedError([problem(ProblemCode.MESH_NO_FACE, "/a"), problem(ProblemCode.CURVE_COUNT, "/b", 3, points=4)])
    first, second = str(error).splitlines()
    assert first.startswith("/a: The mesh has no face")
    assert second == "/b: curveVertexCounts is 3, but the curve has 4 points. Set curveVertexCounts to [4]."
    assert [each.code for each in error.problems] == [ProblemCode.MESH_NO_FACE, ProblemCode.CURVE_COUNT]
    assert [each.value for each in error.problems] == ["", "3"]


class Whatever:
    """A field of any kind."""

    def __format__(self, how: str) -> str:
        return "1"

    def __repr__(self) -> str:
        return "1"


@pytest.mark.parametrize("code", list(ProblemCode), ids=str)
def test_where_it_is_is_said_before_the_sentence_unless_the_sentence_says_it(code: ProblemCode) -> None:
    text = catalogue()[code]
    others = dict.fromkeys((fields(text.message) | fields(text.remedy)) - {"prim", "value"}, Whatever())
    made = problem(code, "/here/it.is", Whatever(), **others)
    said = f"{made.message} {made.remedy}".strip()
    assert "/here/it.is" in str(made)
    assert str(made) == (said if "/here/it.is" in made.message else f"/here/it.is: {said}")


@pytest.mark.parametrize(
    "kind", [RefusedError, FrameRefusedError, DaemonMissing, DaemonDied, WireError, CodecError, UsdMissingError]
)
def test_errors_can_be_pickled_with_their_problems(kind: type[ProblemsError]) -> None:
    error = kind.of(
        ProblemCode.MESH_OPEN, "/Procedure/Tissue", 4, place=Place((1,), ((0.0, 1.0, 2.0),)), count=4, where="there"
    )
    for again in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(again) is kind
        assert again.problems == error.problems
        assert str(again) == str(error)


def test_problems_go_through_the_worker_s_pipe() -> None:
    place = Place((3, 4), ((0.5, 1.0, -2.0),))
    found = refused(ProblemCode.MESH_OPEN, "/Procedure/Tissue", 4, place=place, count=4, where="there").problems[0]
    back = unpack(pack(found), type(found))
    assert isinstance(back, Problem)
    assert back == found
    assert back.code is ProblemCode.MESH_OPEN
