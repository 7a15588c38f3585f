"""Names of plates, panels and annotations, and on which panels an annotation stands."""

from __future__ import annotations

from typing import Any

import bpy

from .event_list import identifier, unique_name


def active_of(items: Any, index: int) -> Any | None:
    """The item of a list at an index, None where there is none."""
    return items[index] if 0 <= index < len(items) else None


def active_plate(scene: bpy.types.Scene) -> Any | None:
    """The scene's chosen plate."""
    return active_of(scene.lappet.pages, scene.lappet.active_page)


def active_panel(scene: bpy.types.Scene) -> Any | None:
    """The chosen panel of the chosen plate."""
    plate = active_plate(scene)
    return None if plate is None else active_of(plate.panels, plate.active_panel)


def active_annotation(scene: bpy.types.Scene) -> Any | None:
    """The chosen annotation of the chosen plate."""
    plate = active_plate(scene)
    return None if plate is None else active_of(plate.annotations, plate.active_annotation)


def free_name(items: Any, wanted: str, fallback: str) -> str:
    """The nearest name to `wanted` that no item of a list has."""
    return unique_name(wanted if identifier(wanted) else fallback, [each.name for each in items])


def rename(item: Any, wanted: str) -> None:
    """Rename a plate, a panel or an annotation; what names a panel follows."""
    plate, items = _list_of(item)
    before = str(item.name)
    if items is None or wanted == before:
        return
    others = [each.name for each in items if each != item]
    item.name = unique_name(wanted if identifier(wanted) else before, others)
    if plate is None or items != plate.panels:
        return
    for note in plate.annotations:
        for each in note.panels:
            if each.name == before:
                each.name = item.name
    for panel in plate.panels:
        if panel.inset_of == before:
            panel.inset_of = item.name


def is_shown(note: Any) -> bool:
    """Whether an annotation stands on the chosen panel of its plate."""
    plate, _ = _list_of(note)
    panel = None if plate is None else active_of(plate.panels, plate.active_panel)
    return shown_on(note, "" if panel is None else panel.name)


def shown_on(note: Any, panel: str) -> bool:
    """Whether an annotation stands on a panel of that name."""
    return bool(note.enabled and (not len(note.panels) or note.panels.find(panel) >= 0))


def set_shown(note: Any, shown: bool) -> None:
    """Have an annotation stand on the chosen panel or not; one that would stand on none is off."""
    plate, _ = _list_of(note)
    panel = None if plate is None else active_of(plate.panels, plate.active_panel)
    if panel is None or plate is None:
        note.enabled = shown
        return
    every = [each.name for each in plate.panels]
    now = {name for name in every if shown_on(note, name)}
    now = now | {panel.name} if shown else now - {panel.name}
    note.enabled = bool(now)
    note.panels.clear()
    for name in every if now and len(now) < len(every) else ():
        if name in now:
            note.panels.add().name = name


def _list_of(item: Any) -> tuple[Any | None, Any | None]:
    """The plate that an item lies in, None for a plate itself, and the list that it is in."""
    pages = item.id_data.lappet.pages
    if any(each == item for each in pages):
        return None, pages
    for plate in pages:
        for items in (plate.panels, plate.annotations):
            if any(each == item for each in items):
                return plate, items
    return None, None
