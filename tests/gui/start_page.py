"""File > New > Lappet, the asset library and the panels of presets in a real window: `run.py start_page.py`."""

from __future__ import annotations

import os
import sys
import time
from importlib import import_module
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from panels import pages, unfold
from tools import MODULE


def scenario(blender: Driver) -> Steps:
    """Installs, begins a file, drops assets, looks at the panel Plate."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    yield from at_home(blender)
    blender.expect(bpy.ops.lappet.template_install() == {"FINISHED"}, "the template is installed")
    templates = [Path(each).name for each in bpy.utils.app_template_paths()]
    blender.notes["template folders"] = templates
    unfold()
    bpy.ops.wm.read_homefile("EXEC_DEFAULT", app_template="Lappet")
    yield 2.0
    yield from first_file(blender)
    yield from assets(blender)
    yield from plate(blender)


def named() -> list[str]:
    """The asset libraries that the preferences name."""
    return [each.name for each in bpy.context.preferences.filepaths.asset_libraries]


def at_home(blender: Driver) -> Steps:
    """Enabled, the extension names its library and offers its template; disabled, it leaves no trace."""
    blender.notes["libraries before"] = before = [each for each in named() if each != "Lappet"]
    began = time.monotonic()
    yield from blender.wait_until(lambda: "Lappet" in named(), 30.0, "the asset library names itself when enabled")
    blender.notes["seconds until the library is there"] = round(time.monotonic() - began, 1)
    yield from blender.show_tab("Lappet")
    yield from blender.screenshot("offer")
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield 0.5
    blender.expect(named() == before, f"disabled, the extension leaves the libraries as they were: {named()}")
    bpy.ops.preferences.addon_enable(module=MODULE)
    began = time.monotonic()
    yield from blender.wait_until(lambda: "Lappet" in named(), 10.0, "enabled again, it is there at once")
    blender.notes["seconds when it is written already"] = round(time.monotonic() - began, 1)
    with blender.override():
        bpy.ops.lappet.assets_remove()
    bpy.ops.preferences.addon_disable(module=MODULE)
    bpy.ops.preferences.addon_enable(module=MODULE)
    yield 3.0
    blender.notes["after it was taken out"] = named()
    blender.expect(bpy.ops.lappet.assets_install() == {"FINISHED"}, "who wants it back adds it")
    yield 0.3


def first_file(blender: Driver) -> Steps:
    """What the new file holds."""
    scene = bpy.context.window_manager.windows[0].scene
    blender.expect(hasattr(scene, "lappet"), "the extension is enabled in the template")
    blender.expect(scene.lappet.tissue.object is not None, "there is a tissue")
    blender.expect(len(scene.lappet.events) > 3, f"there is an operation of {len(scene.lappet.events)} events")
    blender.expect(scene.camera is not None, "there is a camera")
    display = import_module(f"{MODULE}.display.skin_display")
    yield from blender.wait_until(lambda: display.skin_object(scene) is not None, 60.0, "its skin is shown")
    name = blender.window.workspace.name
    blender.expect(name == "Lappet", f"the workspace is called {name}")
    height = blender.area("DOPESHEET_EDITOR").height
    blender.expect(height > 200, f"the Timeline has room for strips: {height} pixels")
    yield from blender.screenshot("first_file")


def assets(blender: Driver) -> Steps:
    """The library in the asset browser."""
    blender.expect("Lappet" in named(), f"the preferences name it in the template too: {named()}")
    area = blender.area("DOPESHEET_EDITOR")
    area.ui_type = "ASSETS"
    yield 1.0
    area.spaces.active.params.asset_library_reference = "Lappet"
    yield 3.0
    yield from blender.screenshot("assets")
    scene = blender.window.scene
    count = len(scene.lappet.events)
    library = bpy.context.preferences.filepaths.asset_libraries["Lappet"].path
    with blender.override():
        bpy.ops.wm.append(directory=f"{library}/lappet.blend/Object/", filename="Hook")
    yield from blender.wait_until(
        lambda: len(scene.lappet.events) == count + 1, 3.0, "an asset that is appended is taken up: a hook is set"
    )
    left = [each.name for each in scene.objects if "lappet_asset" in each]
    blender.expect(not left, f"and the object that stood for it is gone: {left}")
    yield from one_of_each(blender, library)
    area.ui_type = "TIMELINE"
    yield 0.3


def one_of_each(blender: Driver, library: str) -> Steps:
    """One asset of every kind is dropped; a model into a scene of its own, since it brings its tissue."""
    scene = blender.window.scene
    items = import_module(f"{MODULE}.start.asset_items").asset_items()
    threads = import_module(f"{MODULE}.model.event_kinds").THREAD_OF
    events = scene.lappet.events

    def drop(kind: str, name: str, file: str = "lappet.blend") -> Steps:
        title = next((each.title for each in items if (each.kind, each.name) == (kind, name)), name)
        with blender.override():
            bpy.ops.wm.append(directory=f"{library}/{file}/Object/", filename=title)
        yield 0.5
        for _ in range(60):  # a busy machine takes its time
            if not any("lappet_asset" in each for each in blender.window.scene.objects):
                break
            yield 0.25
        yield 0.5

    scene.lappet.active_event = next(i for i, each in enumerate(events) if each.kind in ("SUTURE", "SUTURE_RUN"))
    sewn = events[scene.lappet.active_event].name
    yield from drop("thread", "nylon 4-0")
    found = events[sewn]
    blender.expect(threads.get(found.thread) == "nylon 4-0" and found.mode == "THREAD", f"a thread: {found.thread}")
    count = len(events)
    yield from drop("instrument", "landmark")
    blender.expect(len(events) == count + 1 and events[-1].kind == "LANDMARK", "a landmark is placed")
    yield from drop("material", "fat")
    yield from drop("material", "fat")
    names = [each.name for each in scene.lappet.materials]
    blender.expect("fat_2" not in names, f"one that is there already is used: {names}")
    blender.expect(scene.lappet.tissue.material.startswith("fat"), f"a material: {scene.lappet.tissue.material}")
    plates = len(scene.lappet.pages)
    yield from drop("plate", "steps")
    blender.expect(len(scene.lappet.pages) == plates + 1, "a plate is added")
    yield from drop("flap", "Limberg flap", "flaps.blend")
    blender.expect("Limberg flap" in scene.objects, "a flap's plan lies in the scene, to be turned, scaled and laid")
    yield from blender.screenshot("dropped")
    yield from drop("model", "patch")
    names = [each.name for each in scene.objects if "lappet_asset" in each]
    blender.expect(not names, f"a model is refused where there is a tissue, and its object is gone: {names}")
    fresh = bpy.data.scenes.new("Second")
    blender.window.scene = fresh
    yield 0.5
    yield from drop("model", "patch")
    yield 3.0
    blender.expect(fresh.lappet.tissue.object is not None, "into an empty scene a model brings its tissue")
    yield from blender.screenshot("dropped_model")
    blender.window.scene = scene
    yield 0.5


def plate(blender: Driver) -> Steps:
    """The panels Plate, Materials and Look, with their presets."""
    with blender.override():
        bpy.ops.lappet.plate_add("EXEC_DEFAULT", True, template="steps")
        corner = tuple(blender.window.scene.lappet.events[0].points[0].co)
        bpy.ops.lappet.annotation_add("EXEC_DEFAULT", True, kind="label", points=[{"name": "", "co": corner}])
    yield from blender.show_tab("Lappet")
    yield from pages(blender, "panels", 8)
    view = bpy.context.preferences.view
    view.language = "de_DE"
    view.use_translate_interface = view.use_translate_tooltips = True
    say = bpy.app.translations.pgettext_iface
    blender.expect(say("Flap Library") == "Lappensammlung", f"Blender says it in German: {say('Flap Library')}")
    context = bpy.types.LAPPET_PT_solve.bl_translation_context
    solve = bpy.app.translations.pgettext_iface("Solve", context)
    blender.expect(solve == "Rechnen", f"the panel of solving is called so, and not as in tracking: {solve}")
    yield from pages(blender, "german", 2)


if __name__ == "__main__":
    run(scenario)
