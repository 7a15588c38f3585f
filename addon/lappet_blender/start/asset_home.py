"""The asset library while the extension is enabled: written once in the extension's own folder, and named to Blender.

Who takes it out keeps it out (`LappetPreferences.offers_assets`). A library of the name that lies elsewhere is the
user's own, put there by the operator: it is neither moved nor taken out. Blender disables extensions when it ends too,
after it has saved the preferences; so nothing is deleted here.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
from collections.abc import Iterator
from pathlib import Path

import bpy

from lappet.core.version import version

from ..model.made_soon import MadeSoon
from ..solving.chosen_daemon import ADDON
from .asset_items import asset_items
from .asset_library import LIBRARY, OTHERS, Pictures, asset_pictures, register_library, unregister_library, write_assets

MM = 1.0  # millimeters per unit of the scenes that it is written for; in others plans are scaled when dropped
_WRITTEN = "written.txt"
_FIRST, _AGAIN = 1.0, 0.2  # seconds
_log = logging.getLogger(__name__)
_pictures: list[MadeSoon[Pictures]] = []


def assets_folder(create: bool = True) -> Path:
    """The folder of the library in the extension's own."""
    try:
        return Path(bpy.utils.extension_path_user(ADDON, path="assets", create=create))
    except ValueError:  # not installed as an extension
        return Path(bpy.utils.user_resource("DATAFILES", path="lappet_assets", create=create))


def wants_assets(preferences: bpy.types.Preferences) -> bool:
    """Whether the user has not taken the library out."""
    entry = preferences.addons.get(ADDON)
    return entry is None or entry.preferences is None or bool(entry.preferences.offers_assets)


def want_assets(preferences: bpy.types.Preferences, wanted: bool) -> None:
    """Remember it."""
    entry = preferences.addons.get(ADDON)
    if entry is not None and entry.preferences is not None:
        entry.preferences.offers_assets = wanted


def is_current(folder: Path) -> bool:
    """Whether the folder holds the library as this version of the extension and of Blender writes it."""
    written = folder / _WRITTEN
    return (folder / OTHERS).is_file() and written.is_file() and written.read_text(encoding="utf-8") == _stamp()


def put_assets(folder: Path, pictures: Pictures | None = None) -> int:
    """Write the library there, with a note of what it was written by; the number of its assets."""
    (folder / _WRITTEN).unlink(missing_ok=True)
    count = write_assets(folder, MM, pictures)
    (folder / _WRITTEN).write_text(_stamp(), encoding="utf-8")
    return count


def name_library(preferences: bpy.types.Preferences, folder: Path) -> bool:
    """Have the preferences name the library unless they name one; whether it was added. They do not become unsaved."""
    if preferences.filepaths.asset_libraries.get(LIBRARY) is not None:
        return False
    with _unmarked(preferences):
        register_library(preferences, folder)
    return True


def forget_library(preferences: bpy.types.Preferences, folder: Path) -> bool:
    """Take the library out of the preferences where it is the one in this folder; whether it was."""
    known = preferences.filepaths.asset_libraries.get(LIBRARY)
    if known is None or Path(bpy.path.abspath(known.path)) != folder:
        return False
    with _unmarked(preferences):
        unregister_library(preferences)
    return True


@contextlib.contextmanager
def _unmarked(preferences: bpy.types.Preferences) -> Iterator[None]:
    """What is done by itself is no reason to save the preferences when Blender ends."""
    before = preferences.is_dirty
    yield
    preferences.is_dirty = before


def _stamp() -> str:
    offered = "\n".join(f"{each.tag} {each.title} {each.description}" for each in asset_items())
    return f"{version()} {bpy.app.version_string} {hashlib.sha256(offered.encode()).hexdigest()}"


def _offer() -> float | None:
    """Write the library where it is missing, its pictures drawn on a thread, and name it; a timer's step."""
    preferences = bpy.context.preferences
    known = preferences.filepaths.asset_libraries.get(LIBRARY)
    elsewhere = known is not None and Path(bpy.path.abspath(known.path)) != assets_folder(create=False)
    if elsewhere or not wants_assets(preferences):
        return None
    if bpy.app.is_job_running("RENDER"):
        return _FIRST
    try:
        folder = assets_folder()
        if not is_current(folder):
            if not _pictures:
                _pictures.append(MadeSoon(asset_pictures))
            if not _pictures[0].done:
                return _AGAIN
            put_assets(folder, _pictures.pop().take())
        name_library(preferences, folder)
    except (OSError, RuntimeError) as error:  # a full disk costs the library, and nothing else
        _log.warning("The asset library cannot be written: %s", error)
    return None


def register() -> None:
    """Offer the library, once Blender has started; scripts without a window have no use for it."""
    if not bpy.app.background:
        bpy.app.timers.register(_offer, first_interval=_FIRST, persistent=True)


def unregister() -> None:
    """Take the library's name back; its files go with the extension's folder."""
    if bpy.app.timers.is_registered(_offer):
        bpy.app.timers.unregister(_offer)
    _pictures.clear()
    if not bpy.app.background:
        forget_library(bpy.context.preferences, assets_folder(create=False))
