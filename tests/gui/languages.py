"""The interface in each language that it is translated into, in a real window: `run.py languages.py`."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from large import sheet
from panels import pages, unfold
from tools import MODULE, height, prepare

LANGUAGES = {"de": ("de_DE",), "fr": ("fr_FR",), "es": ("es", "es_ES"), "zh": ("zh_HANS", "zh_CN")}
SOLVE = {"de": "Rechnen", "fr": "Calculer", "es": "Calcular", "zh": "求解"}


def speak(language: str) -> bool:
    """Has Blender speak a language; whether it can."""
    view = bpy.context.preferences.view
    for name in LANGUAGES[language]:
        try:
            view.language = name
        except TypeError:  # this version calls it otherwise, or was built without it
            continue
        view.use_translate_interface = view.use_translate_tooltips = True
        return True
    return False


def scenario(blender: Driver) -> Steps:
    """A solved flap; the sidebar from top to bottom, the menu and the bars of a tool in each language."""
    yield from prepare(blender)
    scene, ops = bpy.context.scene, bpy.ops.lappet
    frames = import_module(f"{MODULE}.solving.frames")
    scene.frame_end = 5
    made = sheet(31, 21)
    with blender.override():
        ops.tissue_set(object=made.name, thickness=5.0, spacing=2.5)
    bpy.data.objects.remove(bpy.data.objects["block"])
    flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
    ops.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
    ops.hook_add(anchor=height(4, 5), target=(4, 6, 6), start=3.0, arrive=1.0)
    unfold()
    yield from blender.show_tab("Lappet")
    ops.solve("INVOKE_DEFAULT")
    yield from blender.wait_until(lambda: frames.frame_state(scene, 5) == "solved", 90.0, "it is solved")
    scene.lappet.look.color = "TENSION"
    for language in LANGUAGES:
        if not blender.expect(speak(language), f"Blender speaks {language}"):
            continue
        yield 0.5
        said = bpy.app.translations.pgettext_iface("Solve", "Operator")
        blender.expect(said == SOLVE[language], f"{language}: Solve is {said}")
        yield from blender.set_tool("lappet.suture")
        yield from pages(blender, language, 4)
        yield from blender.set_tool("lappet.cutting.incision")
        yield from blender.move(blender.at(height(-20, -8)))
        yield from blender.click(blender.at(height(-20, -8)))
        yield from blender.screenshot(f"{language}_tool")
        yield from blender.key("ESC")
        with blender.override():
            bpy.ops.wm.call_menu(name="LAPPET_MT_event_add")
        yield from blender.screenshot(f"{language}_menu")
        yield from blender.key("ESC")


if __name__ == "__main__":
    run(scenario, limit=400.0)
