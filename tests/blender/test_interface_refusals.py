"""One way to refuse: what an operator's logic raises is reported, kept as values, and named with what repairs it."""

from __future__ import annotations

from typing import Any

import pytest

from lappet.core.problem import RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet_blender.interface.operator_base import OperatorBase, last_refusal
from lappet_blender.interface.problem_repairs import repair_of
from lappet_blender.interface.problem_sentence import problem_sentence


class Operator(OperatorBase):
    """An operator whose reports are noted."""

    def __init__(self, work: Any) -> None:
        self.work, self.said = work, []

    def run(self, context: object) -> str | None:
        return self.work()

    def report(self, kind: set[str], text: str) -> None:
        self.said.append((*kind, text))


def test_what_is_done_is_said_and_no_refusal_is_left() -> None:
    operator = Operator(lambda: "Done.")
    assert operator.execute(None) == {"FINISHED"}
    assert operator.said == [("INFO", "Done.")]
    assert last_refusal() == ()


def test_what_is_refused_cancels_and_is_kept_with_its_code() -> None:
    def refuse() -> None:
        raise refused(ProblemCode.OBJECT_LOCAL, "nose")

    operator = Operator(refuse)
    assert operator.execute(None) == {"CANCELLED"}
    ((kind, text),) = operator.said
    assert kind == "ERROR"
    assert text == problem_sentence(last_refusal()[0])
    assert [(each.code, each.prim) for each in last_refusal()] == [(ProblemCode.OBJECT_LOCAL, "nose")]


def test_of_many_problems_three_are_said_and_all_are_kept() -> None:
    def refuse() -> None:
        raise RefusedError([problem(ProblemCode.OBJECT_LOCAL, str(number)) for number in range(5)])

    operator = Operator(refuse)
    operator.execute(None)
    ((_, text),) = operator.said
    assert text.endswith("(2 more.)")
    assert len(last_refusal()) == 5


def test_an_error_of_the_file_system_is_a_problem_too() -> None:
    def fail() -> None:
        raise PermissionError(13, "Permission denied", "/root/a.usda")

    Operator(fail).execute(None)
    (found,) = last_refusal()
    assert (found.code, found.prim, found.value) == (ProblemCode.FILE_ERROR, "/root/a.usda", "Permission denied")


def test_any_other_error_is_not_hidden() -> None:
    with pytest.raises(ZeroDivisionError):
        Operator(lambda: 1 / 0).execute(None)


def test_a_prim_is_named_by_its_own_name_and_a_name_is_not_said_twice() -> None:
    of_prim = problem(ProblemCode.SUTURE_OF_ONE_POINT, "/Procedure/Timeline/suture_1", "(0, 0, 0)", points="point")
    assert problem_sentence(of_prim).startswith("suture_1: ")
    of_stitch = problem(ProblemCode.SUTURE_TWICE, "/Procedure/Timeline/wound/skin/3", "(0, 0, 0)", other="suture_1")
    assert problem_sentence(of_stitch).startswith("wound/skin/3: ")
    assert problem_sentence(problem(ProblemCode.OBJECT_LOCAL, "nose")).count("nose") == 1


@pytest.mark.parametrize(
    ("code", "prim", "operator", "arguments"),
    [
        (ProblemCode.MESH_NO_AREA, "Tissue", "lappet.tissue_repair", {"kind": "WELD"}),
        (ProblemCode.MESH_NO_AREA, "/Procedure/Tissue", "lappet.tissue_repair", {"kind": "WELD"}),
        (ProblemCode.BONE_TWICE, "skull", "lappet.bone_remove", {"object": "skull"}),
        (ProblemCode.TISSUE_NONE, "", "lappet.tissue_set", {}),
    ],
)
def test_the_code_and_the_prim_decide_what_repairs_a_problem(
    code: ProblemCode, prim: str, operator: str, arguments: dict[str, str]
) -> None:
    found = repair_of(problem(code, prim, 1, count=1, where="there"))
    assert found is not None
    assert (found.operator, dict(found.arguments)) == (operator, arguments)


def test_what_is_wrong_with_a_bone_is_not_repaired_in_the_tissue() -> None:
    assert repair_of(problem(ProblemCode.MESH_NO_AREA, "/Procedure/Bone/skull", 1, count=1, where="there")) is None
    assert repair_of(problem(ProblemCode.EVENT_NONE_ACTIVE)) is None
