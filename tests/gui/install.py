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
    """Installs, enables, starts the daemon, opens the tab, disables."""
    yield from blender.screenshot("started")
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    blender.expect(addon_utils.check(MODULE) == (True, True), "the zip is installed and enabled")
    import lappet
    from lappet.daemon.process import SolverDaemon

    blender.expect("/extensions/.local/" in lappet.__file__, "lappet comes from the extension's wheels")
    with SolverDaemon() as daemon:
        blender.expect(daemon.alive(), "the wheel's daemon starts on another Debian than it was built on")
    tabs = blender.tabs()
    blender.expect("Lappet" in tabs, f"the sidebar has a tab Lappet among {', '.join(tabs)}")
    tools = [name for name in blender.tools() if "lappet" in name]
    blender.expect(bool(tools), f"the toolbar has Lappet's tools: {', '.join(tools) or 'none'}")
    yield from blender.show_tab("Lappet" if "Lappet" in tabs else "Item")
    yield from blender.screenshot("tab")
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield 0.3
    blender.expect(not addon_utils.check(MODULE)[1], "it is disabled again")
    blender.expect("Lappet" not in blender.tabs(), "the tab goes with it")
    yield from blender.screenshot("disabled")


run(scenario)
