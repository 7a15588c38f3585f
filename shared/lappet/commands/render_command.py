"""`lappet render`: pictures of a skin cache."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lappet.commands.parameters import FILE, FrameList, PlaneNumbers, Size
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences

# Of `lappet.output.render`, which `--help` does not load; a test compares them.
VIEWS = ("oblique", "top", "low")
COLORS = ("grid", "plain", "strain", "stress", "tension")
ENGINES = ("cycles", "workbench")


@click.command()
@click.argument("cache", type=FILE)
@click.option("-o", "--output", "folder", type=FILE, required=True, help="Folder for the pictures.")
@click.option("--frames", type=FrameList(), help="Time codes of the stills.  [default: the last]")
@click.option("--filmstrip/--no-filmstrip", default=True, show_default=True, help="Draw the steps on one sheet.")
@click.option("--animation", type=click.Choice(["none", "png", "mp4"]), default="none", show_default=True)
@click.option("--size", type=Size(), default="1280x960", show_default=True, help="Pixels of a still, 16 to 16384 each.")
@click.option("--movie-size", type=Size(), help="Pixels of an animation.  [default: half of size]")
@click.option("--samples", type=click.IntRange(1, 65536), help="Cycles samples per pixel.  [default: 6]")
@click.option(
    "--movie-samples", type=click.IntRange(1, 65536), help="Cycles samples per pixel of an animation.  [default: 4]"
)
@click.option("--view", type=click.Choice(VIEWS), help="Where the camera stands.  [default: oblique]")
@click.option("--color", type=click.Choice(COLORS), help="What the skin shows.  [default: grid]")
@click.option("--translucent/--opaque", default=False, show_default=True, help="Show vessels through the skin.")
@click.option(
    "--section",
    type=PlaneNumbers(),
    help="Take away what lies beyond a plane, a point in mm and its normal, and what surrounds the tissue.",
)
@click.option("--engine", type=click.Choice(ENGINES), help="Blender's renderer.  [default: cycles]")
@reading_options
@click.pass_context
def render(context: click.Context, /, cache: Path, folder: Path, **options: Any) -> None:
    """Render stills, a filmstrip and an animation of a skin cache with Blender (bpy)."""
    with sentences(context):
        from lappet.output.render import render_cache

        given = {name: value for name, value in options.items() if value is not None}
        for picture in render_cache(cache, folder, progress=lambda line: click.echo(line, err=True), **given):
            click.echo(picture)
