"""The options that say how the patient lies and how strong gravity is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from lappet.commands.parameters import Position

if TYPE_CHECKING:
    from lappet.procedure.tissue import Tissue


def gravity_options(default: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Make the decorator that adds `--position` and `--gravity`.

    Parameters
    ----------
    default
        What gravity is where it is left out, for the help.

    Returns
    -------
    Callable[[Callable[..., Any]], Callable[..., Any]]
        The decorator.
    """

    def with_options(command: Callable[..., Any]) -> Callable[..., Any]:
        strength = click.option(
            "--gravity",
            type=click.FloatRange(min=0),
            help=f"Acceleration of gravity in m/s², 0 for none.  [default: {default}]",
        )
        position = click.option(
            "--position",
            type=Position(),
            help="How the patient lies: upright, supine, prone, left_lateral, right_lateral, or gravity's direction "
            "X,Y,Z.",
        )
        return position(strength(command))

    return with_options


def with_gravity(tissue: Tissue, position: tuple[float, float, float] | None, gravity: float | None) -> Tissue:
    """Lay a patient otherwise.

    Parameters
    ----------
    tissue
        The tissue.
    position
        The direction of gravity, any length, or None to leave it.
    gravity
        The acceleration in m/s², or None to leave it.

    Returns
    -------
    Tissue
        The tissue with what was given.
    """
    if position is not None:
        tissue = replace(tissue, gravity_direction=position)
    return tissue if gravity is None else replace(tissue, gravity=gravity)
