"""From a new file to a solved flap in five clicks, and presets of one's own: `run.py first_steps.py`."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE


def scenario(blender: Driver) -> Steps:
    """Delete, Add > Grid, Make Tissue, Add > Lappet > Flap > Limberg, Solve: as the menus and buttons call them."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    frames = import_module(f"{MODULE}.solving.frames")
    skin_of = import_module(f"{MODULE}.display.skin_display").skin_object
    scene = bpy.context.scene
    yield from blender.show_tab("Lappet")
    with blender.override():
        bpy.ops.wm.call_menu(name="VIEW3D_MT_add")
    yield from blender.screenshot("add_menu")
    yield from blender.key("ESC")
    with blender.override():
        for each in list(bpy.data.objects):
            bpy.data.objects.remove(each)
        scene.unit_settings.scale_length = 0.001
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=30, y_subdivisions=30, size=70.0)
        made = bpy.ops.lappet.tissue_set("INVOKE_DEFAULT", spacing=2.5)
        blender.expect(made == {"FINISHED"}, "a click makes the grid the tissue")
    yield 1.0
    with blender.override():
        bpy.ops.view3d.view_all()
        laid = bpy.ops.lappet.flap_limberg("INVOKE_DEFAULT")
        blender.expect(laid == {"FINISHED"}, "a click lays a Limberg flap")
    blender.expect(len(scene.lappet.events) > 5, f"it has {len(scene.lappet.events)} events")
    yield 0.5
    with blender.override():
        blender.expect(bpy.ops.lappet.solve("INVOKE_DEFAULT") != {"CANCELLED"}, "a click solves it")
    states = lambda: {frames.frame_state(scene, t) for t in range(scene.frame_start, scene.frame_end + 1)}  # noqa: E731
    yield from blender.wait_until(lambda: states() == {"solved"}, 280.0, "all frames are solved")
    scene.frame_set(scene.frame_end)
    yield 2.0
    blender.expect(skin_of(scene) is not None, "the skin is shown")
    yield from blender.screenshot("solved_flap")
    yield from presets(blender)


def presets(blender: Driver) -> Steps:
    """A look and a skin are kept under a name, changed, and taken again from their menus."""
    look, material = bpy.context.scene.lappet.look, bpy.context.scene.lappet.materials[0]
    look.color, look.show_legend = "STRAIN", False
    material.youngs_modulus = 77.0
    with blender.override():
        bpy.ops.lappet.look_preset_add(name="Mine")
        bpy.ops.lappet.skin_preset_add(name="My skin")
    look.color, look.show_legend = "PLAIN", True
    material.youngs_modulus = 20.0
    yield 0.5
    for kind, menu in (("look", "LAPPET_PT_look_presets"), ("skin", "LAPPET_PT_skin_presets")):
        folder = next(Path(each) for each in bpy.utils.preset_paths(f"lappet/{kind}"))
        (file,) = folder.glob("*.py")
        yield from blender.move(blender.within(0.5, 0.5))
        with blender.override():
            bpy.ops.wm.call_panel(name=menu)
        yield from blender.screenshot(f"presets_{kind}")
        yield from blender.key("ESC")
        with blender.override():
            bpy.ops.script.execute_preset(filepath=str(file), menu_idname=menu)
        yield 0.5
    blender.expect(look.color == "STRAIN" and not look.show_legend, "the look is the one that was kept")
    blender.expect(abs(material.youngs_modulus - 77.0) < 1e-3, "the skin is the one that was kept")
    yield from blender.screenshot("preset_taken")


if __name__ == "__main__":
    run(scenario, limit=400.0)
