"""`lappet compare`: solved operations beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.extras import extra
from lappet.commands.parameters import FILE, Picture
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits

if TYPE_CHECKING:
    from lappet.output.comparison import Compared


@click.command()
@click.argument("caches", type=FILE, nargs=-1, required=True)
@click.option(
    "-o", "--output", "picture", type=Picture(".png", ".svg", ".pdf"), help="A figure of it (.png, .svg or .pdf)."
)
@click.option("--csv", "table", type=FILE, help="The table as CSV.")
@click.option(
    "--plate", type=FILE, help="A plate of it: each operation planned and at its end (.svg, .pdf, .png, .tif)."
)
@reading_options
@click.pass_context
def compare(
    context: click.Context,
    /,
    caches: tuple[Path, ...],
    picture: Path | None,
    table: Path | None,
    plate: Path | None,
    limits: ReadLimits,
) -> None:
    """Compare the last frames of skin caches: closing force, tension, scar, dog-ears, undermining, moved landmarks.

    Tension is given for the whole skin, within 10 mm of the scar, and for each face subset of the skin, such as the
    subunits of a face.
    """
    with sentences(context):
        import csv
        import io

        from rich import box
        from rich.console import Console
        from rich.table import Table

        from lappet.core.durable import write_whole
        from lappet.core.output_place import check_place
        from lappet.output.comparison import compared, comparison_rows
        from lappet.output.comparison_figure import plot_comparison
        from lappet.usd.cache_end import read_cache_end

        for path in (picture, table, plate):
            if path is not None:
                check_place(path)
        columns = [compared(cache.stem, read_cache_end(cache, limits)) for cache in caches]
        rows = comparison_rows(columns)
        shown = Table(box=box.SIMPLE_HEAD)
        for heading in ("at the last frame", *(each.name for each in columns)):
            shown.add_column(heading, justify="left" if not shown.columns else "right")
        for row in rows:
            shown.add_row(*row)
        Console().print(shown)
        if table is not None:
            text = io.StringIO(newline="")
            csv.writer(text).writerows([["measure", *(each.name for each in columns)], *rows])
            write_whole(table, text.getvalue().encode())
            click.echo(f"Table: {table}")
        if picture is not None:
            plot_comparison(columns, picture)
            click.echo(f"Figure: {picture}")
        if plate is not None:
            _draw_plate(caches, columns, plate, limits)
            click.echo(f"Plate: {plate}")


def _draw_plate(caches: tuple[Path, ...], columns: list[Compared], path: Path, limits: ReadLimits) -> None:
    """Draw a row for each operation: planned, and its end with what was measured there."""
    from lappet.output.comparison import one_line

    with extra("A plate", "plates"):
        from lappet.plates.draw_plate import PlateOptions, draw_plate

    captions = {2 * k + 1: f"{each.name}: {one_line(each)}" for k, each in enumerate(columns)}
    draw_plate(caches, [path], PlateOptions(captions=captions, shown={"columns": 2}), limits)
