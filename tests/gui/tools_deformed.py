"""Drawing on solved, deformed skin and excising from it, in a real window: `run.py tools_deformed.py`."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE, events, first_points, height, last, near, prepare


def scenario(blender: Driver) -> Steps:
    """Cuts a flap and a plug, lifts the flap, solves; draws on the flap and excises the plug as they are shown."""
    yield from prepare(blender)
    scene, ops = bpy.context.scene, bpy.ops.lappet
    scene.frame_end = 12
    scene.lappet.tissue.spacing = 2.0
    ops.faces_assign(group="fixed", which="SIDES")
    flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
    plug = [height(20 + 4 * np.cos(a), 6 * np.sin(a)) for a in np.linspace(0, 6, 8)]
    ops.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
    ops.hook_add(anchor=height(-1, 5), begin=height(-1, 5), target=(-8, 14, 14), start=2.0, arrive=8.0)
    ops.incision_add(points=[{"name": "", "co": p} for p in plug], time=3.0, kerf=0.2, closed=True)
    blender.expect(ops.solve(wait=True) == {"FINISHED"}, "the procedure is solved")
    scene.frame_set(12)
    yield 0.5
    yield from blender.set_tool("lappet.edit")
    yield from blender.screenshot("solved")

    surface = import_module(f"{MODULE}.tools.shown_surface").shown_surface(scene)
    moved = np.linalg.norm(surface.positions * surface.mm - surface.rest.points, axis=1).max()
    blender.expect(surface.solved and moved > 8.0, f"the skin that is drawn on has moved by {moved:.1f} mm")
    wanted = [height(-6, -4), height(0, 4), height(8, 4)]
    shown = [tuple(place) for place in surface.carry(surface.rest.locate(np.array(wanted)))]
    yield from blender.set_tool("lappet.cutting.incision")
    yield from blender.click(blender.at(shown[0]))
    yield from blender.click(blender.at(shown[1]))
    yield from blender.move(blender.at(shown[2]))
    yield from blender.screenshot("drawing_on_the_flap")
    yield from blender.click(blender.at(shown[2]))
    yield from blender.key("RET")
    yield 0.3
    blender.expect(
        last().start == 12.0 and near(first_points(last()), *wanted),
        "what is drawn on the deformed flap lies at rest where that skin was",
    )
    yield from blender.screenshot("drawn_on_the_flap")

    yield from blender.set_tool("lappet.excise")
    (plug_now,) = surface.carry(surface.rest.locate(np.array([height(20, 0)])))
    x, y = blender.at(tuple(plug_now))
    yield from blender.move((x, y))
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.5
    yield from blender.move((x + 3, y + 2))
    yield from blender.screenshot("excising_the_plug")
    preview = import_module(f"{MODULE}.tools.preview").preview_of(scene)
    tinted = 0 if preview is None or preview.faces is None else len(preview.faces)
    blender.expect(0 < tinted < 0.5 * len(surface.rest.triangles), f"the plug alone is tinted: {tinted} triangles")
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.3
    blender.expect(last().kind == "EXCISION", f"letting go excises it: {', '.join(events())}")


run(scenario)
