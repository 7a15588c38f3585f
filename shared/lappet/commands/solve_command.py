"""`lappet solve`: solve a procedure and write its skin cache."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lappet.commands.gravity_options import gravity_options, with_gravity
from lappet.commands.parameters import FILE, FrameRange
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.commands.solve_options import is_given, solve_options
from lappet.core.output_place import check_place
from lappet.foreign.limits import ReadLimits
from lappet.program.settings import SolverSettings
from lappet.usd.procedure_file import ProcedureFile

if TYPE_CHECKING:
    from lappet.procedure import Procedure


@click.command()
@click.argument("procedure", type=FILE)
@click.option(
    "-o", "--output", type=FILE, help="The skin cache (.usdc, .usda or .usd).  [default: PROCEDURE.cache.usdc]"
)
@click.option("--report", "report_path", type=FILE, help="Write what the solve took as JSON.")
@click.option("--suture-forces", "forces_path", type=FILE, help="Write the force on each suture as CSV.")
@click.option("--hook-forces", "hooks_path", type=FILE, help="Write the force of each hook as CSV.")
@click.option("--seams", "seams_path", type=FILE, help="Write what is measured at each seam of a wound as CSV.")
@click.option(
    "--reactions", "reactions_path", type=FILE, help="Write the force of what holds and loads the tissue as CSV."
)
@click.option("--sections", "sections_path", type=FILE, help="Write the force across each section as CSV.")
@click.option("--frames", type=FrameRange(), help="Solve up to B and write A to B.")
@click.option(
    "--target-error",
    type=click.FloatRange(min=0, min_open=True),
    metavar="MM",
    help="Choose spacing, quadrature and tolerance for this root mean square displacement error of the skin.",
)
@click.option(
    "--share",
    type=click.FloatRange(min=0),
    metavar="SECONDS",
    help="Let every user of the daemon follow (lappet follow), and wait so long for them before the first frame.",
)
@gravity_options("the procedure's")
@solve_options
@reading_options
@click.pass_context
def solve(
    context: click.Context,
    /,
    procedure: Path,
    output: Path | None,
    report_path: Path | None,
    forces_path: Path | None,
    hooks_path: Path | None,
    seams_path: Path | None,
    reactions_path: Path | None,
    sections_path: Path | None,
    frames: tuple[int | None, int | None] | None,
    target_error: float | None,
    share: float | None,
    position: tuple[float, float, float] | None,
    gravity: float | None,
    settings: SolverSettings,
    limits: ReadLimits,
    **options: Any,
) -> None:
    """Solve a procedure and write its skin cache."""
    if share is not None and options["daemon"] is None:
        raise click.UsageError("--share is of no use without --daemon: nobody else reaches a daemon of your own.")
    with sentences(context):
        for path in (report_path, forces_path, hooks_path, seams_path, reactions_path, sections_path):
            if path is not None:
                check_place(path)
        reading = context.with_resource(ProcedureFile(procedure, limits))  # it runs while the rest is loaded
        from lappet.commands.run_solve import run_solve, run_to_target, summary, write_tables

        cache = output or procedure.with_suffix(".cache.usdc")
        options.update(frames=frames or (None, None), share=share)
        source = reading if position is None and gravity is None else _lying(reading, position, gravity)
        if target_error is None:
            result = run_solve(source, cache, report_path, settings, **options)
        else:
            given = [
                name for name in ("spacing", "quadrature", "tolerance", "error_estimate") if is_given(context, name)
            ]
            if given:
                option = "--" + given[0].replace("_", "-")
                raise click.UsageError(f"--target-error chooses {option} itself; leave {option} out.")
            result = run_to_target(source, cache, report_path, settings, target_error, **options)
        write_tables(
            result,
            sutures=forces_path,
            hooks=hooks_path,
            seams=seams_path,
            reactions=reactions_path,
            sections=sections_path,
        )
        click.echo(summary(result))
    if not result.complete:
        context.exit(1)


def _lying(file: ProcedureFile, position: tuple[float, float, float] | None, gravity: float | None) -> Procedure:
    """Read a procedure whose patient lies otherwise than it says."""
    procedure = file.procedure()
    return replace(procedure, tissue=with_gravity(procedure.tissue, position, gravity))
