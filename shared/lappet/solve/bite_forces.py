"""The force on each bite of a suture: a thread that slides pulls along both of its pieces that meet there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.solved_frame import SolvedFrame

KNOT = 1e-3  # mm; a piece this short has no direction (solverd/src/force/constraints/point_constraint.cpp)


def bite_points(frame: SolvedFrame) -> list[NDArray[np.float64]]:
    """Collect where the bites of each suture are.

    Parameters
    ----------
    frame
        A frame.

    Returns
    -------
    list[NDArray[np.float64]]
        For each of its sutures the places of its bites in mm in the order of the thread, shape (n, 3).
    """
    counts = frame.suture_inner_bites if len(frame.suture_inner_bites) else np.zeros(len(frame.suture_index), np.int32)
    inner = np.split(frame.inner_bite_points, np.cumsum(counts)[:-1]) if len(counts) else []
    return [np.vstack([ends[:1], between, ends[1:]]) for ends, between in zip(frame.suture_points, inner, strict=True)]


def bite_forces(frame: SolvedFrame) -> list[NDArray[np.float64]]:
    """Compute the forces of the sutures on the tissue, bite by bite.

    The tension of a thread acts along the piece to the next bite and along that from the last; where it is tied to its
    first bite, the two ends pull together. A suture that closes exactly pulls either way with its force, of which only
    the size is known where its ends meet.

    Parameters
    ----------
    frame
        A frame.

    Returns
    -------
    list[NDArray[np.float64]]
        For each of its sutures the size of the force on each bite in mN, shape (n,).
    """
    forces = []
    for points, tension in zip(bite_points(frame), frame.suture_forces, strict=True):
        if len(points) == 2:
            forces.append(np.full(2, float(tension)))
            continue
        pieces = np.diff(points, axis=0)
        along = pieces / np.sqrt(np.einsum("ji,ji->j", pieces, pieces) + KNOT**2)[:, None]
        pull = np.zeros(points.shape)
        pull[:-1] += along
        pull[1:] -= along
        if np.linalg.norm(points[0] - points[-1]) < KNOT:
            pull[0] = pull[-1] = pull[0] + pull[-1]
        forces.append(float(tension) * np.linalg.norm(pull, axis=1))
    return forces
