"""`lappet new`: a procedure whose tissue is a mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lappet.commands.gravity_options import gravity_options, with_gravity
from lappet.commands.parameters import FILE, Picture
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences

UNITS = ("mm", "cm", "dm", "m", "in")  # of `lappet.tissue.mesh_file`, which `--help` does not load


@click.command()
@click.argument("mesh", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="The procedure (.usda or .usdc).")
@click.option("--thickness", type=float, help="Thicken an open surface inwards by this many mm, above 0.")
@click.option("--spacing", type=click.FloatRange(min=0, min_open=True), help="Lattice edge in mm.")
@click.option("--units", type=click.Choice(UNITS), help="The mesh's unit of length; as its file says, or else guessed.")
@gravity_options("9.81")
@click.option("--self-contact", is_flag=True, help="Keep tissue from passing through tissue whenever it is solved.")
@click.option("--at", nargs=3, type=float, metavar="X Y Z", help="Take the skin around a point, in mm; with --radius.")
@click.option("--radius", type=float, help="How far around the point of --at, in mm along the skin, above 0.")
@click.option("--outline", type=FILE, help="Take the skin inside an outline: a JSON list of points [x, y, z] in mm.")
@click.option(
    "--resolution", type=float, help="Divide edges of a region down to this many mm, above 0; as the thickness."
)
@click.option(
    "--texture",
    type=click.Choice(["grid", "mesh"]),
    default="grid",
    help="Lay a sheet's skin out for the printed grid, or keep the mesh's own texture coordinates.",
)
@click.option("--picture", type=Picture(".png"), help="Draw the mesh with the part that was taken to a PNG file.")
@click.option("--sphere", nargs=4, type=float, metavar="X Y Z R", help="Take the part inside a sphere, in mm.")
@click.option("--box", nargs=6, type=float, metavar="X Y Z X Y Z", help="Take the part inside a box (two corners, mm).")
@reading_options
@click.pass_context
def new(
    context: click.Context,
    /,
    mesh: Path,
    output: Path,
    at: tuple[float, float, float] | None,
    radius: float | None,
    outline: Path | None,
    picture: Path | None,
    sphere: tuple[float, ...] | None,
    box: tuple[float, ...] | None,
    position: tuple[float, float, float] | None,
    gravity: float | None,
    self_contact: bool,
    **options: Any,
) -> None:
    """Make a procedure whose tissue is a mesh (OBJ, STL, PLY, OFF, glTF, USD)."""
    with sentences(context):
        from dataclasses import replace

        from lappet.commands.report_table import print_report
        from lappet.core.output_place import check_place
        from lappet.core.problem import refused
        from lappet.core.problem_code import ProblemCode
        from lappet.output.mesh_picture import mesh_picture
        from lappet.output.png_writer import write_png
        from lappet.procedure import Procedure
        from lappet.tissue.mesh_file import read_mesh
        from lappet.tissue.mesh_repair import weld
        from lappet.tissue.outline_file import read_outline
        from lappet.tissue.tissue_from_mesh import new_tissue
        from lappet.usd.stage import check_usd_place, write_procedure

        check_usd_place(output)
        if picture is not None:
            check_place(picture)
        if (at is None) != (radius is None):
            raise refused(ProblemCode.REGION_AT_AND_RADIUS, mesh.name)
        tissue, report = new_tissue(
            mesh,
            outline=None if outline is None else read_outline(outline),
            at=(at, radius) if at is not None and radius is not None else None,
            sphere=(sphere[:3], sphere[3]) if sphere else None,
            box=(box[:3], box[3:]) if box else None,
            **options,
        )
        tissue = replace(with_gravity(tissue, position, gravity), self_contact=self_contact)
        write_procedure(Procedure(tissue), output)
        print_report(report)
        click.echo(f"Written: {output}")
        if picture is not None:
            mesh_as_read = read_mesh(mesh, options["units"], options["limits"])[0]
            write_png(mesh_picture(weld(mesh_as_read)[0], tissue), picture)
            click.echo(f"Written: {picture}")
