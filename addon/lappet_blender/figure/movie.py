"""Write an animation: one PNG a frame, or an MP4 (H.264) through Blender's own ffmpeg."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy

from lappet.drawing.skin_source import FigureError


def encode_mp4(pictures: Sequence[Path], size: tuple[int, int], fps: float, path: Path) -> None:
    """Encode PNG pictures of one size as an MP4. fps: frames a second; sides are cut to even numbers, as H.264 asks.

    Raises FigureError when Blender's ffmpeg writes nothing.
    """
    scene = bpy.data.scenes.new("Movie")
    try:
        editor = scene.sequence_editor_create()
        strips = editor.strips if hasattr(editor, "strips") else editor.sequences
        strip = strips.new_image("Pictures", str(pictures[0]), 1, 1, fit_method="ORIGINAL")
        for picture in pictures[1:]:
            strip.elements.append(picture.name)
        strip.frame_final_duration = len(pictures)
        scene.frame_start, scene.frame_end = 1, len(pictures)
        render = scene.render
        render.resolution_x, render.resolution_y = size[0] - size[0] % 2, size[1] - size[1] % 2
        render.resolution_percentage = 100
        render.fps, render.fps_base = max(1, round(fps)), max(1, round(fps)) / fps
        scene.view_settings.view_transform = "Standard"
        if hasattr(render.image_settings, "media_type"):
            render.image_settings.media_type = "VIDEO"
        render.image_settings.file_format = "FFMPEG"
        render.ffmpeg.format, render.ffmpeg.codec = "MPEG4", "H264"
        render.ffmpeg.constant_rate_factor, render.ffmpeg.gopsize = "HIGH", 12
        render.use_file_extension = False
        draft = path.with_name(f".{path.stem}.part.mp4")
        render.filepath = str(draft)
        bpy.ops.render.render(animation=True, scene=scene.name)
        if not draft.is_file() or draft.stat().st_size == 0:
            raise FigureError(f"Blender's ffmpeg wrote no movie to {path}; ask for a PNG sequence (--animation png).")
        draft.replace(path)
    finally:
        bpy.data.scenes.remove(scene)
