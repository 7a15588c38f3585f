"""The materials of a scene's display, kept by pointers on its collection; units and color decide which are right."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

from lappet.anatomy.tissue_layers import TissueLayers
from lappet.core.digest import digest
from lappet.drawing.skin_source import SCALARS
from lappet.procedure import VESSEL_KINDS

from ..look import skin_material
from ..look.material_nodes import Space
from ..look.solid_texture import add_tile
from .time_slice import TimeSlice

PIXEL = 0.12  # mm of skin that a pixel is taken to cover, for the grid's line width
_MADE_FOR = "lappet_made_for"
_PATIENT = TimeSlice(soon=False)
_TILED = "lappet_tiled"  # of a material: Solid shading has its picture
_DRESSED_AS = "lappet_dressed_as"  # of a mesh: the color and prefix of the roles of its materials


def quantity_of(look: bpy.types.PropertyGroup) -> str | None:
    """The quantity that a look colors the skin by, or None."""
    name = str(look.color).lower()
    return name if name in SCALARS else None


def _kept(
    collection: bpy.types.Collection,
    role: str,
    made_for: str,
    make: Callable[[], bpy.types.Material],
    time_slice: TimeSlice = _PATIENT,
) -> bpy.types.Material | None:
    """The material of a role, made where it is not there yet; None where the turn has no time for it."""
    slot = f"material {role}"
    material = collection.get(slot)
    if isinstance(material, bpy.types.Material) and material.get(_MADE_FOR) == made_for:
        return material
    if not time_slice.begins():
        return None
    fresh = make()
    fresh[_MADE_FOR] = made_for
    collection[slot] = fresh
    return fresh


def skin_materials(
    collection: bpy.types.Collection,
    color: str,
    highest: float,
    units: float,
    layers: TissueLayers,
    opacity: float = 1.0,
    prefix: str = "",
    time_slice: TimeSlice = _PATIENT,
) -> tuple[bpy.types.Material, ...] | None:
    """One material per origin: skin, wound wall, underside, rim; the user's own where there is one.

    color: of `COLORS`. units: Blender units per mm. opacity: of the skin. prefix: of the roles of what is drawn. None
    where the turn ended before all were made.
    """
    space = Space(units, True)
    pixel = float(collection.get("lappet_pixel", PIXEL))
    name = color.lower()

    def skin() -> bpy.types.Material:
        return skin_material.skin_material(name, pixel, highest, space, opacity)

    roles = _skin_roles(color, prefix)
    first = _kept(collection, roles[0], f"{units:g} {pixel:.3f} {opacity:g}", skin, time_slice)
    if first is not None and name in ("grid", "checker") and _TILED not in first:
        if not time_slice.begins():
            return None
        add_tile(first, name)
        first[_TILED] = True
    if first is not None and name in SCALARS:
        skin_material.set_full_scale(first, highest)
    others: tuple[Callable[[TissueLayers, Space], bpy.types.Material], ...] = (
        partial(skin_material.wall_material, opacity=opacity),
        skin_material.underside_material,
        skin_material.rim_material,
    )
    made_for = f"{units:g} {opacity:g} {digest(layers).hex()}"
    made = [first]
    for role, make in zip(roles[1:], others, strict=True):
        made.append(_kept(collection, role, made_for, partial(make, layers, space), time_slice))
    if None in made:
        return None
    own = (collection.get(f"own material {role}") for role in roles)
    return tuple(mine if isinstance(mine, bpy.types.Material) else each for mine, each in zip(own, made, strict=True))


def keep_own_materials(collection: bpy.types.Collection, mesh: bpy.types.Mesh) -> None:
    """Keep what the user has put into the slots of a skin that is shown, for the color it was put on.

    A slot that was emptied, or got the display's own material back, is the display's again.
    """
    if _DRESSED_AS not in mesh:
        return
    slots = list(mesh.materials)
    for role, material in zip(_skin_roles(*mesh[_DRESSED_AS].split("/")), slots, strict=False):
        slot = f"own material {role}"
        if material is not None and _MADE_FOR not in material:
            if collection.get(slot) != material:
                collection[slot] = material
        elif slot in collection:
            del collection[slot]


def dress(mesh: bpy.types.Mesh, materials: tuple[bpy.types.Material, ...], color: str, prefix: str) -> bool:
    """Give a skin its materials; whether that changed anything."""
    worn = f"{color}/{prefix}"
    if mesh.get(_DRESSED_AS) != worn:
        mesh[_DRESSED_AS] = worn
    if list(mesh.materials) == list(materials):
        return False
    mesh.materials.clear()
    for material in materials:
        mesh.materials.append(material)
    return True


def _skin_roles(color: str, prefix: str) -> tuple[str, ...]:
    """What the materials of a skin are kept as, one per origin: skin, wound wall, underside, rim."""
    return (f"skin {color.lower()}", f"{prefix}wall", f"{prefix}underside", f"{prefix}rim")


def part_material(collection: bpy.types.Collection, role: str, units: float) -> bpy.types.Material:
    """The material of a part: bed, edge, ink, thread, steel, landmark, kind of vessel, lumen, legend, label."""
    makers: dict[str, Callable[[], bpy.types.Material]] = {
        "bed": lambda: skin_material.bed_material(Space(units, True)),
        "edge": skin_material.edge_material,
        "ink": skin_material.ink_material,
        "thread": skin_material.thread_material,
        "steel": skin_material.steel_material,
        "landmark": skin_material.landmark_material,
        **{kind: partial(skin_material.vessel_material, kind) for kind in VESSEL_KINDS},
        "lumen": skin_material.lumen_material,
        "legend": lambda: skin_material.glowing_material("Legend", None),
        "label": lambda: skin_material.glowing_material("Label", (0.75, 0.75, 0.75, 1.0)),
        "legend ink": lambda: skin_material.glowing_material("Legend ink", (0.033, 0.03, 0.03, 1.0)),
    }
    made_for = f"{units:g}" if role == "bed" else "any"
    made = _kept(collection, role, made_for, makers[role])
    assert made is not None  # nothing is put off
    return made
