"""`lappet plate`: a page of drawings of a solved procedure, for print."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import click

from lappet.commands.extras import extra
from lappet.commands.parameters import FILE, FrameList, PlaneNumbers
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits

_STYLES = ("ink", "schematic", "halftone", "wash", "painted")
_LANGUAGES = ("en", "de", "fr", "es", "zh")
_MAPS = ("tension", "strain", "stress")
_PENS = ("dashed", "dotted", "marker")
_MARKS = ("grid", "squares", "dots")
_JOURNALS = ("springer", "elsevier", "plos")
_VIEWS = ("oblique", "top", "low")
_TEMPLATES = ("steps", "atlas", "comparison", "section", "cover")
_PROCEDURES = (".usda", ".usdc", ".usd")


class PanelCaption(click.ParamType):
    """The caption of a panel: `B=Skin excised`."""

    name = "LETTER=TEXT"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a caption.

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
            The pair (index of the panel, text).
        """
        if isinstance(value, tuple):
            return value
        letter, equals, text = str(value).partition("=")
        letter = letter.strip().upper()
        if not equals or len(letter) != 1 or not "A" <= letter <= "Z":
            self.fail(f"{value!r} is no caption; give LETTER=TEXT, like B='Skin excised'.", param, ctx)
        return (ord(letter) - ord("A"), text.strip())


@click.command()
@click.argument("caches", type=FILE, nargs=-1, required=True)
@click.option(
    "-o",
    "--output",
    "picture",
    type=FILE,
    required=True,
    help="The plate (.svg, .pdf, .png, .tif or .tiff); with --template also a procedure (.usda, .usdc).",
)
@click.option("--plate", "kept", metavar="NAME", default="", help="A plate of the procedure.")
@click.option("--template", type=click.Choice(_TEMPLATES), help="A plate that is good without editing.")
@click.option("--style", type=click.Choice(_STYLES), default="schematic", show_default=True, help="How it is drawn.")
@click.option("--skin-tone", "tone", type=click.IntRange(1, 10), help="Tone of the skin on the Monk scale, 1 to 10.")
@click.option("--frames", type=FrameList(), help="Time codes of the panels.  [default: the operation's steps]")
@click.option("--caption", "captions", type=PanelCaption(), multiple=True, help="A panel's caption in other words.")
@click.option(
    "--width-mm", "width", type=float, help="Width in print, 40 to 1000.  [default: 174, or the journal's widest]"
)
@click.option("--text-pt", "text", type=float, help="Size of labels, 7 to 24.  [default: 7, or the journal's least]")
@click.option("--journal", type=click.Choice(_JOURNALS), help="A publisher whose rules the plate keeps.")
@click.option("--columns", type=click.IntRange(1, 12), help="Panels in a row.  [default: as many as fit]")
@click.option("--view", type=click.Choice(_VIEWS), default="oblique", show_default=True, help="Where the camera is.")
@click.option(
    "--dpi",
    type=click.IntRange(72, 2400),
    help="Pixels per inch of what is no line.  [default: 300, or the journal's least]",
)
@click.option("--language", type=click.Choice(_LANGUAGES), default="en", show_default=True)
@click.option("--captions", "own", type=FILE, help="A TOML file with captions and labels in other words.")
@click.option("--font", type=FILE, help="A font file (.ttf, .otf, .ttc).  [default: Source Sans Pro]")
@click.option("--cmyk", "profile", type=FILE, help="ICC profile of the printing process: a TIFF in CMYK, or a PDF/X-4.")
@click.option("--transparent", is_flag=True, help="Leave the paper out.")
@click.option(
    "--section", type=PlaneNumbers(), help="Show a cross-section in every panel but the plan: a point in mm, a normal."
)
@click.option("--map", "mapped", type=click.Choice(_MAPS), help="A quantity of the skin, mapped in color.")
@click.option("--marks", type=click.Choice(_MARKS), help="What is printed on the skin and deforms with it.")
@click.option(
    "--marks-mm", "marks_spacing", type=float, default=5.0, show_default=True, help="Distance of the marks, 1 to 50."
)
@click.option("--plan-pen", type=click.Choice(_PENS), help="How planned cuts are drawn.  [default: whole lines]")
@click.option(
    "--hatched/--not-hatched", default=True, show_default=True, help="Hatch the areas undermined and thinned."
)
@click.option("--overlay", is_flag=True, help="Draw the outlines of all caches but the first over its panels.")
@click.option("--skin-lines", is_flag=True, help="Draw the procedure's skin lines.")
@click.option(
    "--landmark", "landmarks", multiple=True, metavar="LABEL", help="A landmark that is named where it is seen."
)
@click.option("--labels/--no-labels", default=True, show_default=True, help="Names with leaders.")
@click.option("--letters/--no-letters", default=True, show_default=True, help="Letters at the corners of cuts.")
@click.option("--arrows/--no-arrows", default=True, show_default=True, help="Ways of the flaps.")
@click.option("--measures/--no-measures", default=True, show_default=True, help="Lengths and angles of the plan.")
@click.option("--instruments/--no-instruments", default=True, show_default=True, help="Hooks.")
@click.option(
    "--movie", type=FILE, help="Also a film of the first cache in this style (.mp4, .webm, .gif, .webp, .png)."
)
@reading_options
@click.pass_context
def plate(
    context: click.Context,
    /,
    caches: tuple[Path, ...],
    picture: Path,
    kept: str,
    template: str | None,
    style: str,
    tone: int | None,
    frames: tuple[float, ...] | None,
    captions: tuple[tuple[int, str], ...],
    language: str,
    own: Path | None,
    font: Path | None,
    dpi: int | None,
    text: float | None,
    journal: str | None,
    plan_pen: str | None,
    overlay: bool,
    profile: Path | None,
    transparent: bool,
    movie: Path | None,
    limits: ReadLimits,
    **shown: Any,
) -> None:
    """Draw a plate: the steps of a solved procedure with captions, labels and measures, or several side by side.

    With --plate, a plate that is part of the procedure; options that are given take the place of what it says. With
    --template and a procedure's name behind -o, the template becomes a plate of the procedure, to be changed there.
    """
    if kept and template:
        raise click.UsageError("Give --plate or --template, not both.")
    with sentences(context):
        if template and _added_template(caches, picture, template, limits):
            return
        with extra("A plate", "plates"):
            from lappet.plates.draw_plate import PlateOptions, draw_plate

        if kept or template:  # what the user did not say is as the plate has it
            given = click.core.ParameterSource.DEFAULT
            shown = {name: value for name, value in shown.items() if context.get_parameter_source(name) is not given}
        if shown.get("width") is None:
            shown.pop("width", None)
        options = PlateOptions(
            *(style, tone, frames, dict(captions), language, own, font, dpi, profile, transparent, shown),
            plate=kept,
            template=template or "",
            text=text,
            journal=journal or "",
            plan_pen=cast("Any", plan_pen or ""),
            overlay=overlay,
        )
        if movie is not None:
            with extra("A film", "film,plates"):
                import imageio_ffmpeg  # noqa: F401 - missing, it would be missed after all has been drawn

                from lappet.plates.plate_movie import check_movie, draw_movie
            check_movie(movie, options)
        drawn = draw_plate(caches, [picture], options, limits, lambda line: click.echo(line, err=True))
        for note in drawn.notes:
            click.echo(f"{note.severity}: {note}", err=True)
        click.echo(picture)
        if movie is not None:
            click.echo(draw_movie(caches[0], movie, drawn.options, limits))


def _added_template(files: tuple[Path, ...], output: Path, template: str, limits: ReadLimits) -> bool:
    """Make a template a plate of a procedure; False where the output is a picture, which is to be drawn."""
    if output.suffix.lower() not in _PROCEDURES:
        with extra("A plate", "plates"):
            from lappet.plates.plate_files import SUFFIXES
        if output.suffix.lower() in SUFFIXES:
            return False
        raise refused(ProblemCode.PLATE_SUFFIX, output, output.suffix, known=", ".join((*SUFFIXES, *_PROCEDURES)))
    if len(files) != 1:
        raise click.UsageError("A template becomes a plate of one procedure; give one file.")
    from dataclasses import replace

    from lappet.plates.plate_templates import from_template
    from lappet.usd.stage import read_procedure, write_procedure

    given = read_procedure(files[0], limits=limits)
    plate = from_template(given, template)
    write_procedure(replace(given, plates=(*given.plates, plate)), output)
    panels = ", ".join(panel.name for panel in plate.panels)
    click.echo(f"Written: {output}, with the plate {plate.name!r} ({panels})")
    return True
