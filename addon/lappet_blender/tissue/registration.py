"""Register the operators, panels, overlay and handlers of this part."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..model import tissue_size, tissue_values
from . import (
    bone_operators,
    check_operator,
    group_operators,
    material_operators,
    material_panel,
    model_operators,
    overlay,
    repair_operators,
    skin_line_operators,
    tissue_check,
    tissue_operators,
    tissue_panel,
    vessel_operators,
)

CLASSES = (
    *tissue_operators.CLASSES,
    *group_operators.CLASSES,
    *bone_operators.CLASSES,
    *material_operators.CLASSES,
    *skin_line_operators.CLASSES,
    *model_operators.CLASSES,
    *vessel_operators.CLASSES,
    *repair_operators.CLASSES,
    *check_operator.CLASSES,
    *tissue_panel.CLASSES,
    *material_panel.CLASSES,
)


@persistent  # type: ignore[untyped-decorator]
def _on_load_pre(*_: object) -> None:
    """What is kept of the file before is of no use any more."""
    for module in (tissue_values, tissue_check, tissue_size):
        module.clear_cache()


def register() -> None:
    """Add them."""
    overlay.register()
    bpy.app.handlers.load_pre.append(_on_load_pre)


def unregister() -> None:
    """Take them away."""
    if _on_load_pre in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_on_load_pre)
    overlay.unregister()
