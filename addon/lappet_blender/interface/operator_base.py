"""The base of Lappet's operators: logic refuses by raising RefusedError, and `OperatorBase` reports it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import bpy

from lappet.core.problem import RefusedError

from ..model.changes import changed

UNDOABLE = {"REGISTER", "UNDO"}
NO_UNDO = {"REGISTER"}


class OperatorBase:
    """Mixin of an operator. `run` does the work, or raises RefusedError before it has changed anything.

    edits_procedure: listeners learn after `run` that the scene's procedure may have changed.
    """

    edits_procedure: ClassVar[bool] = False
    report: Any
    properties: Any

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
        try:
            done = work()
        except RefusedError as refused:
            self.report({"ERROR"}, str(refused))
            return False
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            said = (error.strerror or str(error)).rstrip(".")
            self.report({"ERROR"}, f"{where}{said}; choose another folder or file.")
            return False
        if done:
            self.report({"INFO"}, done)
        return True
