"""Draw the figures of a solved procedure without a window: `python -m lappet_blender.figure CACHE.usdc -o DIR`.

Standard output carries one JSON object a line: `{"picture": path, "number": k, "of": n}` for every picture written,
`{"note": line}` on how long an animation takes, then `{"done": true}`; a refusal is `{"error": sentence}` and exit
status 1. Blender's own messages go to standard error.
"""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import bpy
import numpy as np
from numpy.typing import NDArray

if hasattr(bpy.utils, "expose_bundled_modules"):
    bpy.utils.expose_bundled_modules()

from lappet.drawing.figure_steps import Step, hook_height, step_captions, story_steps
from lappet.drawing.framing import (
    VIEWS,
    SurgicalField,
    Viewpoint,
    field_on_body,
    half_angles,
    surgical_field,
    viewpoint_on_skin,
)
from lappet.drawing.hook_steel import HookSteel
from lappet.drawing.section_plane import SectionPlane
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.skin_marks import SkinMarks
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SCALARS, FigureError
from lappet.drawing.suture_thread import SutureThread, buried_sutures
from lappet.drawing.wound_edge import WoundEdge
from lappet.procedure import VESSEL_KINDS

from ..look.scenery import add_scenery
from ..look.skin_import import Bed, SkinObject
from ..look.skin_material import (
    TRANSLUCENT,
    backdrop_material,
    bed_material,
    edge_material,
    ink_material,
    lumen_material,
    mucosa_material,
    rim_material,
    skin_material,
    steel_material,
    thread_material,
    underside_material,
    vessel_material,
    wall_material,
)
from ..look.solid_texture import add_scale, add_tile
from ..look.vessel_tubes import VesselTubes
from .caption import load_picture, save_picture, shrunk
from .drawn_part import DrawnTubes, ScenePart
from .figure_messages import messages
from .figure_scene import (
    ENGINES,
    add_backdrop,
    add_camera,
    add_lights,
    clear_scene,
    figure_studio,
    render_png,
    set_render,
    set_size,
)
from .filmstrip import write_filmstrip
from .movie import encode_mp4
from .quantity_key import draw_key, full_scale
from .section_cut import BeforePlane, SectionDiscs, SectionFace, TubePart, TubesBefore

Report = Callable[[Path, int, int], None]
COLORS = ("plain", "grid", *SCALARS)


@dataclass(frozen=True)
class FigureRequest:
    """What to draw.

    frames: stills to write, None: the last. size: of stills; panel: of filmstrip panels; movie: of an animation; in
    pixels. samples, movie_samples: Cycles samples a pixel of stills and panels, and of an animation.
    translucent: whether vessels show through the skin. section: a plane beyond which everything is taken away; the
    tissue is then drawn alone.
    """

    cache: Path
    out: Path
    frames: tuple[float, ...] | None = None
    filmstrip: bool = True
    animation: str = "none"
    size: tuple[int, int] = (1280, 960)
    panel: tuple[int, int] = (560, 420)
    movie: tuple[int, int] = (640, 480)
    samples: int = 6
    movie_samples: int = 4
    engine: str = "cycles"
    view: str = "oblique"
    color: str = "grid"
    threads: int = 0
    translucent: bool = False
    section: SectionPlane | None = None


Tubes = tuple[str, TubePart, bpy.types.Material, int]


class Plate:
    """The scene of one cache: shows a frame and renders it."""

    def __init__(
        self,
        cache: SkinCache,
        field: SurgicalField,
        request: FigureRequest,
        frames: tuple[float, ...],
        hidden: frozenset[int],
    ) -> None:
        """frames: all that will be rendered. hidden: sutures that do not show on the skin."""
        self._cache, self._request = cache, request
        clear_scene()
        scalar = request.color if request.color in SCALARS else None
        self._highest = full_scale(cache, scalar) if scalar else 1.0
        # Beside cut tissue the rest of a body would hide it, or show that it is a hollow shell.
        scenery = () if request.section else cache.scenery
        first = cache.epoch_at(cache.frames[0])
        skin = cache.positions(first, cache.frames[0])[np.unique(first.triangles[first.origin == SKIN])]
        view = viewpoint_on_skin(field, request.view, half_angles(request.size), skin)
        pixel = 2 * view.distance * half_angles(request.size)[0] / request.size[0]
        opacity = TRANSLUCENT if request.translucent else 1.0
        materials = [
            skin_material(request.color, pixel, self._highest, opacity=opacity),
            wall_material(cache.layers, opacity=opacity),
            underside_material(cache.layers),
            mucosa_material() if scenery else rim_material(cache.layers),
        ]
        if request.color == "grid":
            add_tile(materials[0], request.color)
        elif scalar:
            add_scale(materials[0])
        skin, bed = SkinObject(cache, materials, scalar, self._highest), Bed(cache, bed_material())
        plane = request.section
        tubes = self._tubes(view, field, hidden)
        if plane is None:
            solid: tuple[ScenePart, ...] = (skin, bed)
        else:
            cut = SectionFace(cache, plane, wall_material(cache.layers))
            solid = (BeforePlane(skin, "Skin", plane), BeforePlane(bed, "Bed", plane), cut)
            tubes = [
                (name, TubesBefore(part, plane, isinstance(part, VesselTubes)), material, sides)
                for name, part, material, sides in tubes
            ]
            for kind in VESSEL_KINDS:
                tubes.append((f"Section: {kind}", SectionDiscs(cache, plane, kind), vessel_material(kind), 24))
            tubes.append(("Section: lumen", SectionDiscs(cache, plane, "", lumen=True), lumen_material(), 24))
        self._parts = (*solid, *(DrawnTubes(*each) for each in tubes))
        lowest = min(
            float((cache.positions(cache.epoch_at(t), t) @ field.normal).min()) for t in (cache.frames[0], *frames)
        )
        for mesh in scenery:
            lowest = min(lowest, float((mesh.points @ field.normal).min()))
        studio = figure_studio()
        add_scenery(scenery, studio.collection, pixel)
        add_backdrop(field, lowest - 1.5, backdrop_material(), studio)
        add_lights(field, studio)
        add_camera(view, studio)
        set_render(studio.scene, request.engine, request.threads, request.color != "plain")

    def _tubes(self, view: Viewpoint, field: SurgicalField, hidden: frozenset[int]) -> list[Tubes]:
        """What is drawn as tubes: name, part, material, sides."""
        cache, scale = self._cache, field.stitch_scale
        right = view.axes[0] - (view.axes[0] @ field.normal) * field.normal
        right /= np.linalg.norm(right)
        seen = np.stack([right, np.cross(field.normal, right), field.normal])
        threads = SutureThread(cache, 1.0 * seen[0] + 0.6 * seen[1], scale, hidden)
        return [
            ("Wound edge", WoundEdge(cache), edge_material(), 6),
            ("Marks", SkinMarks(cache), ink_material(), 6),
            ("Sutures", threads, thread_material(), 8),
            *((f"Vessels: {kind}", VesselTubes(cache, kind), vessel_material(kind), 20) for kind in VESSEL_KINDS),
            ("Vessels: lumen", VesselTubes(cache, "", lumen=True), lumen_material(), 20),
            ("Hooks", HookSteel(cache, seen, field.center, scale), steel_material(), 16),
        ]

    def render(self, time: float, size: tuple[int, int], samples: int, path: Path) -> None:
        """Write a PNG of a frame."""
        for part in self._parts:
            part.show(time)
        set_size(size, samples)
        render_png(path)
        if self._request.color in SCALARS:
            draw_key(path, self._request.color, self._highest)


def draw_figures(
    request: FigureRequest,
    report: Report = lambda path, number, of: None,
    note: Callable[[str], None] = lambda line: None,
) -> list[Path]:
    """Draw everything that a request asks for, in one Blender scene, and return the files written.

    report: called with each file as it is done, its number and the count of all. note: called with a line on how long
    an animation takes, once two of its frames are done. Raises FigureError.
    """
    cache = SkinCache(request.cache)
    stills = request.frames if request.frames is not None else (cache.frames[-1],)
    for frame in stills:
        cache.epoch_at(frame)
    hidden = buried_sutures(cache)
    steps = _steps(cache, request, surgical_field(cache, stills).normal, len(hidden)) if request.filmstrip else []
    movie = cache.frames if request.animation != "none" else ()
    shown = tuple(sorted({*stills, *(s.frame for s in steps), *movie, cache.frames[-1]}))
    field = field_on_body(cache, shown, bool(cache.scenery))
    _make_folder(request.out)
    plate = Plate(cache, field, request, shown, hidden)
    total = len(stills) + len(steps) + bool(steps) + len(movie) + (request.animation == "mp4")
    written: list[Path] = []

    def done(path: Path) -> None:
        written.append(path)
        report(path, len(written), total)

    drawn: dict[float, Path] = {}
    for frame in stills:
        path = request.out / f"frame_{frame:04g}.png"
        plate.render(frame, request.size, request.samples, path)
        drawn[frame] = path
        done(path)
    if steps:
        done_panels = []
        for number, step in enumerate(steps, start=1):
            path = request.out / f"step_{number}.png"
            if step.frame in drawn and _shrinks(request.size, request.panel):
                save_picture(shrunk(load_picture(drawn[step.frame]), request.panel), path)
            else:
                plate.render(step.frame, request.panel, request.samples, path)
            done_panels.append(path)
            done(path)
        sheet = request.out / "filmstrip.png"
        write_filmstrip(done_panels, steps, sheet)
        done(sheet)
    if movie:
        _draw_animation(plate, request, movie, cache.fps, done, note)
    return written


def _draw_animation(
    plate: Plate,
    request: FigureRequest,
    times: tuple[float, ...],
    fps: float,
    done: Callable[[Path], None],
    note: Callable[[str], None],
) -> None:
    """Draw the frames of an animation, and encode them where that is asked for."""
    folder = request.out / "frames"
    _make_folder(folder)
    pictures = []
    begun = monotonic()
    for number, time in enumerate(times, start=1):
        path = folder / f"{number:04d}.png"
        plate.render(time, request.movie, request.movie_samples, path)
        pictures.append(path)
        done(path)
        if number == 2:
            note(_expectation(len(times), request.movie, (monotonic() - begun) / 2))
    if request.animation == "mp4":
        film = request.out / "animation.mp4"
        encode_mp4(pictures, request.movie, fps, film)
        done(film)


def _expectation(frames: int, size: tuple[int, int], seconds: float) -> str:
    left = seconds * (frames - 2)
    words = f"{left:.0f} s" if left < 90 else f"{left / 60:.0f} min"
    return f"animation of {frames} frames, {size[0]}x{size[1]}: {seconds:.1f} s a frame, about {words} to go"


def _shrinks(size: tuple[int, int], panel: tuple[int, int]) -> bool:
    """Whether a still shrinks to a panel: it is not smaller and has the same shape to a pixel."""
    return size[0] >= panel[0] and abs(size[1] * panel[0] / size[0] - panel[1]) < 1.0


def _steps(cache: SkinCache, request: FigureRequest, normal: NDArray[np.float64], buried: int) -> list[Step]:
    """The panels; normal: (3,), outwards from the skin at the wound."""
    if request.frames is not None and len(request.frames) > 1:
        return step_captions(cache.events, request.frames)
    return story_steps(cache.events, cache.frames, hook_height(cache, normal), buried)


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


def _section(text: str) -> SectionPlane:
    try:
        return SectionPlane.of([float(part) for part in text.split(",")])
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a section: {error}") from error


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
    parser.add_argument("--movie", type=_size)
    parser.add_argument("--samples", type=int, default=6)
    parser.add_argument("--movie-samples", type=int, default=4)
    parser.add_argument("--engine", choices=tuple(ENGINES), default="cycles")
    parser.add_argument("--view", choices=tuple(VIEWS), default="oblique")
    parser.add_argument("--color", choices=COLORS, default="grid")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--section", type=_section)
    parser.add_argument("--translucent", action=argparse.BooleanOptionalAction, default=False)
    values = vars(parser.parse_args(arguments))
    width, height = values["size"]
    values["panel"] = values["panel"] or _part((width, height), 7 / 16)
    values["movie"] = values["movie"] or _part((width, height), 1 / 2)
    return FigureRequest(**values)


def _part(size: tuple[int, int], share: float) -> tuple[int, int]:
    return max(16, round(size[0] * share)), max(16, round(size[1] * share))


def main(arguments: list[str] | None = None) -> int:
    """Draw figures as the command line asks; return the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # an interrupt ends a long render at once
    request = parse_request(arguments)
    say = messages()
    try:
        draw_figures(
            request,
            lambda path, number, of: say(picture=str(path), number=number, of=of),
            lambda line: say(note=line),
        )
    except FigureError as error:
        say(error=str(error))
        return 1
    say(done=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
