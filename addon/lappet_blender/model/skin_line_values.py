"""Lines of the skin: between the scene's property groups and the procedure's values."""

from __future__ import annotations

import bpy

from lappet.procedure import SkinLine

from .decimals import decimal, decimals
from .event_kinds import BASIS_OF

_BASIS_NAMES = {basis: name for name, basis in BASIS_OF.items()}


def skin_line_values(scene: bpy.types.Scene) -> tuple[SkinLine, ...]:
    """The scene's skin lines in their order."""
    return tuple(
        SkinLine(
            each.name,
            tuple(decimals(point.co) for point in each.points),  # type: ignore[misc]
            (decimal(each.tension[0]), decimal(each.tension[1])) if each.use_tension else None,
            BASIS_OF[each.basis],
        )
        for each in scene.lappet.skin_lines
    )


def set_skin_line(each: bpy.types.PropertyGroup, line: SkinLine) -> None:
    """Give an entry of `scene.lappet.skin_lines` the values of a line."""
    each.name, each.basis, each.use_tension = line.name, _BASIS_NAMES[line.basis], line.tension is not None
    if line.tension is not None:
        each.tension = line.tension
    each.points.clear()
    for point in line.points:
        each.points.add().co = point
