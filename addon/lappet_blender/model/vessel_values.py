"""Vessels and nerves: between the scene's property groups and the procedure's values."""

from __future__ import annotations

import bpy

from lappet.procedure import VESSEL_KINDS, Vessel, VesselKind

from .decimals import decimal, decimals
from .event_kinds import BASIS_OF

_BASIS_NAMES = {basis: name for name, basis in BASIS_OF.items()}
KIND_ITEMS = tuple((kind.upper(), kind.capitalize(), "") for kind in VESSEL_KINDS)
KIND_OF: dict[str, VesselKind] = {kind.upper(): kind for kind in VESSEL_KINDS}


def vessel_values(scene: bpy.types.Scene) -> tuple[Vessel, ...]:
    """The scene's vessels in their order."""
    return tuple(
        Vessel(
            each.name,
            tuple(decimals(point.co) for point in each.points),  # type: ignore[misc]
            KIND_OF[each.kind],
            decimal(each.radius),
            str(each.label),
            bool(each.typical_course),
            BASIS_OF[each.basis],
        )
        for each in scene.lappet.vessels
    )


def set_vessel(each: bpy.types.PropertyGroup, vessel: Vessel) -> None:
    """Give an entry of `scene.lappet.vessels` the values of a vessel; one of an unknown kind becomes an artery."""
    each.name, each.basis, each.label = vessel.name, _BASIS_NAMES[vessel.basis], vessel.label
    each.kind = vessel.kind.upper() if vessel.kind in VESSEL_KINDS else VESSEL_KINDS[0].upper()
    each.radius, each.typical_course = vessel.radius, vessel.typical_course
    each.points.clear()
    for point in vessel.points:
        each.points.add().co = point
