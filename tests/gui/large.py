"""A tissue of 20 000 vertices in a real window: how long Lappet keeps Blender's main thread: `run.py large.py`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE, height, prepare
from window_pulse import Pulse

ACROSS, ALONG, END = 166, 126, 8
STALL = 0.050  # seconds of the processor at once; twice that is allowed on a machine that does other work too


def sheet(across: int = ACROSS, along: int = ALONG) -> bpy.types.Object:
    """The skin of 60 x 40 mm as an open sheet of across x along vertices."""
    x, y = np.meshgrid(np.linspace(-30, 30, across), np.linspace(-20, 20, along))
    top = np.stack([x, y, -(x**2 + y**2) / 200.0], axis=-1).reshape(-1, 3)
    ids = np.arange(x.size).reshape(x.shape)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata(top.tolist(), [], quads.tolist())
    made = bpy.data.objects.new("sheet", mesh)
    bpy.context.collection.objects.link(made)
    return made


def scenario(blender: Driver, across: int = ACROSS, along: int = ALONG, patience: float = 1.0) -> Steps:
    """Manifests, shows, solves, edits, undoes, drags, opens again; notes the longest calls of each.

    patience: how much longer than at 20 000 vertices things may take in the background.
    """
    yield from prepare(blender)
    scene = bpy.context.scene
    scene.frame_end = END
    measured = Measured(blender, patience)
    yield from made_tissue(measured, across, along)
    yield from first_pictures(measured)
    yield from solved(measured)
    yield from edited(measured)
    yield from opened(measured)


class Measured:
    """What the parts share. patience: how much longer than at 20 000 vertices things may take in the background."""

    def __init__(self, blender: Driver, patience: float) -> None:
        self.blender, self.pulse, self.patience = blender, Pulse(blender), patience
        self.frames = import_module(f"{MODULE}.solving.frames")
        self.display = import_module(f"{MODULE}.display.skin_display")
        self.control = import_module(f"{MODULE}.solving.controller")

    def noted(self, what: str) -> None:
        """Notes the longest calls since the last note."""
        self.blender.notes[what] = self.pulse.words()
        worst = max(self.pulse.longest.values(), default=0.0)
        self.blender.expect(worst < 2 * STALL, f"{what}: {self.pulse.words()}")
        self.pulse.begin()

    def states(self) -> set[str]:
        """The states of all frames."""
        return {self.frames.frame_state(bpy.context.scene, frame) for frame in range(1, END + 1)}

    def read(self) -> bool:
        """Whether the scene is read as it is now."""
        return self.control.controller_of(bpy.context.scene).dirty_since is None

    def until(self, condition: Callable[[], bool], seconds: float, sentence: str) -> Steps:
        """Waits for something that takes longer the more vertices there are."""
        yield from self.blender.wait_until(condition, seconds * self.patience, sentence)


def made_tissue(measured: Measured, across: int, along: int) -> Steps:
    """A sheet becomes the tissue, and events are placed on it."""
    blender = measured.blender
    made = sheet(across, along)
    blender.expect(len(made.data.vertices) == across * along, f"the skin has {len(made.data.vertices)} vertices")
    with blender.override():
        bpy.ops.lappet.tissue_set(object="sheet", thickness=5.0, spacing=2.0)
    measured.noted("making it the tissue")
    yield from measured.until(measured.read, 60.0, "it is read")
    yield 1.0 + measured.patience
    measured.noted("reading the tissue")
    flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
    bpy.ops.lappet.hook_add(anchor=height(-1, 5), target=(-2, 6, 6), start=3.0, arrive=3.0)
    for x in (0.0, 4.0, 8.0):
        bpy.ops.lappet.suture_add(first=height(x, 7.6), second=height(x, 8.4), start=5, duration=3)
    measured.noted("adding events")
    bpy.ops.ed.undo_push(message="Procedure")


def first_pictures(measured: Measured) -> Steps:
    """The skin is shown, epoch by epoch."""
    scene = bpy.context.scene
    yield from measured.blender.show_tab("Lappet")
    measured.pulse.begin()
    yield from measured.until(lambda: measured.frames.manifest_of(scene) is not None, 90.0, "it is listed")
    yield from measured.until(lambda: measured.display.skin_object(scene) is not None, 30.0, "its skin is shown")
    yield 3.0
    measured.noted("listing and the first picture")
    for frame in range(2, END + 1):
        scene.frame_set(frame)
        yield 0.5
    yield 2.0 * measured.patience
    measured.noted("every epoch for the first time")


def solved(measured: Measured) -> Steps:
    """All frames are solved and scrubbed."""
    bpy.ops.lappet.solve("INVOKE_DEFAULT")
    yield from measured.until(lambda: measured.states() == {"solved"}, 200.0, "it is solved")
    yield 1.0
    measured.noted("solving")
    for frame in (*range(END, 0, -1), *range(1, END + 1)):
        bpy.context.scene.frame_set(frame)
        yield 0.3
    measured.noted("scrubbing")
    yield from measured.blender.screenshot("large")


def edited(measured: Measured) -> Steps:
    """An edit, its undo, a live drag, a point that moves."""
    blender, scene, pulse = measured.blender, bpy.context.scene, measured.pulse
    bpy.ops.ed.undo_push(message="Solved")
    pulse.begin()
    next(event for event in scene.lappet.events if event.kind == "HOOK").stiffness = 90.0
    bpy.ops.ed.undo_push(message="Softer")
    yield from measured.until(lambda: "stale" in measured.states(), 60.0, "an edit makes frames stale")
    yield 3.0
    measured.noted("an edit")
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("Z", ctrl=True)
    yield from measured.until(lambda: measured.states() == {"solved"}, 3.0, "Ctrl-Z brings the frames back")
    yield 2.0
    measured.noted("undo")
    yield from dragging(blender, pulse, 2.0 * measured.patience)
    measured.noted("live dragging")
    bpy.ops.lappet.live()
    yield 1.0
    pulse.begin()
    bpy.ops.lappet.point_move(event="incision_1", index=1, co=height(-2.5, 8))
    yield 3.0
    measured.noted("moving a point")


def opened(measured: Measured) -> Steps:
    """The file is saved and opened again."""
    path = str(measured.blender.folder / "large.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    measured.pulse.begin()
    bpy.ops.wm.open_mainfile(filepath=path)
    yield from measured.until(measured.read, 60.0, "opened again, it is read")
    yield 3.0
    measured.noted("opening the file")


def dragging(blender: Driver, pulse: Pulse, seconds: float) -> Steps:
    """Live: the hook's target goes up and down for a while; notes how many updates came."""
    control = import_module(f"{MODULE}.solving.controller")
    scene = bpy.context.scene
    scene.lappet.active_event = next(i for i, event in enumerate(scene.lappet.events) if event.kind == "HOOK")
    scene.frame_set(5)
    yield from blender.wait_until(
        lambda: control.controller_of(scene).job is None, 60.0 + 30.0 * seconds, "nothing is solved any more"
    )
    pulse.begin()
    bpy.ops.lappet.live()
    live = control.controller_of(scene).live
    yield from blender.wait_until(lambda: live.frame is not None, 90.0, "live: the skin is there")
    target, updates, last = scene.lappet.events[scene.lappet.active_event].target, 0, live.frame
    begun = time.monotonic()
    while time.monotonic() - begun < seconds + 3.0:
        target.location.z = 5.0 + 2.0 * np.sin(2.0 * (time.monotonic() - begun))
        yield 0.02
        if live.frame is not last:
            updates, last = updates + 1, live.frame
    took = time.monotonic() - begun
    blender.notes["live updates"] = f"{updates / took:.1f} a second; the last took {live.seconds:.3f} s"
    print(blender.notes["live updates"], flush=True)
    blender.expect(updates > 2, f"live: {updates} updates in {took:.1f} s")


if __name__ == "__main__":
    run(scenario)
