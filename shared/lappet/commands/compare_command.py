"""`lappet compare`: solved operations beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.parameters import FILE
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits

if TYPE_CHECKING:
    from lappet.output.comparison import Compared


@click.command()
@click.argument("caches", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", "picture", type=FILE, help="A figure of it (.png, .svg or .pdf).")
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

        from rich import box
        from rich.console import Console
        from rich.table import Table

        from lappet.output.comparison import compared, comparison_rows
        from lappet.output.comparison_figure import plot_comparison
        from lappet.usd.cache_end import read_cache_end

        columns = [compared(cache.stem, read_cache_end(cache, limits)) for cache in caches]
        rows = comparison_rows(columns)
        shown = Table(box=box.SIMPLE_HEAD)
        for heading in ("at the last frame", *(each.name for each in columns)):
            shown.add_column(heading, justify="left" if not shown.columns else "right")
        for row in rows:
            shown.add_row(*row)
        Console().print(shown)
        if table is not None:
            with table.open("w", encoding="utf-8", newline="") as file:
                csv.writer(file).writerows([["measure", *(each.name for each in columns)], *rows])
            click.echo(f"Table: {table}")
        if picture is not None:
            plot_comparison(columns, picture)
            click.echo(f"Figure: {picture}")
        if plate is not None:
            _draw_plate(caches, columns, plate, limits)
            click.echo(f"Plate: {plate}")


def _draw_plate(caches: tuple[Path, ...], columns: list[Compared], path: Path, limits: ReadLimits) -> None:
    from lappet.output.comparison import one_line
    from lappet.plates.comparison_plate import Operation, comparison_plate
    from lappet.plates.plate_cache import open_cache
    from lappet.plates.plate_files import check_format, write_plate
    from lappet.plates.plate_font import PlateFont
    from lappet.plates.plate_style import plate_style
    from lappet.plates.plate_words import plate_words

    check_format(path)
    font = PlateFont()
    operations = [
        Operation(each.name, open_cache(cache, limits), one_line(each))
        for cache, each in zip(caches, columns, strict=True)
    ]
    made = comparison_plate(operations, plate_style("schematic"), plate_words("en"), font)
    write_plate(made.svg, made.size, made.alt, font, path, 300)
