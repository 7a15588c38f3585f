"""Renders the current frame of a scene to a PNG file."""

from __future__ import annotations

from pathlib import Path

import bpy

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode

from . import skin_display


def render_still(scene: bpy.types.Scene, filepath: str) -> Problem | None:
    """Render the current frame to a .png file.

    Return what is to be said about it: that it shows another frame. Raises RefusedError where there is no camera or no
    such folder.
    """
    if filepath.startswith("//") and not bpy.data.filepath:
        raise refused(ProblemCode.PICTURE_BESIDE_NOTHING, "", filepath)
    path = Path(bpy.path.abspath(filepath)) if filepath else None
    if path is None or path.suffix.lower() != ".png":
        raise refused(ProblemCode.PICTURE_NAME, "", filepath)
    if scene.camera is None:
        raise refused(ProblemCode.PICTURE_NO_CAMERA, scene.name)
    if not path.parent.is_dir():
        raise refused(ProblemCode.FILE_NO_FOLDER, "", path.parent)
    before = scene.render.filepath
    kept = scene.render.image_settings.file_format
    try:
        if hasattr(scene.render.image_settings, "media_type"):
            scene.render.image_settings.media_type = "IMAGE"
        scene.render.image_settings.file_format = "PNG"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise refused(ProblemCode.FILE_NOT_WRITTEN, path, str(error).strip(), folder=path.parent) from error
    finally:
        scene.render.filepath = before
        scene.render.image_settings.file_format = kept
    if not path.is_file():
        raise refused(ProblemCode.FILE_NOT_WRITTEN, path, "Blender wrote no picture", folder=path.parent)
    return another_frame(scene)


def another_frame(scene: bpy.types.Scene) -> Problem | None:
    """Return that a picture shows an earlier frame or the tissue at rest; None where it shows the frame itself."""
    shown = skin_display.shown_of(scene, scene.frame_current)
    if shown is None or (shown.frame is not None and not shown.stale):
        return None
    older = "an older solve of it" if shown.time == scene.frame_current else f"frame {shown.time}"
    instead = "the tissue at rest" if shown.frame is None else older
    return problem(ProblemCode.PICTURE_NOT_SOLVED, "", scene.frame_current, shown=instead)
