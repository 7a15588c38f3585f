"""Changes of a surface by many small steps, without those by which it would come to pass through itself.

A step acts on an edge: it turns it, or shrinks it to one of its ends. Vertices that are left stay where they are, so a
step is named by the places of its edge's ends: other steps number vertices anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import Surface
from lappet.geometry.surface_check import piercings

Step = tuple[bytes, bytes]
NO_STEPS: frozenset[Step] = frozenset()


def step_of_edge(points: NDArray[np.float64], first: int, second: int) -> Step:
    """Name a step.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    first, second
        The ends of its edge.

    Returns
    -------
    Step
        The name.
    """
    return points[first].tobytes(), points[second].tobytes()


@dataclass(frozen=True, eq=False)
class Change:
    """A surface after steps.

    Parameters
    ----------
    surface
        The surface.
    faces
        Which triangle of the surface before each of its triangles was, shape (m,).
    steps
        The triangles that no longer lie as before, each with the last steps that it took part in.
    """

    surface: Surface
    faces: NDArray[np.integer]
    steps: dict[int, tuple[Step, ...]]

    def then(self, after: Change) -> Change:
        """Put the steps of two changes together.

        Parameters
        ----------
        after
            A change of the surface of this one.

        Returns
        -------
        Change
            Both as one.
        """
        now = np.full(len(self.surface.triangles), -1)
        now[after.faces] = np.arange(len(after.faces))
        steps = {int(now[face]): last for face, last in self.steps.items() if now[face] >= 0}
        return Change(after.surface, self.faces[after.faces], {**steps, **after.steps})


def unchanged(surface: Surface) -> Change:
    """Leave a surface as it is.

    Parameters
    ----------
    surface
        The surface.

    Returns
    -------
    Change
        A change without steps.
    """
    return Change(surface, np.arange(len(surface.triangles)), {})


def without_piercings(change: Callable[[frozenset[Step]], Change]) -> Surface:
    """Make a change without the steps by which edges pass through triangles.

    Where none does, that is the whole change; else it is made anew without the steps to blame, until none does. What
    passed through itself before may stay so.

    Parameters
    ----------
    change
        Makes the change without some steps.

    Returns
    -------
    Surface
        The surface after it.
    """
    left_out = NO_STEPS
    while True:
        made = change(left_out)
        if not made.steps:
            return made.surface
        triangles = made.surface.triangles
        changed = np.zeros(len(triangles), bool)
        changed[list(made.steps)] = True
        pairs = piercings(made.surface.points, triangles, changed)
        to_blame = {step for face in pairs.flat for step in made.steps.get(int(face), ())}
        if not to_blame - left_out:
            return made.surface
        left_out |= to_blame
