"""A tissue of 20 000 vertices in a real window: how long Lappet keeps Blender's main thread: `run.py large.py`."""

from __future__ import annotations

import sys
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


def scenario(blender: Driver) -> Steps:
    """Manifests, shows, solves, edits, undoes; notes the longest calls of each."""
    yield from prepare(blender)
    frames = import_module(f"{MODULE}.solving.frames")
    display = import_module(f"{MODULE}.display.skin_display")
    pulse, scene = Pulse(blender), bpy.context.scene

    def noted(what: str) -> None:
        blender.notes[what] = pulse.words()
        worst = max(pulse.longest.values(), default=0.0)
        blender.expect(worst < 2 * STALL, f"{what}: {pulse.words()}")
        pulse.begin()

    def states() -> list[str]:
        return [frames.frame_state(bpy.context.scene, time) for time in range(1, END + 1)]

    scene.frame_end = END
    made = sheet()
    blender.expect(len(made.data.vertices) > 20_000, f"the skin has {len(made.data.vertices)} vertices")
    with blender.override():
        bpy.ops.lappet.tissue_set(object="sheet", thickness=5.0, spacing=2.0)
    flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
    bpy.ops.lappet.hook_add(anchor=height(-1, 5), target=(-2, 6, 6), start=3.0, arrive=3.0)
    for x in (0.0, 4.0, 8.0):
        bpy.ops.lappet.suture_add(first=height(x, 7.6), second=height(x, 8.4), start=5, duration=3)
    bpy.ops.ed.undo_push(message="Procedure")
    yield from blender.show_tab("Lappet")
    pulse.begin()
    yield from blender.wait_until(lambda: frames.manifest_of(scene) is not None, 90.0, "it is listed")
    yield from blender.wait_until(lambda: display.skin_object(scene) is not None, 30.0, "its skin is shown")
    yield 3.0
    noted("listing and the first picture")
    for time in range(2, END + 1):
        scene.frame_set(time)
        yield 0.5
    noted("every epoch for the first time")
    bpy.ops.lappet.solve("INVOKE_DEFAULT")
    yield from blender.wait_until(lambda: set(states()) == {"solved"}, 200.0, "it is solved")
    yield 1.0
    noted("solving")
    for time in (*range(END, 0, -1), *range(1, END + 1)):
        scene.frame_set(time)
        yield 0.3
    noted("scrubbing")
    yield from blender.screenshot("large")
    bpy.ops.ed.undo_push(message="Solved")
    pulse.begin()
    next(event for event in scene.lappet.events if event.kind == "HOOK").stiffness = 90.0
    bpy.ops.ed.undo_push(message="Softer")
    yield from blender.wait_until(lambda: "stale" in states(), 60.0, "an edit makes frames stale")
    yield 3.0
    noted("an edit")
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: set(states()) == {"solved"}, 3.0, "Ctrl-Z brings the frames back")
    yield 2.0
    noted("undo")


if __name__ == "__main__":
    run(scenario)
