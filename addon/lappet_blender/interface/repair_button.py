"""The button that repairs a problem."""

from __future__ import annotations

import bpy

from lappet.core.problem import Problem

from .problem_repairs import repair_of


def draw_repair(layout: bpy.types.UILayout, found: Problem) -> bool:
    """Draw the button of the operator that repairs a problem; False where there is none."""
    repair = repair_of(found)
    if repair is None:
        return False
    button = layout.operator(repair.operator, icon="MODIFIER", **({"text": repair.label} if repair.label else {}))
    for name, value in repair.arguments:
        setattr(button, name, value)
    return True
