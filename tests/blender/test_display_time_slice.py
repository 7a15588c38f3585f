"""What takes long is done in slices, so that Blender answers in between; in the end nothing is missing."""

from __future__ import annotations

import time

import bpy
import pytest

from lappet_blender.display import epoch_mesh, skin_display, time_slice
from lappet_blender.display.display_collection import ROLE, find_collection
from lappet_blender.solving import frames
from slit_manifest import Solved, add_tissue, slit, slit_manifest, solved

__all__ = ["solved"]  # a fixture


@pytest.fixture
def listed(scene: bpy.types.Scene, solved: Solved) -> bpy.types.Scene:
    """The slit patch at the frame in which it is held open, solved but never shown."""
    add_tissue(scene)
    scene.frame_set(slit.LIFTED)
    event = scene.lappet.events.add()
    event.name, event.kind, event.start, event.closed = "mark", "UNDERMINE", slit.INCISED, True
    for x, y in ((-20, -8), (20, -8), (20, 8), (-20, 8)):
        event.points.add().co = (x, y, 0.0)
    solved.manifests[scene.name] = slit_manifest(5.0)
    return scene


def visible(scene: bpy.types.Scene) -> set[str]:
    """The roles of the parts that are seen."""
    collection = find_collection(scene)
    return set() if collection is None else {each[ROLE] for each in collection.objects if not each.hide_viewport}


def test_a_slice_begins_one_costly_piece_at_least_and_puts_off_the_next_when_time_is_up() -> None:
    hurried = time_slice.TimeSlice(soon=True)
    assert hurried.begins()
    time.sleep(1.5 * time_slice.SECONDS)
    assert hurried.begins(costly=False)
    assert not hurried.unfinished
    assert not hurried.begins()
    assert hurried.unfinished
    patient = time_slice.TimeSlice(soon=False)
    for _ in range(2):
        assert patient.begins()
        time.sleep(1.5 * time_slice.SECONDS)
    assert patient.begins()
    assert not patient.unfinished


def test_the_first_picture_comes_in_slices_and_is_the_one_that_comes_at_once(
    listed: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time_slice, "SECONDS", 0.0)
    skin_display.refresh_soon(listed)
    assert skin_display.skin_object(listed) is None
    assert not listed.lappet.tissue.object.hide_viewport, "until there is a picture, the tissue is seen"
    seen = [visible(listed)]
    while skin_display.continue_drawing():
        seen.append(visible(listed))
        assert len(seen) < 100
    assert len(seen) > 3
    assert skin_display.skin_object(listed) is not None
    in_slices = visible(listed)
    assert {"skin", "edge", "bed"} <= in_slices
    skin_display.refresh(listed)
    assert visible(listed) == in_slices


def test_a_script_that_waits_finds_the_picture_finished(listed: bpy.types.Scene) -> None:
    listed.frame_set(slit.LIFTED)
    assert {"skin", "edge", "bed"} <= visible(listed)
    assert not frames.follow_up()


def test_an_undo_between_two_slices_loses_nothing(listed: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time_slice, "SECONDS", 0.0)
    bpy.ops.ed.undo_push(message="one")
    listed.lappet.look.color = "CHECKER"
    bpy.ops.ed.undo_push(message="two")
    skin_display.refresh_soon(listed)
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    while skin_display.continue_drawing():
        pass
    skin_display.refresh(scene)
    assert {"skin", "edge", "bed"} <= visible(scene)


def test_a_large_skin_is_made_on_threads_and_is_the_one_that_is_made_at_once(
    listed: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time_slice, "SECONDS", 0.0)
    monkeypatch.setattr(epoch_mesh, "_LARGE", 0)
    skin_display.refresh_soon(listed)
    end, turns = time.monotonic() + 60.0, 0
    while skin_display.continue_drawing() and time.monotonic() < end:
        time.sleep(0.002)
        turns += 1
    assert turns > 5
    assert {"skin", "edge", "bed"} <= visible(listed)
    made = skin_display.skin_object(listed).data
    at_once = epoch_mesh.build_epoch_mesh(frames.shown_at(listed, slit.LIFTED).epoch)
    assert not made.validate()
    for name in ("rest", "origin", "face", "grid", "depth", "UVMap"):
        assert values(made, name) == values(at_once, name), name
    assert sharp(made) == sharp(at_once)


def values(mesh: bpy.types.Mesh, name: str) -> list[float]:
    """The numbers of an attribute."""
    attribute = mesh.attributes[name]
    kind, size = {"FLOAT_VECTOR": ("vector", 3), "FLOAT2": ("vector", 2)}.get(attribute.data_type, ("value", 1))
    found = [0.0] * (size * len(attribute.data))
    attribute.data.foreach_get(kind, found)
    return found


def sharp(mesh: bpy.types.Mesh) -> set[tuple[int, ...]]:
    """The edges that are sharp, by their ends."""
    marked = mesh.attributes["sharp_edge"].data
    return {tuple(sorted(edge.vertices)) for edge in mesh.edges if marked[edge.index].value}
