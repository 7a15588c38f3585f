"""Renders the current frame of a scene to a PNG file."""

from __future__ import annotations

from pathlib import Path

import bpy

from lappet.core.problem import RefusedError


def render_still(scene: bpy.types.Scene, filepath: str) -> None:
    """Render the current frame to a .png file. Raises RefusedError where there is no camera or no such folder."""
    path = Path(bpy.path.abspath(filepath)) if filepath else None
    if path is None or path.suffix.lower() != ".png":
        raise RefusedError(f"The picture's name {filepath!r} does not end in .png; give a .png file.")
    if scene.camera is None:
        raise RefusedError(f"The scene {scene.name} has no camera; press Set Stage or add one.")
    if not path.parent.is_dir():
        raise RefusedError(f"There is no folder {path.parent}; make it or choose another file.")
    before = scene.render.filepath
    kept = scene.render.image_settings.file_format
    try:
        if hasattr(scene.render.image_settings, "media_type"):
            scene.render.image_settings.media_type = "IMAGE"
        scene.render.image_settings.file_format = "PNG"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise RefusedError(
            f"{path} was not written: {str(error).strip()}; see whether the folder is writable."
        ) from error
    finally:
        scene.render.filepath = before
        scene.render.image_settings.file_format = kept
    if not path.is_file():
        raise RefusedError(f"Blender wrote no picture to {path}; see whether the folder is writable.")
