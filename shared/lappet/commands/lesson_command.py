"""`lappet lesson`: a lesson of several procedures, from a plan in TOML."""

from __future__ import annotations

from pathlib import Path

import click

from lappet.commands.parameters import FILE
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits


@click.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", "target", type=FILE, help="The lesson (.html), its package (.zip, .h5p), or a folder.")
@click.option(
    "--template", type=FILE, metavar="PLAN", help="Write a plan to begin with, for the caches that are given."
)
@reading_options
@click.pass_context
def lesson(
    context: click.Context, /, files: tuple[Path, ...], target: Path | None, template: Path | None, limits: ReadLimits
) -> None:
    """Write a lesson of several procedures: chapters with text, hotspots and questions.

    FILES is the plan of the lesson in TOML; with --template, the skin caches that the plan is for. -o says by its
    suffix what is written: .html is a page for a browser, .zip a package of SCORM 1.2, .h5p one of H5P. Without a
    suffix it is a folder, a site with a page for each chapter.
    """
    if (target is None) == (template is None):
        raise click.UsageError("Give -o for a lesson, or --template for a plan to begin with.")
    if template is None and len(files) != 1:
        raise click.UsageError("A lesson has one plan; give one file, and the caches in it.")
    with sentences(context):
        if template is not None:
            _write_template(files, template, limits)
            return
        from lappet.lessons.write_lesson_plan import write_lesson_plan

        assert target is not None  # one of the two is given
        click.echo(write_lesson_plan(files[0], target, limits, say=lambda line: click.echo(line, err=True)))


def _write_template(caches: tuple[Path, ...], template: Path, limits: ReadLimits) -> None:
    if template.exists():
        raise click.UsageError(f"{template} is there already; choose another name.")
    from lappet.core.durable import write_whole
    from lappet.core.output_place import check_place
    from lappet.lessons.plan_template import plan_template

    check_place(template)
    write_whole(template, plan_template(caches, template, limits).encode())
    click.echo(template)
