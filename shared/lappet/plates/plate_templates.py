"""Plates that are good without editing: of the steps, for an atlas, before and after, in section, for a cover."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import CUTS, Excision, Hook, Incision, Procedure, Retractor, Suture, SutureRun, Undermine
from lappet.procedure.exact_values import Point
from lappet.procedure.plate import PanelStep, Plate, PlatePanel


def _panels(steps: tuple[PanelStep, ...]) -> tuple[PlatePanel, ...]:
    return tuple(PlatePanel(step, step) for step in steps)


def steps_of(procedure: Procedure) -> tuple[PanelStep, ...]:
    """List the steps that an operation has.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    tuple[PanelStep, ...]
        The steps in order; which frames show them is known when it has been solved.
    """
    kinds = [type(event) for event in procedure.events]
    cut = any(kind in CUTS or kind in (Incision, Excision, Undermine) for kind in kinds)
    pulled = any(kind in (Hook, Retractor) for kind in kinds)
    sewn = any(kind in (Suture, SutureRun) for kind in kinds)
    found: list[PanelStep] = ["plan"]
    found += ["cut"] if cut else []
    found += ["raised", "placed"] if pulled else []
    found += ["sutured"] if sewn else []
    return (*found, "result")


def _steps(procedure: Procedure) -> Plate:
    return Plate("steps", panels=_panels(steps_of(procedure)))


def _atlas(procedure: Procedure) -> Plate:
    there = steps_of(procedure)
    wanted: tuple[PanelStep, ...] = ("plan", "cut", "placed", "result")
    return Plate(
        "atlas",
        style="ink",
        width=85.0,
        columns=2,
        labels=False,
        panels=_panels(tuple(each for each in wanted if each in there)),
    )


def _comparison(_: Procedure) -> Plate:
    before = PlatePanel("before", "plan")
    after = PlatePanel("after", "result", ghost="plan")
    return Plate("comparison", style="halftone", columns=2, instruments=False, panels=(before, after))


def _section(procedure: Procedure) -> Plate:
    at, normal = _across(procedure)
    there = steps_of(procedure)
    wanted: tuple[PanelStep, ...] = ("plan", "cut", "sutured", "result")
    panels = _panels(tuple(each for each in wanted if each in there))
    return Plate("section", section_at=at, section_normal=normal, columns=2, panels=panels)


def _cover(_: Procedure) -> Plate:
    return Plate(
        "cover",
        style="wash",
        columns=1,
        labels=False,
        letters=False,
        measures=False,
        panels=(PlatePanel("placed", "placed", caption=" "),),
    )


TEMPLATES: dict[str, Callable[[Procedure], Plate]] = {
    "steps": _steps,
    "atlas": _atlas,
    "comparison": _comparison,
    "section": _section,
    "cover": _cover,
}


def from_template(procedure: Procedure, template: str, name: str = "") -> Plate:
    """Make a plate.

    Parameters
    ----------
    procedure
        The procedure that it shows.
    template
        A name in `TEMPLATES`.
    name
        The plate's name; without one that of the template, with a number where the procedure has it already.

    Returns
    -------
    Plate
        The plate.

    Raises
    ------
    RefusedError
        If the procedure has a plate of that name.
    """
    taken = {plate.name for plate in procedure.plates}
    if name in taken:
        raise refused(ProblemCode.PLATE_NAMED, name, name, known=", ".join(sorted(taken)))
    if not name:
        name, count = template, 2
        while name in taken:
            name, count = f"{template}_{count}", count + 1
    return replace(TEMPLATES[template](procedure), name=name)


def _across(procedure: Procedure) -> tuple[Point, Point]:
    """The plane across the longest cut, at its middle, in which the section of its wound is shortest."""
    cuts = [np.array(event.points, np.float64) for event in procedure.events if isinstance(event, Incision)]
    if not cuts:
        points = procedure.tissue.points
        at = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return _plain(at), (1.0, 0.0, 0.0)
    longest = max(cuts, key=lambda line: float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()))
    middle = longest.mean(axis=0)
    along = np.linalg.svd(longest - middle, full_matrices=False)[2][0]
    return _plain(middle), _plain(np.round(along, 6))


def _plain(values: np.ndarray) -> Point:
    x, y, z = (float(each) + 0.0 for each in np.round(values, 4))
    return (x, y, z)
