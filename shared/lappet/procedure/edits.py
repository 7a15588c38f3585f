"""The edits of a procedure: events, materials, regions, tissue, bones and the timeline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure.events import Event, kind_words, retimed
from lappet.procedure.history import Edit
from lappet.procedure.prim_paths import BONE, MATERIALS, ROOT, TIMELINE, TISSUE
from lappet.procedure.procedure import Procedure
from lappet.procedure.tissue import Bone, Material, Region, Tissue

_PLACES = {"events": TIMELINE, "materials": MATERIALS, "bones": BONE}  # of what a procedure holds by name


def add_event(event: Event, index: int | None = None) -> Edit:
    """Add an event before the event at `index` of the timeline, or at its end.

    Parameters
    ----------
    event
        The new event.
    index
        Place in the order of the timeline, or None for its end.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        _refuse_taken(procedure, event.name)
        events = list(procedure.events)
        events.insert(len(events) if index is None else index, event)
        return replace(procedure, events=tuple(events))

    return Edit(f"Add {kind_words(event)} {event.name}", edited)


def remove_event(name: str) -> Edit:
    """Remove the event of that name.

    Parameters
    ----------
    name
        Name of the event.

    Returns
    -------
    Edit
        The edit.
    """
    return Edit(f"Remove {name}", lambda procedure: _without(procedure, "events", name))


def replace_event(name: str, event: Event) -> Edit:
    """Put another event, of any kind and name, in the place of the event of that name.

    Parameters
    ----------
    name
        Name of the event that goes.
    event
        The event that comes.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        if event.name != name:
            _refuse_taken(procedure, event.name)
        return _with(procedure, "events", _find(procedure, "events", name), event)

    return Edit(f"Edit {name}", edited)


def move_event(name: str, index: int) -> Edit:
    """Move an event to another place in the order of the timeline.

    Parameters
    ----------
    name
        Name of the event.
    index
        Its new place.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        events = list(procedure.events)
        events.insert(index, events.pop(_find(procedure, "events", name)))
        return replace(procedure, events=tuple(events))

    return Edit(f"Move {name}", edited)


def retime_event(name: str, shift: float) -> Edit:
    """Shift an event in time with all its samples; landmarks have no time and are refused.

    Parameters
    ----------
    name
        Name of the event.
    shift
        Time codes to add.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        at = _find(procedure, "events", name)
        return _with(procedure, "events", at, retimed(procedure.events[at], shift))

    return Edit(f"Move {name} by {shift:+g}", edited)


def set_material(material: Material) -> Edit:
    """Replace the material of the same name, or add it.

    Parameters
    ----------
    material
        The material.

    Returns
    -------
    Edit
        The edit.
    """
    return Edit(f"Set material {material.name}", lambda procedure: _set(procedure, "materials", material))


def remove_material(name: str) -> Edit:
    """Remove a material of which neither the tissue nor a region of it is made.

    Parameters
    ----------
    name
        Name of the material.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        users = ["The tissue"] if procedure.tissue.material == name else []
        users += [f"The region {region.faces!r}" for region in procedure.tissue.regions if region.material == name]
        if users:
            raise refused(ProblemCode.MATERIAL_IN_USE, f"{MATERIALS}/{name}", name, user=users[0])
        return _without(procedure, "materials", name)

    return Edit(f"Remove material {name}", edited)


def set_region(region: Region) -> Edit:
    """Give a face subset of the tissue a region, in place of the one that it has.

    Parameters
    ----------
    region
        The region; its `faces` name the subset.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        tissue = procedure.tissue
        if region.faces not in tissue.subsets:
            known = ", ".join(tissue.subsets) or "none"
            raise refused(ProblemCode.REGION_NO_SUBSET, f"{TISSUE}/{region.faces}", repr(region.faces), known=known)
        others = (each for each in tissue.regions if each.faces != region.faces)
        return replace(procedure, tissue=replace(tissue, regions=(*others, region)))

    return Edit(f"Set region {region.faces}", edited)


def remove_region(faces: str) -> Edit:
    """Take the region off a face subset; the subset stays.

    Parameters
    ----------
    faces
        Name of the subset.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        tissue = procedure.tissue
        others = tuple(region for region in tissue.regions if region.faces != faces)
        if len(others) == len(tissue.regions):
            known = ", ".join(region.faces for region in tissue.regions) or "none"
            raise refused(ProblemCode.REGION_UNKNOWN, f"{TISSUE}/{faces}", faces, known=known)
        return replace(procedure, tissue=replace(tissue, regions=others))

    return Edit(f"Remove region {faces}", edited)


def set_tissue(tissue: Tissue) -> Edit:
    """Replace the tissue.

    Parameters
    ----------
    tissue
        The new tissue.

    Returns
    -------
    Edit
        The edit.
    """
    return Edit("Set tissue", lambda procedure: replace(procedure, tissue=tissue))


def set_bone(bone: Bone) -> Edit:
    """Replace the bone of the same name, or add it.

    Parameters
    ----------
    bone
        The bone.

    Returns
    -------
    Edit
        The edit.
    """
    return Edit(f"Set bone {bone.name}", lambda procedure: _set(procedure, "bones", bone))


def remove_bone(name: str) -> Edit:
    """Remove a bone.

    Parameters
    ----------
    name
        Name of the bone.

    Returns
    -------
    Edit
        The edit.
    """
    return Edit(f"Remove bone {name}", lambda procedure: _without(procedure, "bones", name))


def set_timeline(start_time: float | None = None, end_time: float | None = None, fps: float | None = None) -> Edit:
    """Set the timeline's start, end and rate; None leaves a value as it is.

    Parameters
    ----------
    start_time
        First time code.
    end_time
        Last time code.
    fps
        Time codes per second.

    Returns
    -------
    Edit
        The edit.
    """
    given: dict[str, Any] = {"start_time": start_time, "end_time": end_time, "fps": fps}

    def edited(procedure: Procedure) -> Procedure:
        after = replace(procedure, **{name: value for name, value in given.items() if value is not None})
        if not after.start_time <= after.end_time:
            raise refused(ProblemCode.TIMELINE_REVERSED, ROOT, f"{after.start_time:g} to {after.end_time:g}")
        return after

    return Edit("Set timeline", edited)


def together(edits: Sequence[Edit], label: str) -> Edit:
    """Make several edits one step of the history: all are applied, or none.

    Parameters
    ----------
    edits
        The edits in order.
    label
        What an undo menu shows.

    Returns
    -------
    Edit
        The edit.
    """

    def edited(procedure: Procedure) -> Procedure:
        for edit in edits:
            procedure = edit.apply(procedure)
        return procedure

    return Edit(label, edited)


def _find(procedure: Procedure, field: str, name: str) -> int:
    names = [each.name for each in getattr(procedure, field)]
    if name not in names:
        known = ", ".join(names) or "nothing"
        raise refused(ProblemCode.NAME_UNKNOWN, f"{_PLACES[field]}/{name}", name, known=known)
    return names.index(name)


def _refuse_taken(procedure: Procedure, name: str) -> None:
    if any(event.name == name for event in procedure.events):
        raise refused(ProblemCode.NAME_TAKEN, f"{TIMELINE}/{name}", name)


def _without(procedure: Procedure, field: str, name: str) -> Procedure:
    at, every = _find(procedure, field, name), getattr(procedure, field)
    return _changed(procedure, field, (*every[:at], *every[at + 1 :]))


def _with(procedure: Procedure, field: str, at: int, new: Any) -> Procedure:
    every = getattr(procedure, field)
    return _changed(procedure, field, (*every[:at], new, *every[at + 1 :]))


def _set(procedure: Procedure, field: str, new: Any) -> Procedure:
    names = [each.name for each in getattr(procedure, field)]
    return _with(procedure, field, names.index(new.name) if new.name in names else len(names), new)


def _changed(procedure: Procedure, field: str, value: tuple[Any, ...]) -> Procedure:
    changes: dict[str, Any] = {field: value}
    return replace(procedure, **changes)
