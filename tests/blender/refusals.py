"""Why an operator refused, as values: tests compare codes, never sentences."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import pytest

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet_blender.interface.operator_base import last_refusal


def refusal(act: Callable[[], object]) -> Problem:
    """The first reason for which an operator refuses; the report is text, without a traceback."""
    with pytest.raises(RuntimeError) as caught:
        act()
    said = str(caught.value)
    assert said.startswith("Error: ")
    assert "Traceback" not in said
    return last_refusal()[0]


def refusal_code(act: Callable[[], object]) -> ProblemCode:
    """The code of the first reason for which an operator refuses; the scene's events stay as they were."""
    scene = bpy.context.scene
    before = [(event.uid, event.start, event.end, len(event.points)) for event in scene.lappet.events]
    objects = len(bpy.data.objects)
    code = refusal(act).code
    after = [(event.uid, event.start, event.end, len(event.points)) for event in scene.lappet.events]
    assert (before, objects) == (after, len(bpy.data.objects)), "a refused operator changed the scene"
    return code
