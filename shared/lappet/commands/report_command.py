"""`lappet report`: measurements as JSON, CSV, Markdown and pictures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from lappet.commands.known_names import DESIGN, OPERATION, ROW, NamingCommand
from lappet.commands.refusals import sentences

# Groups of cases of `lappet.reports.stability`, which `--help` does not load.
GROUPS = (
    *("poisson", "contrast", "fibers", "models", "stretch", "compression", "twist", "starts", "buckling", "stiffness"),
    *("fights", "bone", "thin", "floating", "scale", "spacing", "cuts", "many cuts"),
)


def _output(name: str) -> Callable[[Any], Any]:
    return click.option(
        "-o",
        "--output",
        "folder",
        type=click.Path(path_type=Path),
        default=Path("reports") / name,
        show_default=True,
        help="Folder for the results.",
    )


def _say(line: str) -> None:
    click.echo(line, err=True)


@click.group()
def report() -> None:
    """Measure error against run time, the estimate, convergence, stability and economy; hold flaps against papers."""


@report.command("error-time")
@click.argument("scenes", nargs=-1)
@_output("error-time")
@click.option("--quick", is_flag=True, help="Use coarser spacings and vary one setting at a time: a minute or two.")
@click.pass_context
def error_time(context: click.Context, /, scenes: tuple[str, ...], folder: Path, quick: bool) -> None:
    """Compare the displacement error of SCENES with the seconds it takes, for each setting.

    SCENES: bar, cantilever, cook, block, shelf; these without lateral contraction: bar-nu0, cantilever-nu0,
    cook-nu0, block-nu0; z-plasty, scalp-flap; or procedures (.usda). All of the named ones by default.
    """
    with sentences(context):
        from lappet.reports.error_time.run import run_error_time

        text, files = run_error_time(scenes, folder, quick, say=_say)
        click.echo(text)
        for path in files:
            click.echo(path)


@report.command("error-estimate")
@click.argument("scenes", nargs=-1)
@_output("error-estimate")
@click.option("--fitting", is_flag=True, help="Take the scenes that the estimate was fitted on instead.")
@click.pass_context
def error_estimate(context: click.Context, /, scenes: tuple[str, ...], folder: Path, fitting: bool) -> None:
    """Compare the estimated error with the true one, on SCENES that the estimate was not fitted on.

    SCENES: hanging-flap, rotation-flap, v-y, dome-flap, layered-closure, fusiform-closure, running-closure, held-flap,
    released-hook, taut-excision, stiff-fibers, soft-fibers, muscle-bar, muscle-plate, strip-over-bone, punch. All by
    default.
    """
    with sentences(context):
        from lappet.reports.error_estimate.run import run_error_estimate

        text, files = run_error_estimate(scenes, folder, fitting, say=_say)
        click.echo(text)
        for path in files:
            click.echo(path)


@report.command("stability")
@_output("stability")
@click.option(
    "--only",
    multiple=True,
    type=click.Choice(GROUPS),
    metavar="GROUP",
    help="Solve only this group of cases; may be repeated.",
)
@click.option("--quick", is_flag=True, help="Skip the slow cases.")
@click.option(
    "--fuzz",
    type=click.IntRange(min=1),
    metavar="N",
    help="Instead, solve N small random procedures, the same ones every time.",
)
@click.option(
    "--jobs", type=click.IntRange(min=1), metavar="N", help="With --fuzz, solve N at once; by default one per core."
)
@click.pass_context
def stability(
    context: click.Context, /, folder: Path, only: tuple[str, ...], quick: bool, fuzz: int | None, jobs: int | None
) -> None:
    """Solve stiff and extreme cases: each must converge, or be refused for the right reason.

    The exit status is 1 if a case ends otherwise. GROUP: poisson, contrast, fibers, models, stretch, compression,
    twist, starts, buckling, stiffness, fights, bone, thin, floating, scale, spacing, cuts, "many cuts".
    """
    with sentences(context):
        from lappet.reports.stability.run import chosen_cases, run_fuzz, run_stability

        if fuzz is not None:
            text, right, files = run_fuzz(folder, fuzz, _say, jobs)
        else:
            text, right, files = run_stability(folder, chosen_cases(only, quick), _say)
        click.echo(text)
        for path in files:
            click.echo(path)
        if not right:
            context.exit(1)


@report.command("convergence")
@_output("convergence")
@click.option("--quick", is_flag=True, help="Leave out the large patches and the moduli between.")
@click.pass_context
def convergence(context: click.Context, /, folder: Path, quick: bool) -> None:
    """Compare flaps at the default settings with the same frames solved to 1e-8 in double precision.

    The exit status is 1 if a frame is off by more than 0.05 mm, or 0.05 spacings of a coarser lattice.
    """
    with sentences(context):
        from lappet.reports.convergence.run import run_convergence

        text, right, files = run_convergence(folder, quick, say=_say)
        click.echo(text)
        for path in files:
            click.echo(path)
        if not right:
            context.exit(1)


@report.command("economy")
@_output("economy")
@click.option(
    "--yardstick",
    "yardsticks",
    multiple=True,
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="A daemon built with -DLAPPET_LEAVE_OUT=..., to compare the plain scene with.",
)
@click.pass_context
def economy(context: click.Context, /, folder: Path, yardsticks: tuple[Path, ...]) -> None:
    """Count what each feature costs in a scene that needs it and in one that does not."""
    with sentences(context):
        from lappet.reports.economy.files import write_economy
        from lappet.reports.economy.measurement import economy as measure
        from lappet.reports.report_files import head, make_folder

        make_folder(folder)
        for path in write_economy(folder, head(), measure(yardsticks, say=_say)):
            click.echo(path)


@report.command("tissues")
@_output("tissues")
@click.pass_context
def tissues(context: click.Context, /, folder: Path) -> None:
    """Show where the presets' numbers come from, and their curves beside the published ones."""
    with sentences(context):
        from lappet.reports.tissues.files import write_tissues

        for path in write_tissues(folder):
            click.echo(path)


@report.command("atlas", cls=NamingCommand)
@click.argument("designs", nargs=-1, type=DESIGN)
@_output("atlas")
@click.option(
    "--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm on the patch.  [default: 1.33]"
)
@click.option("--pictures/--no-pictures", default=True, show_default=True, help="Draw a plate of each.")
@click.option(
    "--on",
    "places",
    type=click.Choice(("both", "patch", "models")),
    default="both",
    show_default=True,
    help="Solve them on the flat patch, on the models of the body that they belong on, or on both.",
)
@click.option(
    "--self-contact",
    is_flag=True,
    help="Keep tissue from passing through tissue on the models, several times as slow and without estimated errors.",
)
@click.pass_context
def atlas(
    context: click.Context,
    /,
    designs: tuple[str, ...],
    folder: Path,
    spacing: float | None,
    pictures: bool,
    places: str,
    self_contact: bool,
) -> None:
    """Solve and draw DESIGNS of the flap library: all of them by default.

    Each is solved at its defaults on a flat patch, and where it belongs on a body (docs/flaps.md), if the package of
    the models is there (`lappet models fetch`).
    """
    with sentences(context):
        from lappet.commands.report_progress import report_progress
        from lappet.designs.library_operation import SPACING
        from lappet.reports.atlas.run import run_atlas

        with report_progress() as progress:
            rows, files = run_atlas(
                designs,
                folder,
                progress,
                spacing=spacing or SPACING,
                pictures=pictures,
                places=places,
                self_contact=self_contact,
            )
        for path in files:
            click.echo(path)
    if any(row.frames < row.of_frames for row in rows):
        context.exit(1)


@report.command("surroundings", cls=NamingCommand)
@click.argument("names", nargs=-1, type=OPERATION)
@_output("surroundings")
@click.option(
    "--reach",
    type=click.FloatRange(min=1.0, min_open=True, max=3.0),
    metavar="X",
    help="Compare with a cut-out that reaches X times as far, too; of models only.",
)
@click.pass_context
def surroundings(context: click.Context, /, names: tuple[str, ...], folder: Path, reach: float | None) -> None:
    """Bound what the tissue beyond the rim would change: each of NAMES with its rim held and free.

    NAMES are procedures (.usda), or operations on models of the body; all of these by default. The exit status is 1 if
    a wider cut-out changes more than the free rim.
    """
    with sentences(context):
        from lappet.commands.report_progress import report_progress
        from lappet.reports.surroundings.run import run_surroundings
        from lappet.reports.surroundings.table import surroundings_table

        with report_progress() as progress:
            rows, files = run_surroundings(names, folder, reach, progress)
        click.echo(surroundings_table(rows))
        for path in files:
            click.echo(path)
    if any(row.bounded is False for row in rows):
        context.exit(1)


@report.command("literature", cls=NamingCommand)
@click.argument("rows", nargs=-1, type=ROW)
@_output("literature")
@click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm.  [default: 1.33]")
@click.pass_context
def literature(context: click.Context, /, rows: tuple[str, ...], folder: Path, spacing: float | None) -> None:
    """Hold what flaps give against what papers measured of them: ROWS, all of them by default.

    A row that disagrees is a result, not a failure; docs/literature.md tells what the rows are.
    """
    with sentences(context):
        from lappet.commands.report_progress import report_progress
        from lappet.designs.library_operation import SPACING
        from lappet.reports.literature.run import run_literature

        with report_progress() as progress:
            text, files = run_literature(rows, folder, progress, spacing=spacing or SPACING)
        click.echo(text)
        for path in files:
            click.echo(path)
