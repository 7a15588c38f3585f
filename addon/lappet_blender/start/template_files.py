"""The application template *Lappet* in the user's scripts: written, found and taken away. Knows no window."""

from __future__ import annotations

import importlib
import shutil
from pathlib import Path

import bpy

NAME = "Lappet"
_FOLDER = Path("startup") / "bl_app_templates_user"
# Blender reads it as a module of its own when the template is chosen, whether the extension is enabled or not.
_SOURCE = '''"""Start with a patch of skin and a first operation. The extension Lappet writes and removes this."""

import importlib

import bpy
from bpy.app.handlers import persistent

ADDON = {addon!r}


@persistent
def _begin(_file):
    """Fill the factory's new file; one of the user's own (File > Defaults > Save Startup File) stays as it is."""
    import addon_utils

    if not addon_utils.check(ADDON)[1] and addon_utils.enable(ADDON) is None:
        print("Lappet: the extension", ADDON, "is not installed, so this file is Blender's own.")
        return
    importlib.import_module(ADDON + ".start.first_scene").begin()


def register():
    bpy.app.handlers.load_factory_startup_post.append(_begin)


def unregister():
    bpy.app.handlers.load_factory_startup_post.remove(_begin)
'''


def templates_folder() -> Path:
    """Where the user's application templates are; made where it is missing."""
    return Path(bpy.utils.user_resource("SCRIPTS", path=str(_FOLDER), create=True))


def template_folder() -> Path:
    """The folder of this template, whether it is there or not."""
    return Path(bpy.utils.user_resource("SCRIPTS", path=str(_FOLDER))) / NAME


def write_template(addon: str) -> Path:
    """Write the template, and return its folder. addon: the extension's module, as Blender calls it."""
    folder = templates_folder() / NAME
    folder.mkdir(exist_ok=True)
    source = folder / "__init__.py"
    fresh = source.with_suffix(".new")
    fresh.write_text(_SOURCE.format(addon=addon), encoding="utf-8")
    fresh.replace(source)
    bpy.utils.refresh_script_paths()  # the folder of scripts may be new
    importlib.invalidate_caches()
    return folder


def is_written() -> bool:
    """Whether the template is there."""
    return (template_folder() / "__init__.py").is_file()


def remove_template() -> bool:
    """Take the template away; whether it was there."""
    there = is_written()
    if there:
        shutil.rmtree(template_folder())
    return there
