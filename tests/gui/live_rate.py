"""How often the skin follows a dragged hook in a real window, and whose processor time it costs: `run.py live_rate.py`.

Two lattices of about 20 000 and 50 000 cells: in a window where nothing moves, in the same window while it shows a
dragged hook, and in it while it shows a text in place of the skin, as drawing in software takes most of an update.
Figures to read, not limits: a machine that does other work too says how much time an update takes of each process, not
how many there would be on another.
"""

from __future__ import annotations

import os
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from large import sheet
from tools import MODULE, height, prepare

SPACINGS = {"20 000": 0.85, "50 000": 0.62}
SECONDS, UPDATES = 12.0, 20
STILL_SECONDS = 5.0
STEP = 0.25  # mm that the hook moves between two updates: 4 mm/s at 15 updates a second
_HERTZ = os.sysconf("SC_CLK_TCK")


def processor_seconds(pid: int) -> float:
    """What a process has used of the processor, all its threads, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _HERTZ


def daemons_of(worker: int) -> list[int]:
    """The processes that the worker has started."""
    found = []
    for each in Path("/proc").iterdir():
        if each.name.isdigit():
            try:
                parent = int((each / "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
            if parent == worker:
                found.append(int(each.name))
    return found


class TimerCost:
    """What Lappet's timer has used of the main thread, s: taking updates in, showing them, sending targets."""

    def __init__(self) -> None:
        timer, self.seconds = import_module(f"{MODULE}.solving.solve_timer"), 0.0
        once = timer.run_timer

        def timed(*given: Any) -> Any:
            begun = time.thread_time()
            done = once(*given)
            self.seconds += time.thread_time() - begun
            return done

        timer.run_timer = timed


class Costs:
    """Processor seconds since it was made: of the daemons, the worker, Lappet's timer, the rest of Blender."""

    def __init__(self, worker: int, timer: TimerCost) -> None:
        self._worker, self._daemons, self._timer = worker, daemons_of(worker), timer
        self._begun = self._now()

    def _now(self) -> np.ndarray:
        own = self._timer.seconds
        daemons = sum(processor_seconds(each) for each in self._daemons)
        return np.array([daemons, processor_seconds(self._worker), own, time.process_time() - own])

    def words(self, count: float) -> str:
        """Milliseconds of each of so many updates or seconds."""
        each = 1e3 * (self._now() - self._begun) / max(count, 1)
        names = ("daemon", "worker", "Lappet's timer", "the rest of Blender, which draws in software,")
        return ", ".join(f"{name} {value:.0f} ms" for name, value in zip(names, each, strict=True))


def scenario(blender: Driver) -> Steps:
    """A flap is cut and pulled; its hook goes up and down."""
    yield from prepare(blender)
    control = import_module(f"{MODULE}.solving.controller")
    frames = import_module(f"{MODULE}.solving.frames")
    scene = bpy.context.scene
    scene.frame_end = 4
    made = sheet(61, 41)
    with blender.override():
        bpy.ops.lappet.tissue_set(object=made.name, thickness=5.0, spacing=2.0)
    bpy.data.objects.remove(bpy.data.objects["block"])
    flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
    bpy.ops.lappet.hook_add(anchor=height(4, 5), target=(4, 6, 6), start=3.0, arrive=1.0)
    yield from blender.show_tab("Lappet")
    controller, timer = control.controller_of(scene), TimerCost()
    for cells, spacing in SPACINGS.items():
        scene.lappet.tissue.spacing = spacing
        yield 1.0
        yield from blender.wait_until(lambda: frames.manifest_of(scene) is not None, 120.0, f"{cells} cells: listed")
        bpy.ops.lappet.solve("INVOKE_DEFAULT")
        solved = lambda: frames.frame_state(scene, 4) == "solved" and controller.job is None  # noqa: E731
        yield from blender.wait_until(solved, 200.0, f"{cells} cells: solved")
        scene.frame_set(4)
        scene.lappet.active_event = 1
        yield 1.0
        yield from pulled(blender, controller, timer, cells)
        bpy.ops.lappet.live()
        yield 2.0
    yield from blender.screenshot("live_rate")


def pulled(blender: Driver, controller: Any, timer: TimerCost, cells: str) -> Steps:
    """Drags in live mode: not at all, in a window that shows the skin, in one that does not."""
    bpy.ops.lappet.live()
    live = controller.live
    yield from blender.wait_until(lambda: live.frame is not None, 90.0, f"{cells} cells: the skin is there")
    yield 1.0
    yield from still(blender, controller, timer, cells)
    yield from followed(blender, controller, timer, f"{cells} cells")
    area = blender.area()
    area.type = "TEXT_EDITOR"
    yield 1.0
    yield from followed(blender, controller, timer, f"{cells} cells, not drawn")
    area.type = "VIEW_3D"


def still(blender: Driver, controller: Any, timer: TimerCost, cells: str) -> Steps:
    """Leaves the target where it is for a while: what the window costs without a drag."""
    costs, begun = Costs(controller.client.worker, timer), time.monotonic()
    while time.monotonic() - begun < STILL_SECONDS:
        yield 0.01
    blender.notes[f"{cells} cells, still"] = f"a second costs the processor: {costs.words(time.monotonic() - begun)}"
    print(f"{cells} cells, still: {blender.notes[f'{cells} cells, still']}", flush=True)


def followed(blender: Driver, controller: Any, timer: TimerCost, name: str) -> Steps:
    """Moves the target an update at a time."""
    live, scene = controller.live, bpy.context.scene
    target, last, took = scene.lappet.events[1].target, live.frame, []
    converged, costs, begun = 0, Costs(controller.client.worker, timer), time.monotonic()
    target.location.z = 6.0 + 8.0 * STEP
    while time.monotonic() - begun < SECONDS or len(took) < UPDATES:
        yield 0.01
        if live.frame is not last:
            last, converged = live.frame, converged + live.converged
            took.append(live.seconds)
            # A step an update: by the clock, a slower machine would have farther to go each time.
            target.location.z = 6.0 + STEP * abs((len(took) % 16) - 8)
        if time.monotonic() - begun > 5.0 * SECONDS:
            break
    rate = len(took) / (time.monotonic() - begun)
    costs_of_each = costs.words(len(took))
    lattice = 0 if last.lattice is None else last.lattice.cells
    blender.notes[name] = (
        f"{lattice} cells, {rate:.1f} updates a second, {converged} of {len(took)} converged, median "
        f"{1e3 * float(np.median(took or [np.nan])):.0f} ms; an update costs the processor: {costs_of_each}"
    )
    print(blender.notes[name], flush=True)
    blender.expect(len(took) > 3, f"{name}: the skin follows: {blender.notes[name]}")


if __name__ == "__main__":
    run(scenario, limit=560.0)
