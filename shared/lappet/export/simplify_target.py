"""How far a skin is to be simplified: to a number of triangles, or as far as an error allows."""

from __future__ import annotations

import re
from dataclasses import dataclass

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

LEAST = 100  # triangles


@dataclass(frozen=True)
class SimplifyTarget:
    """What `--simplify` asks for; one of the two.

    Parameters
    ----------
    triangles
        How many triangles the skin of an epoch may have.
    error_mm
        How far its surface may be from the cache's in any frame, in mm.
    """

    triangles: int | None = None
    error_mm: float | None = None

    @staticmethod
    def of(text: str) -> SimplifyTarget:
        """Read what a user wrote.

        Parameters
        ----------
        text
            A number of triangles such as "20000", or an error such as "0.2mm".

        Returns
        -------
        SimplifyTarget
            The target.

        Raises
        ------
        RefusedError
            If it is neither.
        """
        found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(mm)?\s*", text)
        number = float(found[1]) if found else 0.0
        if found and found[2] and 0.0 < number <= 100.0:
            return SimplifyTarget(error_mm=number)
        if found and not found[2] and number == int(number) and number >= LEAST:
            return SimplifyTarget(triangles=int(number))
        raise refused(ProblemCode.EXPORT_SIMPLIFY_TARGET, "--simplify", text, least=LEAST)
