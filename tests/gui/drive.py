"""Installs the extension's zip in a real window and notes what of Lappet is there: run by tests/gui/run.py."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run

MODULE = "bl_ext.user_default.lappet_blender"


def scenario(blender: Driver) -> Steps:
    """Installs, enables, opens the tab, selects and moves the cube with mouse and keys, undoes, disables."""
    yield from blender.screenshot("started")
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    blender.expect(addon_utils.check(MODULE) == (True, True), "the zip is installed and enabled")
    import lappet

    blender.expect("/extensions/.local/" in lappet.__file__, "lappet comes from the extension's wheels")
    blender.expect("Lappet" in blender.tabs(), f"the sidebar has a tab Lappet among {', '.join(blender.tabs())}")
    lappets = [name for name in blender.tools() if "lappet" in name]
    blender.notes["tools"] = lappets
    blender.expect(bool(lappets), f"the toolbar has Lappet's tools: {', '.join(lappets) or 'none'}")
    if "Lappet" in blender.tabs():
        yield from blender.show_tab("Lappet")
    yield from blender.screenshot("tab")

    cube = bpy.data.objects["Cube"]
    yield from blender.click(blender.within(0.05, 0.5))
    yield from blender.wait_until(lambda: not cube.select_get(), 2.0, "a click beside it deselects the cube")
    yield from blender.click(blender.at(cube.location))
    yield from blender.wait_until(cube.select_get, 2.0, "a click on the cube selects it")
    yield from blender.key("G")
    x, y = blender.at(cube.location)
    yield from blender.move((x + 60, y + 40))
    yield from blender.click((x + 60, y + 40))
    yield from blender.wait_until(lambda: cube.location.length > 0.1, 2.0, "G and the mouse move the cube")
    yield from blender.screenshot("moved")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(
        lambda: bpy.data.objects["Cube"].location.length < 1e-6, 2.0, "Ctrl-Z brings the cube back"
    )
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield 0.3
    blender.expect(addon_utils.check(MODULE)[1] is False, "it is disabled again")
    yield from blender.screenshot("disabled")


run(scenario)
