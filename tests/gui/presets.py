"""Presets of one's own for thread, plate, skin and look in a real window: `run.py presets.py`.

Each is kept under a name, the values are changed, the preset is chosen with the mouse in the list that the panel's
header opens, and it is deleted with the button beside its name.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run

MIDDLE = (0.35, 0.5)  # of the 3D view, where a list opens with its first row under the mouse
BESIDE = 105  # pixels from there to the button beside the row


def scenario(blender: Driver) -> Steps:
    """One kind after another, on the first file of the template."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    bpy.ops.lappet.template_install()
    bpy.ops.wm.read_homefile("EXEC_DEFAULT", app_template="Lappet")
    yield 2.0
    scene = bpy.context.window_manager.windows[0].scene
    with blender.override():
        bpy.ops.lappet.plate_add("EXEC_DEFAULT", True, template="steps")
    data = scene.lappet
    data.active_event = next(i for i, each in enumerate(data.events) if each.kind in ("SUTURE", "SUTURE_RUN"))
    sewn = data.events[data.active_event].name
    yield from blender.show_tab("Lappet")
    yield from preset(
        blender, "thread", lambda: data.events[sewn], {"mode": "THREAD", "thread": "SILK_3_0"}, {"mode": "EXACT"}
    )
    yield from preset(
        blender,
        "plate",
        lambda: data.pages[0],
        {"style": "ink", "width": 85.0, "columns": 2, "letters": False},
        {"style": "wash", "width": 174.0, "columns": 0, "letters": True},
    )
    yield from preset(
        blender,
        "skin",
        lambda: data.materials[0],
        {"fiber_k1": 23.0},
        {"fiber_k1": 5.0},
    )
    yield from preset(blender, "look", lambda: data.look, {"color": "STRAIN"}, {"color": "GRID"})


def preset(blender: Driver, kind: str, owner: Callable[[], Any], kept: dict[str, Any], other: dict[str, Any]) -> Steps:
    """Keep values, set others, choose the preset with the mouse, and delete it with the mouse."""
    for name, value in kept.items():
        setattr(owner(), name, value)
    yield from opened(blender, kind)
    yield from blender.screenshot(f"{kind}_none")
    yield from blender.click(blender.within(*MIDDLE))  # the field of the name, under the mouse
    yield 0.3
    yield from blender.key("A", ctrl=True)
    yield from blender.text(f"My {kind}")
    yield from blender.key("RET")
    yield 0.3
    yield from beside(blender)
    yield from blender.key("ESC")
    yield 0.3
    found = [Path(each) / f"lappet/{kind}" for each in bpy.utils.preset_paths("")]
    files = [file for folder in found for file in folder.glob("*.py")]
    names = [each.name for each in files]
    blender.expect(names == [f"My_{kind}.py"], f"the {kind}'s values are kept under a name that was typed: {names}")
    for name, value in other.items():
        setattr(owner(), name, value)
    yield 0.3
    yield from opened(blender, kind)
    yield from blender.screenshot(f"{kind}_presets")
    yield from blender.click(blender.within(*MIDDLE))
    yield 0.5
    values = {name: getattr(owner(), name) for name in kept}
    blender.expect(close(values, kept), f"a click on its name brings them back: {values}")
    yield from blender.key("ESC")
    yield 0.3
    yield from opened(blender, kind)
    yield from beside(blender)
    yield from blender.key("ESC")
    left = [file.name for folder in found for file in folder.glob("*.py")]
    blender.expect(left == [], f"the button beside its name deletes it: {left}")


def beside(blender: Driver) -> Steps:
    """Click the button to the right of what the mouse is at: + beside the field, − beside a preset."""
    x, y = blender.within(*MIDDLE)
    yield from blender.click((x + BESIDE, y))
    yield 0.4


def opened(blender: Driver, kind: str) -> Steps:
    """Open the list that the panel's header opens, where the mouse is."""
    yield from blender.move(blender.within(*MIDDLE))
    with blender.override():
        bpy.ops.wm.call_panel("INVOKE_DEFAULT", name=f"LAPPET_PT_{kind}_presets", keep_open=True)
    yield 0.5


def close(values: dict[str, Any], kept: dict[str, Any]) -> bool:
    """Whether values are those kept, numbers to Blender's precision."""
    return all(abs(values[k] - v) < 1e-4 if isinstance(v, float) else values[k] == v for k, v in kept.items())


if __name__ == "__main__":
    run(scenario)
