"""`lappet flap`: the library of flap designs, and operations made of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from lappet.commands.known_names import DESIGN, NamingCommand
from lappet.commands.parameters import FILE, Picture
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from lappet.procedure import FlapLines


class Measure(click.ParamType):
    """A measure of a design and its value: `side=18`."""

    name = "NAME=VALUE"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the measure.

        Parameters
        ----------
        value
            What the user typed, or the pair itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The pair (name, value).
        """
        if isinstance(value, tuple):
            return value
        name, _, number = str(value).partition("=")
        try:
            return (name.strip(), float(number))
        except ValueError:
            self.fail(f"{value!r} is no measure; give NAME=VALUE, like side=18.", param, ctx)


@click.group()
def flap() -> None:
    """List the library of flap designs, and add the operation of one to a procedure."""


@flap.command("list")
@click.pass_context
def list_designs(context: click.Context) -> None:
    """List the designs of the library."""
    with sentences(context):
        from lappet.designs.library import DESIGNS

        wide = max(len(name) for name in DESIGNS)
        for design in DESIGNS.values():
            click.echo(f"{design.name:<{wide}}  {design.indication}")


@flap.command("show", cls=NamingCommand)
@click.argument("name", type=DESIGN)
@click.option("--picture", type=Picture(".svg", ".pdf", ".png"), help="Draw its plan, to scale (.svg, .pdf or .png).")
@click.option(
    "--set",
    "measures",
    type=Measure(),
    multiple=True,
    help="A measure of the drawn plan, of those it lists; may be repeated.",
)
@click.option("--mirrored", is_flag=True, help="Draw it mirrored about its direction.")
@click.pass_context
def show_design(
    context: click.Context,
    /,
    name: str,
    picture: Path | None,
    measures: tuple[tuple[str, float], ...],
    mirrored: bool,
) -> None:
    """Show the design NAME: what it is for, its measures with their ranges, and where these come from."""
    with sentences(context):
        from rich import box
        from rich.console import Console
        from rich.table import Table

        from lappet.core.output_place import check_place
        from lappet.designs.library import library_design

        if picture is not None:
            check_place(picture)
        design = library_design(name)
        table = Table(box=box.SIMPLE_HEAD)
        for heading in ("measure", "default", "range", "what it is", "source"):
            table.add_column(heading)
        for parameter in design.parameters:
            default = f"{parameter.default:g} {parameter.unit}".strip()
            table.add_row(parameter.name, default, parameter.range_text, parameter.meaning, parameter.source)
        click.echo(f"{design.title}: {design.indication}")
        click.echo(f"--at is {design.center}; --direction is {design.direction}.")
        if design.lines:
            click.echo(f"Surgeons lay the direction {design.lines} the lines of the skin (--lines {design.lines}).")
        Console().print(table)
        click.echo(f"Sources: {design.sources}")
        if picture is not None:
            from lappet.designs.flap_plan import flap_plan
            from lappet.output.plan_figure import write_plan_figure

            plan = flap_plan(design, dict(measures), mirrored=mirrored)
            write_plan_figure(plan, design.lines, picture)
            if plan.meetings:
                click.echo(
                    "In the end meet: " + ", ".join(f"{flap} and {wound}" for flap, wound in plan.meetings) + "."
                )
            click.echo(f"Written: {picture}")


@flap.command("add", cls=NamingCommand)
@click.argument("name", type=DESIGN)
@click.argument("procedure", type=FILE, required=False)
@click.option("-o", "--output", type=FILE, required=True, help="The procedure with the operation (.usda or .usdc).")
@click.option("--at", nargs=3, type=float, metavar="X Y Z", help="Where it lies on the skin, in mm.")
@click.option("--landmark", help="Where it lies: the label of a landmark.")
@click.option(
    "--defect",
    help="What it closes: a closed incision, an outline of landmarks, or region:SUBSET of the tissue's faces; sets "
    "place and lengths.",
)
@click.option("--direction", nargs=3, type=float, metavar="X Y Z", help="Its direction along the skin.")
@click.option("--lines", type=click.Choice(["along", "across"]), help="Its direction, by the lines of the skin.")
@click.option(
    "--set",
    "measures",
    type=Measure(),
    multiple=True,
    help="A measure of the design, of those that `lappet flap show NAME` lists; may be repeated.",
)
@click.option("--mirrored", is_flag=True, help="Mirror it about its direction.")
@click.option("--start", type=float, help="Time code before the first cut.  [default: the end of the timeline]")
@click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm.")
@reading_options
@click.pass_context
def add(
    context: click.Context,
    /,
    name: str,
    procedure: Path | None,
    output: Path,
    at: tuple[float, float, float] | None,
    landmark: str | None,
    defect: str | None,
    direction: tuple[float, float, float] | None,
    lines: str | None,
    measures: tuple[tuple[str, float], ...],
    mirrored: bool,
    start: float | None,
    spacing: float | None,
    limits: ReadLimits,
) -> None:
    """Add the operation of the design NAME to PROCEDURE, or to a flat patch of skin.

    Cuts, excision, undermining, hooks that carry the flap, rows of sutures and landmarks, in the order of a surgeon.
    """
    _require_whole(procedure, (at, landmark, defect), (direction, lines), start)
    with sentences(context):
        from dataclasses import replace

        from lappet.checks.narrow_flaps import narrow_flaps
        from lappet.designs.fitted_design import fit_to_defect, lengths_of, marked_defect, without_drawn
        from lappet.designs.library_operation import (
            SPACING,
            add_flap,
            flap_on_patch,
            landmark_place,
            skin_line_direction,
        )
        from lappet.usd.stage import check_usd_place, read_procedure, write_procedure

        check_usd_place(output)
        if procedure is None:
            made = flap_on_patch(name, dict(measures), mirrored=mirrored, spacing=spacing or SPACING)
        else:
            given = read_procedure(procedure, limits=limits)
            if spacing is not None:
                given = replace(given, tissue=replace(given.tissue, spacing=spacing))
            outline = None if defect is None else marked_defect(given, defect)
            place: ArrayLike = at or (landmark_place(given, str(landmark)) if outline is None else outline.mean(axis=0))
            way: ArrayLike = direction or skin_line_direction(given, place, across=lines == "across")
            values = dict(measures)
            if outline is not None and defect is not None:
                fitted = fit_to_defect(given.tissue, name, outline, way, values, mirrored=mirrored)
                place, values = fitted.at, fitted.values
                given = without_drawn(given, defect)
                click.echo("Lengths: " + ", ".join(lengths_of(name, values)))
            follows = cast("FlapLines", lines or "")
            made = add_flap(given, name, place, way, values, mirrored=mirrored, start=start, lines=follows)
        write_procedure(made, output)
        click.echo(f"Written: {output}")
        for found in narrow_flaps(made, set()):
            click.echo(f"{found.severity}: {found}", err=True)


@flap.command("edit")
@click.argument("name")
@click.argument("procedure", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="The changed procedure (.usda or .usdc).")
@click.option("--at", nargs=3, type=float, metavar="X Y Z", help="Its new place on the skin, in mm.")
@click.option("--direction", nargs=3, type=float, metavar="X Y Z", help="Its new direction along the skin.")
@click.option("--lines", type=click.Choice(["along", "across"]), help="Its new direction, by the lines of the skin.")
@click.option(
    "--set",
    "measures",
    type=Measure(),
    multiple=True,
    help="A new measure, of those that `lappet flap show` lists of its design; may be repeated.",
)
@click.option("--mirrored/--not-mirrored", default=None, help="Whether it is mirrored about its direction.")
@click.option("--start", type=float, help="New time code before the first cut.")
@reading_options
@click.pass_context
def edit(
    context: click.Context,
    /,
    name: str,
    procedure: Path,
    output: Path,
    at: tuple[float, float, float] | None,
    direction: tuple[float, float, float] | None,
    lines: str | None,
    measures: tuple[tuple[str, float], ...],
    mirrored: bool | None,
    start: float | None,
    limits: ReadLimits,
) -> None:
    """Lay the flap NAME of PROCEDURE anew, moved, turned or with other measures; what is not given stays.

    `lappet inspect` lists the flaps that were laid. A flap that was laid by the lines of the skin follows them where it
    is moved to. Changes that were made to its events by hand are lost, and named.
    """
    if direction is not None and lines is not None:
        raise click.UsageError("Give --direction or --lines, not both.")
    with sentences(context):
        from lappet.checks.narrow_flaps import narrow_flaps
        from lappet.designs.laid_flaps import by_hand, changed_flap, laid_flap, relay
        from lappet.usd.stage import check_usd_place, read_procedure, write_procedure

        check_usd_place(output)
        given = read_procedure(procedure, limits=limits)
        changed = changed_flap(
            given,
            laid_flap(given, name),
            at=at,
            direction=direction,
            lines=cast("FlapLines | None", lines),
            measures=dict(measures),
            mirrored=mirrored,
            start=start,
        )
        made = relay(given, changed)
        write_procedure(made, output)
        click.echo(f"Written: {output}")
        for found in (*by_hand(given, name), *narrow_flaps(made, set())):
            click.echo(f"{found.severity}: {found}", err=True)


def _require_whole(
    procedure: Path | None, places: tuple[object, ...], directions: tuple[object, ...], start: float | None
) -> None:
    """Refuse a place or a direction that is given twice, or not at all where there is a procedure."""
    placed, directed = (sum(each is not None for each in some) for some in (places, directions))
    if placed > 1:
        raise click.UsageError("Give one of --at, --landmark and --defect.")
    if directed > 1:
        raise click.UsageError("Give --direction or --lines, not both.")
    if procedure is None and (placed or directed or start is not None):
        raise click.UsageError("--at, --landmark, --defect, --direction, --lines and --start need a PROCEDURE.")
    if procedure is not None and not (placed and directed):
        raise click.UsageError("Say where it lies (--at, --landmark or --defect) and how (--direction or --lines).")
