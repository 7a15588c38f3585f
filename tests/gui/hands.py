"""Checks the driver itself, on Blender's own scene: `python tests/gui/run.py hands.py`."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run


def selected() -> list[str]:
    """The names of what is selected."""
    return sorted(each.name for each in bpy.context.view_layer.objects if each.select_get())


def scenario(blender: Driver) -> Steps:
    """Clicks, drags a box, moves with a modal operator, undoes, redoes, types a name."""
    cube = bpy.data.objects["Cube"]
    yield from blender.click(blender.within(0.3, 0.15))
    yield from blender.wait_until(lambda: not selected(), 2.0, "a click beside everything deselects all")
    yield from blender.drag([blender.within(0.12, 0.2), blender.within(0.7, 0.85)])
    yield from blender.wait_until(lambda: selected() == ["Camera", "Cube", "Light"], 2.0, "a box selects all three")
    yield from blender.screenshot("box")
    yield from blender.click(blender.at(cube.location))
    yield from blender.wait_until(lambda: selected() == ["Cube"], 2.0, "a click on the cube selects it alone")
    x, y = blender.at(cube.location)
    yield from blender.key("G")
    yield from blender.move((x + 60, y + 40))
    yield from blender.click((x + 60, y + 40))
    yield from blender.wait_until(lambda: cube.location.length > 0.1, 2.0, "G and the mouse move the cube")
    u, v = blender.at(cube.location)
    blender.expect(abs(u - x - 60) <= 1 and abs(v - y - 40) <= 1, "it is seen where the mouse left it")
    yield from blender.screenshot("moved")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: bpy.data.objects["Cube"].location.length < 1e-6, 2.0, "Ctrl-Z brings it back")
    yield from blender.key("Z", ctrl=True, shift=True)
    yield from blender.wait_until(
        lambda: bpy.data.objects["Cube"].location.length > 0.1, 2.0, "Ctrl-Shift-Z takes it away again"
    )
    yield from blender.key("F2")
    yield 0.3
    yield from blender.key("A", ctrl=True)
    yield from blender.text("Skin 2")
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: "Skin 2" in bpy.data.objects, 2.0, "F2 and the keys rename it to Skin 2")
    yield from blender.show_tab("View")
    blender.expect(blender.region("UI").active_panel_category == "View", "the sidebar shows the tab that is asked for")
    yield from blender.set_tool("builtin.measure")
    tool = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT")
    blender.expect(tool.idname == "builtin.measure", "the tool that is asked for is the active one")
    yield from blender.screenshot("named")


run(scenario)
