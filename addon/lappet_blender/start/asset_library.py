"""Write the asset library and let Blender's asset browser show it.

Assets stand for what the product makes: an object that says which (`TAG`). Dropped into a scene it is taken up at once
(`asset_operators`). Flaps are plans to scale, as in `events.flap_assets`.
"""

from __future__ import annotations

import uuid
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from ..events.flap_assets import CATALOGS, FILE, plan_pictures, write_library
from .asset_items import CATALOGS as FOLDERS
from .asset_items import SIZE, AssetItem, asset_items, picture

LIBRARY = "Lappet"
OTHERS = "lappet.blend"
TAG = "lappet_asset"  # custom property of an object: what it stands for
Pictures = dict[str, NDArray[np.float32]]  # (SIZE, SIZE, 4), from below
_NAMESPACE = uuid.UUID("6f3c1a2e-0d57-4b3c-9a55-3f0c1d0f8b11")  # that of the flaps' catalog


def asset_pictures() -> Pictures:
    """The pictures of all assets, by tag and by design; touches nothing of Blender's."""
    return {**{item.tag: picture(item) for item in asset_items()}, **plan_pictures()}


def write_assets(folder: Path, mm: float, pictures: Pictures | None = None) -> int:
    """Write the library and return the number of its assets.

    mm: millimeters per unit of the scenes that it is for. pictures: as of `asset_pictures`, None to draw them here.
    """
    folder.mkdir(parents=True, exist_ok=True)
    drawn = asset_pictures() if pictures is None else pictures
    write_library(folder, mm, drawn)  # its file of catalogs holds that of flaps alone
    catalogs = folder / CATALOGS
    lines = [catalogs.read_text(encoding="utf-8").rstrip()]
    lines.append(f"{_catalog(LIBRARY)}:{LIBRARY}:{LIBRARY}")  # above the others
    lines += [f"{_catalog(path)}:{path}:{path.replace('/', '-')}" for path in FOLDERS.values()]
    catalogs.write_text("\n".join([*lines, ""]), encoding="utf-8")
    items = asset_items()
    made = [_asset(item, drawn[item.tag]) for item in items]
    try:
        bpy.data.libraries.write(str(folder / OTHERS), set(made), fake_user=True, compress=True)
    finally:
        for obj in made:
            bpy.data.objects.remove(obj)
    with bpy.data.libraries.load(str(folder / FILE), assets_only=True) as (there, _):
        flaps = len(there.objects)
    return len(items) + flaps


def register_library(preferences: bpy.types.Preferences, folder: Path) -> None:
    """Have the preferences name a folder as the library; one of that name is moved there."""
    libraries = preferences.filepaths.asset_libraries
    known = libraries.get(LIBRARY)
    if known is None:
        known = libraries.new(name=LIBRARY, directory=str(folder))
    known.path = str(folder)
    known.import_method = "APPEND"


def unregister_library(preferences: bpy.types.Preferences) -> bool:
    """Take the library's name out of the preferences; whether it was there."""
    libraries = preferences.filepaths.asset_libraries
    known = libraries.get(LIBRARY)
    if known is not None:
        libraries.remove(known)
    return known is not None


def is_registered(preferences: bpy.types.Preferences) -> bool:
    """Whether the preferences name the library and it is there."""
    known = preferences.filepaths.asset_libraries.get(LIBRARY)
    return known is not None and (Path(bpy.path.abspath(known.path)) / OTHERS).is_file()


def _catalog(path: str) -> str:
    return str(uuid.uuid5(_NAMESPACE, path))


def _asset(item: AssetItem, pixels: NDArray[np.float32]) -> bpy.types.Object:
    obj = bpy.data.objects.new(item.title, None)
    obj.empty_display_type, obj.empty_display_size = "SPHERE", 1.0
    obj[TAG] = item.tag
    obj.asset_mark()
    data = obj.asset_data
    data.description, data.author = item.description, "Lappet"
    data.catalog_id = _catalog(FOLDERS[item.kind])
    data.tags.new(item.kind)
    preview = obj.preview_ensure()
    preview.image_size = (SIZE, SIZE)
    preview.image_pixels_float[:] = pixels.ravel().tolist()
    return obj
