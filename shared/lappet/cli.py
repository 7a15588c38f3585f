"""The command `lappet`: thin, each subcommand loads what it needs when it runs.

Exit status: 0 done, 1 refused or not converged, 2 usage.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from lappet.reports.commands import report_group

_FILE = click.Path(path_type=Path)


class _Version(click.Option):
    """`--version`, which looks the version up only when it is asked for."""

    def __init__(self, *declarations: Any, **attributes: Any) -> None:
        attributes.update(is_flag=True, expose_value=False, is_eager=True, help="Show the version and exit.")
        super().__init__(*declarations, callback=self._show, **attributes)

    @staticmethod
    def _show(context: click.Context, _: click.Parameter, value: bool) -> None:
        if value and not context.resilient_parsing:
            from lappet import __version__

            click.echo(f"lappet {__version__}")
            context.exit()


class FrameRange(click.ParamType):
    """`A:B`, `A:`, `:B` or `A`: integer time codes, both included."""

    name = "A:B"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The pair (first or None, last or None)."""
        if isinstance(value, tuple):
            return value
        first, colon, last = str(value).partition(":")
        try:
            a = int(first) if first.strip() else None
            b = int(last) if last.strip() else None
        except ValueError:
            self.fail(f"{value!r} is no range of frames; give A:B, two whole time codes.", param, ctx)
        if not colon:
            b = a
        if a is None and b is None:
            self.fail(f"{value!r} names no frame; give A:B, two whole time codes.", param, ctx)
        if a is not None and b is not None and a > b:
            self.fail(f"{value!r} ends before it begins; give the first frame first.", param, ctx)
        return (a, b)


class FrameList(click.ParamType):
    """`1,20,45`: time codes."""

    name = "T,T,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The time codes as a list of floats."""
        if isinstance(value, list):
            return value
        try:
            return [float(each) for each in str(value).split(",")]
        except ValueError:
            self.fail(f"{value!r} is no list of frames; give time codes with commas between them.", param, ctx)


class Size(click.ParamType):
    """`1280x960`: pixels."""

    name = "WxH"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The pair (width, height)."""
        if isinstance(value, tuple):
            return value
        width, _, height = str(value).lower().partition("x")
        if not (width.isdecimal() and height.isdecimal()):
            self.fail(f"{value!r} is no size; give WIDTHxHEIGHT in pixels, like 1280x960.", param, ctx)
        return (int(width), int(height))


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option("--version", cls=_Version)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def cli(context: click.Context, debug: bool) -> None:
    """Plan a skin-flap operation, solve how the tissue moves, and render figures of it."""
    context.obj = debug


def main() -> None:
    """The console script."""
    cli.main(prog_name="lappet")


def solve_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that every command that solves has."""
    options = [
        click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm."),
        click.option(
            "--tolerance",
            type=click.FloatRange(min=0, max=1, min_open=True, max_open=True),
            default=1e-3,
            show_default=True,
            help="Residual over the scene's force scale.",
        ),
        click.option(
            "--quadrature", type=click.Choice(["1", "4", "8"]), default="1", show_default=True, help="Points per cell."
        ),
        click.option(
            "--precision",
            type=click.Choice(["float", "double"]),
            default="float",
            show_default=True,
            help="Arithmetic.",
        ),
        click.option(
            "--store", type=_FILE, help="Folder for solved frames.  [default: LAPPET_STORE or the user's cache]"
        ),
        click.option("--daemon", metavar="ADDR", help="Address of a running daemon, like tcp://127.0.0.1:5555."),
        click.option(
            "--error-estimate/--no-error-estimate",
            default=True,
            show_default=True,
            help="Estimate the displacement error with a coarser solve.",
        ),
        click.option(
            "--strain/--no-strain",
            default=True,
            show_default=True,
            help="Compute strain, stress and tension on the surface.",
        ),
        click.option(
            "--whole", is_flag=True, help="Solve every frame everywhere, also where its changes do not reach."
        ),
    ]
    for option in reversed(options):
        command = option(command)
    return command


@cli.command()
@click.argument("procedure", type=_FILE)
@click.option("-o", "--output", type=_FILE, help="The skin cache.  [default: PROCEDURE.cache.usdc]")
@click.option("--report", "report_path", type=_FILE, help="Write what the solve took as JSON.")
@click.option("--frames", type=FrameRange(), help="Solve up to B and write A to B.")
@click.option(
    "--target-error",
    type=click.FloatRange(min=0, min_open=True),
    metavar="MM",
    help="Choose spacing, quadrature and tolerance for this root mean square displacement error of the skin.",
)
@solve_options
@click.pass_context
def solve(
    context: click.Context,
    /,
    procedure: Path,
    output: Path | None,
    report_path: Path | None,
    frames: tuple[int | None, int | None] | None,
    target_error: float | None,
    **options: Any,
) -> None:
    """Solve a procedure and write its skin cache."""
    with sentences(context):
        from lappet.solve_command import run_solve, run_to_target, summary

        cache = output or procedure.with_suffix(".cache.usdc")
        options["frames"] = frames or (None, None)
        if target_error is None:
            result = run_solve(procedure, cache, report_path, **options)
        else:
            given = [
                name for name in ("spacing", "quadrature", "tolerance", "error_estimate") if is_given(context, name)
            ]
            if given:
                option = "--" + given[0].replace("_", "-")
                raise click.UsageError(f"--target-error chooses {option} itself; leave {option} out.")
            result = run_to_target(procedure, cache, report_path, target_error, **options)
        click.echo(summary(result))
    if not result.complete:
        context.exit(1)


@cli.command()
@click.option(
    "-o",
    "--output",
    "folder",
    type=_FILE,
    default=Path("lappet-demo"),
    show_default=True,
    help="Folder for the results.",
)
@solve_options
@click.pass_context
def demo(context: click.Context, /, folder: Path, **options: Any) -> None:
    """Solve and render the bundled Z-plasty, at a lattice spacing of 1.33 mm where none is given."""
    import shutil

    with sentences(context):
        from lappet.demo import SPACING, figures_of, z_plasty
        from lappet.render import render_cache
        from lappet.solve_command import run_solve, summary

        options["spacing"] = options["spacing"] or SPACING

        folder.mkdir(parents=True, exist_ok=True)
        procedure = folder / "z_plasty.usda"
        shutil.copyfile(z_plasty(), procedure)
        cache = folder / "z_plasty.cache.usdc"
        result = run_solve(procedure, cache, folder / "z_plasty.report.json", **options)
        click.echo(summary(result))
        if result.complete:

            def draw(cache: Path, figures: Path) -> list[Path]:
                click.echo("Rendering figures with Blender.", err=True)
                return render_cache(cache, figures, progress=lambda line: click.echo(line, err=True))

            pictures = figures_of(cache, folder / "figures", draw)
            click.echo("Pictures:")
            for picture in pictures:
                click.echo(f"  {picture}")
            click.echo(f"Skin cache: {cache.resolve()}")
            click.echo(f"Report:     {(folder / 'z_plasty.report.json').resolve()}")
    if not result.complete:
        context.exit(1)


@cli.command()
@click.argument("procedure", type=_FILE)
@click.pass_context
def check(context: click.Context, /, procedure: Path) -> None:
    """Validate a procedure: every problem, each with its mend."""
    with sentences(context):
        from lappet.full_check import full_check

        notes: list[str] = []
        problems = full_check(procedure, notes)
        for note in notes:
            click.echo(f"note: {note}")
        for problem in problems:
            click.echo(f"{problem.severity}: {problem}")
        errors = sum(problem.severity == "error" for problem in problems)
        if not problems:
            click.echo(f"{procedure}: no problem found.")
    if errors:
        context.exit(1)


@cli.command()
@click.argument("procedure", type=_FILE)
@click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm.")
@click.option("--no-lattice", is_flag=True, help="Leave out the lattice counts (they need the daemon).")
@click.option("--daemon", metavar="ADDR", help="Address of a running daemon.")
@click.option("--economy", type=_FILE, metavar="FILE", help="Costs from this economy.json of `lappet report economy`.")
@click.pass_context
def inspect(
    context: click.Context,
    /,
    procedure: Path,
    spacing: float | None,
    no_lattice: bool,
    daemon: str | None,
    economy: Path | None,
) -> None:
    """Print a procedure's storyboard, epochs, scene profile and lattice counts."""
    with sentences(context):
        from lappet.inspect_procedure import inspect_procedure

        click.echo(
            inspect_procedure(procedure, spacing=spacing, lattice=not no_lattice, daemon=daemon, economy=economy)
        )


@cli.command()
@click.argument("cache", type=_FILE)
@click.option("-o", "--output", "folder", type=_FILE, required=True, help="Folder for the pictures.")
@click.option("--frames", type=FrameList(), help="Time codes of the stills.  [default: the last]")
@click.option("--filmstrip/--no-filmstrip", default=True, show_default=True, help="The steps on one sheet.")
@click.option("--animation", type=click.Choice(["none", "png", "mp4"]), default="none", show_default=True)
@click.option("--size", type=Size(), default="1280x960", show_default=True, help="Pixels of a still.")
@click.option("--movie-size", type=Size(), help="Pixels of an animation.  [default: half of size]")
@click.option("--samples", type=click.IntRange(1, 65536), help="Cycles samples a pixel.  [default: 6]")
@click.option("--movie-samples", type=click.IntRange(1, 65536), help="The same of an animation.  [default: 4]")
@click.option("--view", help="Where the camera stands.  [default: oblique]")
@click.option("--color", help="What the skin shows.  [default: grid]")
@click.option("--engine", help="Blender's renderer.  [default: cycles]")
@click.pass_context
def render(context: click.Context, /, cache: Path, folder: Path, **options: Any) -> None:
    """Render stills, a filmstrip and an animation of a skin cache with Blender (bpy)."""
    with sentences(context):
        from lappet.render import render_cache

        given = {name: value for name, value in options.items() if value is not None}
        for picture in render_cache(cache, folder, progress=lambda line: click.echo(line, err=True), **given):
            click.echo(picture)


@cli.command()
@click.argument("mesh", type=_FILE)
@click.option("-o", "--output", type=_FILE, required=True, help="The procedure (.usda or .usdc).")
@click.option("--thickness", type=float, help="Thicken an open surface inwards by this many mm.")
@click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm.")
@click.option("--units", help="The mesh's unit of length (mm, cm, m, inch); guessed when left out.")
@click.option("--sphere", nargs=4, type=float, metavar="X Y Z R", help="Take the part inside a sphere, in mm.")
@click.option("--box", nargs=6, type=float, metavar="X Y Z X Y Z", help="Take the part inside a box (two corners, mm).")
@click.pass_context
def new(
    context: click.Context,
    /,
    mesh: Path,
    output: Path,
    sphere: tuple[float, ...] | None,
    box: tuple[float, ...] | None,
    **options: Any,
) -> None:
    """Make a procedure whose tissue is a mesh (OBJ, STL, PLY, glTF, USD)."""
    with sentences(context):
        from lappet.procedure import Procedure
        from lappet.tissue import new_tissue
        from lappet.usd_stage import write_procedure

        tissue, found = new_tissue(
            mesh,
            sphere=(sphere[:3], sphere[3]) if sphere else None,
            box=(box[:3], box[3:]) if box else None,
            **options,
        )
        write_procedure(Procedure(tissue), output)
        for line in found:
            click.echo(line)
        click.echo(f"Written: {output}")


@contextmanager
def sentences(context: click.Context) -> Iterator[None]:
    """Ends the command with exit status 1 and a sentence on standard error where work is refused or stopped."""
    try:
        yield
    except (click.ClickException, click.exceptions.Exit, click.Abort):
        raise
    except KeyboardInterrupt:
        click.echo("Stopped.", err=True)
        context.exit(1)
    except Exception as error:
        debug = bool(context.find_root().obj)
        if debug:
            raise
        click.echo(sentence(error), err=True)
        context.exit(1)


def sentence(error: Exception) -> str:
    """What to tell the user about an error: its own sentence where it has one, else a request for a report."""
    own = type(error).__module__.partition(".")[0] == "lappet"
    if own and str(error):
        return str(error)
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename or 'A file'}: {error.strerror.lower()}; look at the path and its permissions."
    if isinstance(error, (OSError, ImportError)) and str(error):
        return str(error)
    said = f"{type(error).__name__}: {error}".splitlines()[0]
    return f"Lappet failed ({said}); run it as `lappet --debug ...` and report what it shows."


def is_given(context: click.Context, name: str) -> bool:
    """Whether the user gave the option."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


cli.add_command(report_group(sentences))

if __name__ == "__main__":
    main()
