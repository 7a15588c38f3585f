"""Draws the figures of a solved procedure without a window: `python -m lappet_blender.figure CACHE.usdc -o DIR`.

Standard output carries one JSON object a line: `{"picture": path, "number": k, "of": n}` for every picture written,
then `{"done": true}`; a refusal is `{"error": sentence}` and exit status 1. Blender's own messages go to standard
error.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

if hasattr(bpy.utils, "expose_bundled_modules"):
    bpy.utils.expose_bundled_modules()

from .caption import halved, load_picture, save_picture
from .figure_scene import (
    ENGINES,
    add_backdrop,
    add_camera,
    add_lights,
    clear_scene,
    half_angles,
    render_png,
    set_render,
    set_size,
)
from .figure_steps import Step, step_captions, story_steps
from .filmstrip import write_filmstrip
from .framing import VIEWS, Region, surgical_region, viewpoint
from .hook_steel import HookSteel
from .movie import encode_mp4
from .quantity_key import draw_key, full_scale
from .skin_import import SkinObject, add_bed
from .skin_material import (
    backdrop_material,
    bed_material,
    edge_material,
    fat_material,
    ink_material,
    rim_material,
    skin_material,
    steel_material,
    thread_material,
    wall_material,
)
from .skin_read import SCALARS, FigureError, SkinCache
from .suture_thread import SutureThread
from .wound_edge import PlannedIncision, WoundEdge

Report = Callable[[Path, int, int], None]
COLORS = ("plain", "grid", *SCALARS)


@dataclass(frozen=True)
class FigureRequest:
    """What to draw. frames: stills to write, None: the last. size: of stills; panel: of filmstrip panels; pixels."""

    cache: Path
    out: Path
    frames: tuple[float, ...] | None = None
    filmstrip: bool = True
    animation: str = "none"
    size: tuple[int, int] = (1280, 960)
    panel: tuple[int, int] = (640, 480)
    samples: int = 10
    engine: str = "cycles"
    view: str = "oblique"
    color: str = "grid"
    threads: int = 0


class Plate:
    """The scene of one cache: shows a frame and renders it."""

    def __init__(self, cache: SkinCache, region: Region, request: FigureRequest) -> None:
        self._cache, self._request = cache, request
        clear_scene()
        scalar = request.color if request.color in SCALARS else None
        self._highest = full_scale(cache, scalar) if scalar else 1.0
        view = viewpoint(region, request.view, half_angles(request.size))
        pixel = 2 * view.distance * half_angles(request.size)[0] / request.size[0]
        materials = [
            skin_material(request.color, pixel, self._highest),
            wall_material(),
            fat_material(),
            rim_material(),
        ]
        self._skin = SkinObject(cache, materials, scalar)
        self._parts = (
            self._skin,
            WoundEdge(cache, edge_material()),
            PlannedIncision(cache, ink_material()),
            SutureThread(cache, thread_material()),
            HookSteel(cache, steel_material(), region.normal, region.centre),
        )
        add_bed(cache, bed_material())
        first = cache.positions(cache.epochs[0], cache.epochs[0].frames[0]).astype(np.float64)
        lowest = float((first @ region.normal).min()) - 1.0
        add_backdrop(region, lowest, backdrop_material())
        add_lights(region)
        add_camera(view)
        set_render(request.engine, request.samples, request.threads)

    def render(self, time: float, size: tuple[int, int], path: Path) -> None:
        """Write a PNG of a frame."""
        for part in self._parts:
            part.show(time)
        set_size(size)
        render_png(path)
        if self._request.color in SCALARS:
            draw_key(path, self._request.color, self._highest)


def draw_figures(request: FigureRequest, report: Report = lambda path, number, of: None) -> list[Path]:
    """Draw everything that a request asks for, in one Blender scene, and return the files written.

    report: called with each file as it is done, its number and the count of all. Raises FigureError.
    """
    cache = SkinCache(request.cache)
    stills = request.frames if request.frames is not None else (cache.frames[-1],)
    for frame in stills:
        cache.epoch_at(frame)
    steps = _steps(cache, request) if request.filmstrip else []
    movie = cache.frames if request.animation != "none" else ()
    region = surgical_region(cache, tuple(sorted({*stills, *(s.frame for s in steps), *movie, cache.frames[-1]})))
    _make_folder(request.out)
    plate = Plate(cache, region, request)
    total = len(stills) + len(steps) + bool(steps) + len(movie) + (request.animation == "mp4")
    written: list[Path] = []

    def done(path: Path) -> None:
        written.append(path)
        report(path, len(written), total)

    drawn: dict[float, Path] = {}
    for frame in stills:
        path = request.out / f"frame_{frame:04g}.png"
        plate.render(frame, request.size, path)
        drawn[frame] = path
        done(path)
    if steps:
        done_panels = []
        for number, step in enumerate(steps, start=1):
            path = request.out / f"step_{number}.png"
            if step.frame in drawn and request.size == (2 * request.panel[0], 2 * request.panel[1]):
                save_picture(halved(load_picture(drawn[step.frame])), path)
            else:
                plate.render(step.frame, request.panel, path)
            done_panels.append(path)
            done(path)
        sheet = request.out / "filmstrip.png"
        write_filmstrip(done_panels, steps, sheet)
        done(sheet)
    if movie:
        folder = request.out / "frames"
        _make_folder(folder)
        pictures = []
        for number, frame in enumerate(movie, start=1):
            path = folder / f"{number:04d}.png"
            plate.render(frame, request.size, path)
            pictures.append(path)
            done(path)
        if request.animation == "mp4":
            film = request.out / "animation.mp4"
            encode_mp4(pictures, request.size, cache.fps, film)
            done(film)
    return written


def _steps(cache: SkinCache, request: FigureRequest) -> list[Step]:
    if request.frames is not None and len(request.frames) > 1:
        return step_captions(cache.events, request.frames)

    def height(time: float) -> float:
        hooks = cache.hooks(time)
        return float(hooks.ends[hooks.active, 0, 2].mean()) if hooks.active.any() else 0.0

    return story_steps(cache.events, cache.frames, height)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FigureError(
            f"Pictures cannot be written to {folder} ({error.strerror}); choose another folder."
        ) from error


def _size(text: str) -> tuple[int, int]:
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 1280x960") from error
    if not (16 <= width <= 16384 and 16 <= height <= 16384):
        raise argparse.ArgumentTypeError(f"{text} is outside 16x16 to 16384x16384 pixels")
    return width, height


def _frames(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of frames such as 1,10,20") from error


def parse_request(arguments: list[str] | None = None) -> FigureRequest:
    """The request of a command line; argparse ends the process with status 2 on misuse."""
    parser = argparse.ArgumentParser(
        prog="python -m lappet_blender.figure", description="Draw a skin cache with Blender."
    )
    parser.add_argument("cache", type=Path)
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--frames", type=_frames)
    parser.add_argument("--filmstrip", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--animation", choices=("mp4", "png", "none"), default="none")
    parser.add_argument("--size", type=_size, default=(1280, 960))
    parser.add_argument("--panel", type=_size)
    parser.add_argument("--samples", type=int, default=10)
    parser.add_argument("--engine", choices=tuple(ENGINES), default="cycles")
    parser.add_argument("--view", choices=tuple(VIEWS), default="oblique")
    parser.add_argument("--color", choices=COLORS, default="grid")
    parser.add_argument("--threads", type=int, default=0)
    values = vars(parser.parse_args(arguments))
    panel = values.pop("panel")
    request = FigureRequest(panel=(640, 480), **values)
    return replace(request, panel=panel or (max(16, request.size[0] // 2), max(16, request.size[1] // 2)))


def main(arguments: list[str] | None = None) -> int:
    """Draw figures as the command line asks; returns the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # an interrupt ends a long render at once
    request = parse_request(arguments)
    lines = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
    os.dup2(2, 1)  # Blender prints to standard output; keep that for progress

    def say(**message: object) -> None:
        lines.write(json.dumps(message) + "\n")
        lines.flush()

    try:
        draw_figures(request, lambda path, number, of: say(picture=str(path), number=number, of=of))
    except FigureError as error:
        say(error=str(error))
        return 1
    say(done=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
