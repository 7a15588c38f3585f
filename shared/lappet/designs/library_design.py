"""A row of the flap library: a design by its name, with its parameters, their ranges and where these come from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.flap_design import FlapDesign


@dataclass(frozen=True)
class Parameter:
    """A measure of a design that its user may choose.

    Parameters
    ----------
    name
        Name as an argument of the design's function.
    meaning
        What it measures, in a few words.
    unit
        "mm", "°", or nothing for a share or a count.
    default
        Its value if nothing is said.
    least
        Smallest value.
    most
        Largest value.
    source
        Where default and range come from.
    whole
        Whether it is a count.
    """

    name: str
    meaning: str
    unit: str
    default: float
    least: float
    most: float
    source: str
    whole: bool = False

    @property
    def range_text(self) -> str:
        """The range with its unit, for people."""
        unit = f" {self.unit}" if self.unit == "mm" else self.unit
        return f"{self.least:g} to {self.most:g}{unit}"


@dataclass(frozen=True)
class LibraryDesign:
    """A design of the flap library.

    Parameters
    ----------
    name
        Name on the command line and in Blender's menu, with hyphens.
    title
        Name for people.
    indication
        What it is for, in one line.
    parameters
        Its measures.
    draw
        Function that draws it: center, direction, the parameters by name, `normal`, `mirrored`, `project`.
    center
        What of the design lies at the point that is given.
    direction
        What the direction that is given runs along.
    lines
        How the direction lies to the lines of the skin where there is a rule: "along", "across", or "".
    sources
        Where the construction comes from.
    remark
        What is to be known of what is measured, in a sentence, or "".
    """

    name: str
    title: str
    indication: str
    parameters: tuple[Parameter, ...]
    draw: Callable[..., FlapDesign]
    center: str
    direction: str
    lines: Literal["along", "across", ""]
    sources: str
    remark: str = ""

    def values(self, given: Mapping[str, float]) -> dict[str, float]:
        """Complete the values of the parameters by their defaults.

        Parameters
        ----------
        given
            Values by name, those that are not the default.

        Returns
        -------
        dict[str, float]
            The value of every parameter.

        Raises
        ------
        RefusedError
            If a name is unknown or a value is out of its range.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        for name, value in given.items():
            if name not in known:
                raise refused(ProblemCode.DESIGN_PARAMETER, self.name, name, known=", ".join(known))
            parameter = known[name]
            fits = np.isfinite(value) and parameter.least <= value <= parameter.most
            if not fits or (parameter.whole and value != round(value)):
                raise refused(
                    ProblemCode.DESIGN_RANGE,
                    self.name,
                    f"{value:g}",
                    name=name,
                    range=("a whole number, " if parameter.whole else "") + parameter.range_text,
                )
        return {name: float(given.get(name, parameter.default)) for name, parameter in known.items()}
