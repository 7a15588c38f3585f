"""The base of Lappet's operators: logic refuses by raising RefusedError, and `OperatorBase` reports it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import bpy

from lappet.core.problem import Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode

from ..model.changes import changed
from .problem_sentence import problem_sentence

NO_UNDO = {"REGISTER"}
_MAX_SAID = 3  # problems that one report names
_refused: list[Problem] = []


def last_refusal() -> tuple[Problem, ...]:
    """Return why the last operator of Lappet refused, () where it did not: `bpy.ops` passes only text to Python."""
    return tuple(_refused)


class OperatorBase:
    """Mixin of an operator. `run` does the work, or raises RefusedError before it has changed anything.

    An operator is called after its class: `LAPPET_OT_hook_add` is `lappet.hook_add`. It can be undone unless it says
    that it is `NO_UNDO`.

    edits_procedure: listeners learn after `run` that the scene's procedure may have changed.
    """

    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}
    edits_procedure: ClassVar[bool] = False
    bl_idname: ClassVar[str]
    report: Any
    properties: Any

    def __init_subclass__(cls) -> None:
        """Name the operator."""
        super().__init_subclass__()
        cls.bl_idname = f"lappet.{cls.__name__.removeprefix('LAPPET_OT_')}"

    def run(self, context: bpy.types.Context) -> str | None:
        """Do the work; a sentence that it returns is shown to the user."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Blender's entry."""
        if not self.attempt(lambda: self.run(context)):
            return {"CANCELLED"}
        if self.edits_procedure:
            changed(context.scene)
        return {"FINISHED"}

    def attempt(self, work: Callable[[], str | None]) -> bool:
        """Do a piece of work and show the sentence that it returns; report a refusal and return False."""
        _refused.clear()
        try:
            done = work()
        except RefusedError as refused:
            self.refuse(*refused.problems)
            return False
        except OSError as error:
            self.refuse(problem(ProblemCode.FILE_ERROR, error.filename or "", error.strerror or str(error)))
            return False
        if done:
            self.report({"INFO"}, done)
        return True

    def refuse(self, *problems: Problem) -> set[str]:
        """Report why nothing is done, and cancel."""
        _refused[:] = problems
        more = len(problems) - _MAX_SAID
        tail = [f"({more} more.)"] if more > 0 else []
        self.report({"ERROR"}, " ".join([*map(problem_sentence, problems[:_MAX_SAID]), *tail]))
        return {"CANCELLED"}
