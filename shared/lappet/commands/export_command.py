"""`lappet export`: a solved procedure for other programs, by the suffix of the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lappet.commands.film_command import draw_with_progress
from lappet.commands.parameters import FILE, FileSize, FrameList, Simplification
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.core.problem import Problem
from lappet.foreign.limits import ReadLimits

_LANGUAGES = ("en", "de", "fr", "es", "zh")


@click.command()
@click.argument("caches", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", "target", type=FILE, required=True, help="The file to write; its suffix is its format.")
@click.option("--frames", type=FrameList(), help="Time codes to write.  [default: all]")
@click.option("--step", help="The step whose frame a mesh is of, by its number or its name.  [default: the last frame]")
@click.option("--every-frame", is_flag=True, default=None, help="Write a mesh for every frame, numbered.")
@click.option("--language", type=click.Choice(_LANGUAGES), help="Language a lesson opens in.  [default: en]")
@click.option("--title", help="Title of a lesson.  [default: the name of the cache]")
@click.option(
    "--simplify",
    type=Simplification(),
    help="Leave triangles out: how many may stay, 100 or more, or how far it may be off.",
)
@click.option("--max-size", type=FileSize(), help="How large .html, .zip, .h5p, .glb or .usdz may be, such as 5MB.")
@click.option("--quantized", is_flag=True, default=None, help="Write a smaller .glb, by whole numbers.")
@click.option("--meshopt", is_flag=True, default=None, help="Write a much smaller .glb, compressed by meshopt.")
@click.option(
    "--tolerance-mm",
    type=click.FloatRange(min=0.0, min_open=True),
    help="How far .usdz may be from the cache, in mm.  [default: 0.5]",
)
@click.option("--bones", type=click.IntRange(min=1), help="Bones that each part of a .usdz may have.  [default: 200]")
@click.option("--pause", type=click.FloatRange(0.0, 60.0), help="Seconds on each step of a .usdz.  [default: 1.0]")
@click.option("--instruments/--no-instruments", default=None, help="Threads and hooks in a .usdz.  [default: with]")
@click.option("--one-file", is_flag=True, default=None, help="Leave pictures, camera and lights of USD out.")
@click.option("--step-files", is_flag=True, default=None, help="Write what moves of USD in a file for each step.")
@click.option("--photo", type=FILE, help="The texture of the mesh that the tissue was made of: a look of USD.")
@click.option(
    "--fps",
    type=click.FloatRange(1.0, 240.0),
    help="Time codes in a second of USD.  [default: 24, or the cache's, of which frames are whole ones]",
)
@reading_options
@click.pass_context
def export(
    context: click.Context, /, caches: tuple[Path, ...], target: Path, limits: ReadLimits, **options: Any
) -> None:
    """Write a solved procedure for other programs.

    .html: a lesson in one file for a browser, of one procedure or of two side by side.
    .zip, .h5p: the same as a package of SCORM 1.2 or of H5P, for a learning platform.
    .glb: glTF with every frame, the steps as animations.
    .usdz: for augmented reality, every frame by bones, at real size.
    .usdc, .usda: USD without the procedure, with its pictures, camera and lights beside it.
    .stl, .obj, .ply, .3mf: the tissue's surface in one frame, in mm.
    .csv: forces, landmarks and lengths, a row for each frame.
    .abc, .fbx: written by Blender, where bpy is installed.
    .mp4, .webm, .gif, .webp: a film, as `lappet film` draws it with its defaults.
    """
    given = {name: value for name, value in options.items() if value is not None}
    from lappet.export.formats import FILMS

    if target.suffix.lower() in FILMS:
        _export_film(context, caches, target, given, limits)
        return
    with sentences(context):
        from lappet.export.export_request import ExportRequest
        from lappet.export.formats import export as write

        for path in write(ExportRequest(caches, target, given, limits, _tell)):
            click.echo(path)


def _export_film(
    context: click.Context, caches: tuple[Path, ...], target: Path, given: dict[str, Any], limits: ReadLimits
) -> None:
    other = sorted(set(given) - {"language", "title"})
    if other:
        raise click.UsageError(f"A film has no --{other[0].replace('_', '-')}; `lappet film` has options of its own.")
    if len(caches) > 1:
        raise click.UsageError("A film is of one cache; give one.")
    with sentences(context):
        draw_with_progress(caches[0], target, given, limits)
        click.echo(target)


def _tell(problem: Problem) -> None:
    click.echo(f"{problem.severity}: {problem}", err=True)
