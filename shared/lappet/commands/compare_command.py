"""`lappet compare`: solved operations beside each other."""

from __future__ import annotations

from pathlib import Path

import click

from lappet.commands.parameters import FILE
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits


@click.command()
@click.argument("caches", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", "picture", type=FILE, help="A figure of it (.png, .svg or .pdf).")
@click.option("--csv", "table", type=FILE, help="The table as CSV.")
@reading_options
@click.pass_context
def compare(
    context: click.Context,
    /,
    caches: tuple[Path, ...],
    picture: Path | None,
    table: Path | None,
    limits: ReadLimits,
) -> None:
    """Compare the last frames of skin caches: closing force, tension, scar, dog-ears, undermining, moved landmarks."""
    with sentences(context):
        import csv

        from rich import box
        from rich.console import Console
        from rich.table import Table

        from lappet.output.comparison import compared, comparison_rows, plot_comparison
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
