"""The joints of the body: the middles of the small cubes that the base mesh has for its rig."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.models.body_mesh import body_mesh

_PREFIX = "joint-"


def joints(points: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Find the joints of a shaped body.

    Parameters
    ----------
    points
        Vertices of the base mesh on the body in mm, as `lappet.models.body_shape.shaped` gives them, shape (n, 3).

    Returns
    -------
    dict[str, NDArray[np.float64]]
        Place of each joint in mm, shape (3,), by the rig's names, such as `r-elbow`.

    Raises
    ------
    RefusedError
        If the package is not there.
    """
    mesh = body_mesh()
    names = sorted({str(name) for name in mesh.group if str(name).startswith(_PREFIX)})
    return {name[len(_PREFIX) :]: points[np.unique(mesh.faces_of((name,)))].mean(axis=0) for name in names}
