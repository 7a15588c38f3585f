"""The space of a stage and of the prims in it, as seen from the space of a procedure: mm and Z up.

`usd` is `lappet.usd.stage.pxr()`; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode


class StageSpace:
    """Takes points and transforms from a stage to mm and Z up.

    `matrix` is the (4, 4) row-vector matrix from stage space, None where the two are the same.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    problems
        Gets an error where the stage's units make no sense.
    notes
        Gets a note of what is converted.
    """

    def __init__(self, stage: Any, usd: Any, problems: list[Problem], notes: list[Problem]) -> None:
        self._usd = usd
        self.matrix = _stage_matrix(stage, usd, problems, notes)
        self._rest = usd.UsdGeom.XformCache(usd.Usd.TimeCode(stage.GetStartTimeCode()))

    def placed(self, points: NDArray[np.float64], prim: Any) -> NDArray[np.float64]:
        """Take points from the space of a prim to mm and Z up, at the start of the timeline.

        Parameters
        ----------
        points
            Points in the prim's space, shape (n, 3).
        prim
            The prim.

        Returns
        -------
        NDArray[np.float64]
            Points in mm, shape (n, 3).
        """
        matrix = self.to_rest(prim)
        if matrix is None or len(points) == 0:
            return points
        return np.asarray(points @ matrix[:3, :3] + matrix[3, :3], np.float64)

    def to_rest(self, prim: Any) -> NDArray[np.float64] | None:
        """Find the matrix from the space of a prim to mm and Z up.

        Parameters
        ----------
        prim
            The prim.

        Returns
        -------
        NDArray[np.float64] | None
            Row-vector matrix of shape (4, 4), or None for the identity.
        """
        matrix = np.array(self._rest.GetLocalToWorldTransform(prim), np.float64)
        if np.array_equal(matrix, np.eye(4)):
            return self.matrix
        return matrix if self.matrix is None else matrix @ self.matrix

    def motion(self, prim: Any, start: float) -> list[tuple[float, NDArray[np.float64]]]:
        """Read the transform of a prim and its parents at every time sample.

        Parameters
        ----------
        prim
            The prim.
        start
            Time code of the one sample of a prim that does not move.

        Returns
        -------
        list[tuple[float, NDArray[np.float64]]]
            Samples (time code, matrix of shape (4, 4)) in mm and Z up.
        """
        times: set[float] = set()
        parent = prim
        while parent and not parent.IsPseudoRoot():
            if parent.IsA(self._usd.UsdGeom.Xformable):
                times.update(self._usd.UsdGeom.Xformable(parent).GetTimeSamples())
            parent = parent.GetParent()
        samples = []
        for time in sorted(times) or [start]:
            samples.append((time, self.motion_at(prim, time)))
        return samples

    def motion_at(self, prim: Any, time: float) -> NDArray[np.float64]:
        """Read the transform of a prim and its parents at a time.

        Parameters
        ----------
        prim
            The prim.
        time
            Time code; the default value's where it is not finite.

        Returns
        -------
        NDArray[np.float64]
            Row-vector matrix of shape (4, 4) in mm and Z up.
        """
        code = self._usd.Usd.TimeCode(time) if np.isfinite(time) else self._usd.Usd.TimeCode.Default()
        matrix = np.array(self._usd.UsdGeom.XformCache(code).GetLocalToWorldTransform(prim), np.float64)
        return matrix if self.matrix is None else np.linalg.inv(self.matrix) @ matrix @ self.matrix


def _stage_matrix(stage: Any, usd: Any, problems: list[Problem], notes: list[Problem]) -> NDArray[np.float64] | None:
    """The matrix from stage space, None where the two are the same or the stage's units make no sense."""
    geom = usd.UsdGeom
    units, axis = float(geom.GetStageMetersPerUnit(stage)), str(geom.GetStageUpAxis(stage))
    if not (np.isfinite(units) and units > 0.0):
        problems.append(problem(ProblemCode.STAGE_UNITS, "/", f"{units:g}"))
        return None
    matrix = np.eye(4)
    if abs(units - 0.001) > 1e-12:
        matrix[:3, :3] *= units / 0.001
        said = "" if geom.StageHasAuthoredMetersPerUnit(stage) else " by USD's default"
        notes.append(problem(ProblemCode.STAGE_CONVERTED, "/", f"{units:g}", said=said))
    if axis == "Y":
        matrix[:3, :3] = matrix[:3, :3] @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        said = "" if stage.HasAuthoredMetadata("upAxis") else " by USD's default"
        notes.append(problem(ProblemCode.STAGE_TURNED, "/", axis, said=said))
    return None if np.array_equal(matrix, np.eye(4)) else matrix
