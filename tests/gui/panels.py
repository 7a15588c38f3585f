"""Every panel of the sidebar unfolded, with and without problems, in a real window: `run.py panels.py`."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE, height, prepare


def unfold() -> None:
    """Registers the panels anew, open."""
    panels = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith(("LAPPET_PT", "Lappet"))]
    panels = [each for each in panels if issubclass(each, bpy.types.Panel)]
    children = [each for each in panels if getattr(each, "bl_parent_id", "")]
    parents = [each for each in panels if each not in children]
    for each in (*children, *parents):
        bpy.utils.unregister_class(each)
    for each in (*parents, *children):
        each.bl_options = set()
        bpy.utils.register_class(each)


def scroll(blender: Driver, pages: int) -> Steps:
    """Turns the wheel over the sidebar."""
    yield from blender.move(blender.within(0.5, 0.5, "UI"))
    for _ in range(abs(pages) * 12):
        yield from blender.key("WHEELDOWNMOUSE" if pages > 0 else "WHEELUPMOUSE")


def pages(blender: Driver, name: str, count: int) -> Steps:
    """Pictures of the sidebar from its top down."""
    yield from scroll(blender, -6)
    yield from blender.screenshot(f"{name}_1")
    for page in range(2, count + 1):
        yield from scroll(blender, 1)
        yield from blender.screenshot(f"{name}_{page}")


def scenario(blender: Driver) -> Steps:
    """A solved procedure; one with a hole, an event beside the tissue and a missing target; a variant."""
    yield from prepare(blender)
    scene, ops = bpy.context.scene, bpy.ops.lappet
    frames = import_module(f"{MODULE}.solving.frames")
    scene.frame_end = 8
    scene.lappet.tissue.spacing = 2.0
    unfold()
    yield from blender.show_tab("Lappet")
    ops.faces_assign(group="fixed", which="SIDES")
    ops.incision_add(points=[{"name": "", "co": height(x, y)} for x, y in ((-14, -8), (-2, 8), (12, 8))], time=2.0)
    ops.hook_add(anchor=height(-1, 5), target=(-4, 6, 8), start=3.0, arrive=3.0)
    blender.expect(ops.solve(wait=True) == {"FINISHED"}, "the procedure is solved")
    scene.lappet.look.color = "TENSION"
    yield 0.5
    yield from pages(blender, "solved", 3)
    scene.lappet.look.color = "GRID"
    target = scene.lappet.events["hook_1"].target
    bpy.data.objects.remove(target)
    scene.lappet.events["incision_1"].points[1].co = (0.0, 0.0, 40.0)
    yield from blender.wait_until(lambda: bool(frames.problems_of(scene)), 5.0, "what is wrong is said")
    yield 1.0
    yield from pages(blender, "wrong", 3)
    mesh = scene.lappet.tissue.object.data
    scene.lappet.look.show_solved = False
    import bmesh

    made = bmesh.new()
    made.from_mesh(mesh)
    made.faces.ensure_lookup_table()
    bmesh.ops.delete(made, geom=[made.faces[7]], context="FACES_ONLY")
    made.to_mesh(mesh)
    made.free()
    mesh.update()
    ops.tissue_check()
    yield 1.0
    yield from pages(blender, "hole", 1)
    blender.expect(len(frames.problems_of(scene)) > 0, "a hole is said in the sidebar")


if __name__ == "__main__":
    run(scenario)
