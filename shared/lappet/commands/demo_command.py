"""`lappet demo`: solve and render the bundled Z-plasty."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from lappet.commands.parameters import FILE
from lappet.commands.refusals import sentences
from lappet.commands.solve_options import solve_options
from lappet.program.settings import SolverSettings


@click.command()
@click.option(
    "-o",
    "--output",
    "folder",
    type=FILE,
    help="Folder for the results.  [default: lappet-demo here, or where a file can be written]",
)
@solve_options
@click.pass_context
def demo(context: click.Context, /, folder: Path | None, settings: SolverSettings, **options: Any) -> None:
    """Solve and render the bundled Z-plasty, at a spacing of 1.33 mm unless you give one."""
    import shutil

    with sentences(context):
        from lappet.commands.run_solve import run_solve, summary
        from lappet.demo import SPACING, figures_of, z_plasty
        from lappet.demo.free_folder import free_folder
        from lappet.output.render import render_cache

        folder = folder or free_folder()
        settings = replace(settings, spacing=settings.spacing or SPACING)
        folder.mkdir(parents=True, exist_ok=True)
        procedure = folder / "z_plasty.usda"
        shutil.copyfile(z_plasty(), procedure)
        cache = folder / "z_plasty.cache.usdc"
        result = run_solve(procedure, cache, folder / "z_plasty.report.json", settings, **options)
        click.echo(summary(result))
        if result.complete:

            def draw(cache: Path, figures: Path) -> list[Path]:
                click.echo("Rendering figures with Blender.", err=True)
                return render_cache(cache, figures, progress=lambda line: click.echo(line, err=True))

            pictures = figures_of(cache, folder / "figures", draw)
            click.echo("Pictures:")
            for picture in pictures:
                click.echo(f"  {picture}")
            for plate in _plates(cache, folder):
                click.echo(f"Plate:      {plate.resolve()}")
            click.echo(f"Skin cache: {cache.resolve()}")
            click.echo(f"Report:     {(folder / 'z_plasty.report.json').resolve()}")
    if not result.complete:
        context.exit(1)


def _plates(cache: Path, folder: Path) -> list[Path]:
    """Draw the plate of the demo, where what plates need is installed."""
    from importlib.util import find_spec

    if not all(find_spec(each) for each in ("drawsvg", "shapely", "typst")):
        return []
    from lappet.plates.draw_plate import draw_plate

    return list(draw_plate([cache], [folder / "z_plasty.plate.pdf", folder / "z_plasty.plate.svg"]).pictures)
