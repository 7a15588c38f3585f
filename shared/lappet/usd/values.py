"""Reads single values from USD prims, with a `Problem` for every value that is missing or has the wrong type.

`usd` is `lappet.usd.stage.pxr()`; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode


class Reader:
    """Collects the problems and notes of one stage while values are read from it.

    Geometry is returned in mm with Z up: `space` is the (4, 4) row-vector matrix from stage space, None where the two
    are the same.
    """

    def __init__(self, stage: Any, usd: Any, notes: list[str]) -> None:
        self.stage, self.usd, self.notes = stage, usd, notes
        self.problems: list[Problem] = []
        self.space = self._stage_space()
        self._rest = usd.UsdGeom.XformCache(usd.Usd.TimeCode(stage.GetStartTimeCode()))

    def problem(self, path: object, value: object, sentence: str, remedy: str) -> None:
        """Adds an error."""
        self.problems.append(Problem(ProblemCode.UNSORTED, str(path), str(value), sentence, remedy))

    def number(self, prim: Any, name: str, default: float | None = None) -> float:
        """A number or time code; without a default it must be authored. NaN where it could not be read."""
        value = self._value(prim, name, default is None)
        if value is None:
            return float("nan") if default is None else default
        if hasattr(value, "GetValue"):  # a time code
            value = value.GetValue()
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self._wrong_type(prim, name, value, "a number")
            return float("nan")
        return float(value)

    def samples(self, prim: Any, name: str) -> tuple[tuple[float, float], ...]:
        """The (time, number) samples of an animated number; one that does not move gives one at the start; none where
        nothing is authored."""
        attribute = prim.GetAttribute(name)
        if not (attribute and attribute.HasAuthoredValue()):
            return ()
        times = attribute.GetTimeSamples()
        at = [self.usd.Usd.TimeCode(time) for time in times] or [self.usd.Usd.TimeCode.Default()]
        found = []
        for time, code in zip(times or [float(self.stage.GetStartTimeCode())], at, strict=True):
            value = attribute.Get(code)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                self._wrong_type(prim, name, value, "a number")
                return ()
            found.append((float(time), float(value)))
        return tuple(found)

    def text(self, prim: Any, name: str, default: str | None = None) -> str:
        """A token or string; without a default it must be authored."""
        value = self._value(prim, name, default is None)
        if value is None:
            return default or ""
        if not isinstance(value, str):
            self._wrong_type(prim, name, value, "a token or string")
            return default or ""
        return value

    def flag(self, prim: Any, name: str, default: bool) -> bool:
        """A bool."""
        value = self._value(prim, name, False)
        if value is None:
            return default
        if not isinstance(value, (bool, int)):
            self._wrong_type(prim, name, value, "a bool")
            return default
        return bool(value)

    def vector(self, prim: Any, name: str, width: int, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """`width` numbers; without a default they must be authored."""
        missing = default if default is not None else (float("nan"),) * width
        value = self._value(prim, name, default is None)
        if value is None:
            return missing
        array = _numbers(value)
        if array is None or array.shape != (width,):
            self._wrong_type(prim, name, value, f"{width} numbers")
            return missing
        return tuple(float(v) for v in array)

    def vectors(self, prim: Any, name: str) -> NDArray[np.float64]:
        """An authored array of 3-vectors, (n, 3)."""
        value = self._value(prim, name, True)
        if value is None:
            return np.zeros((0, 3))
        array = _numbers(value)
        if array is not None and array.size == 0:
            return np.zeros((0, 3))
        if array is None or array.ndim != 2 or array.shape[1] != 3:
            self._wrong_type(prim, name, value, "an array of points")
            return np.zeros((0, 3))
        return array

    def integers(self, prim: Any, name: str, optional: bool = False) -> NDArray[np.int32]:
        """An array of integers of a built-in attribute, (n,)."""
        value = self._value(prim, name, not optional)
        if value is None:
            return np.zeros(0, np.int32)
        try:
            array = np.array(value)
        except (TypeError, ValueError):
            array = np.zeros((0, 0))
        if array.size == 0 and array.ndim == 1:
            return np.zeros(0, np.int32)
        if array.ndim != 1 or array.dtype.kind not in "iu":
            self._wrong_type(prim, name, value, "an array of integers")
            return np.zeros(0, np.int32)
        return array.astype(np.int32)

    def target(self, prim: Any, name: str) -> str:
        """The path of a relationship's one target, "" if there is none."""
        relationship = prim.GetRelationship(name)
        targets = relationship.GetForwardedTargets() if relationship else []
        if len(targets) > 1:
            found = ", ".join(str(target) for target in targets)
            sentence = f"{name} has {len(targets)} targets: {found}."
            self.problem(prim.GetPath(), found, sentence, "Leave one target.")
        return str(targets[0]) if targets else ""

    def points(self, prim: Any) -> NDArray[np.float64]:
        """The rest points of a mesh, curve or Points prim, (n, 3) in mm."""
        return self.placed(self.vectors(prim, "points"), prim)

    def placed(self, points: NDArray[np.float64], prim: Any) -> NDArray[np.float64]:
        """Points from the space of a prim to mm and Z up, at the start of the timeline."""
        matrix = self.to_rest(prim)
        if matrix is None or len(points) == 0:
            return points
        return np.asarray(points @ matrix[:3, :3] + matrix[3, :3], np.float64)

    def to_rest(self, prim: Any) -> NDArray[np.float64] | None:
        """The (4, 4) row-vector matrix from the space of a prim to mm and Z up; None for the identity."""
        matrix = np.array(self._rest.GetLocalToWorldTransform(prim), np.float64)
        if np.array_equal(matrix, np.eye(4)):
            return self.space
        return matrix if self.space is None else matrix @ self.space

    def motion(self, prim: Any, start: float) -> list[tuple[float, NDArray[np.float64]]]:
        """(time, (4, 4) matrix) at every time sample of the prim and its parents, in mm and Z up.

        A prim that does not move gives one sample at `start`.
        """
        times: set[float] = set()
        parent = prim
        while parent and not parent.IsPseudoRoot():
            if parent.IsA(self.usd.UsdGeom.Xformable):
                times.update(self.usd.UsdGeom.Xformable(parent).GetTimeSamples())
            parent = parent.GetParent()
        samples = []
        for time in sorted(times) or [start]:
            code = self.usd.Usd.TimeCode(time) if np.isfinite(time) else self.usd.Usd.TimeCode.Default()
            matrix = np.array(self.usd.UsdGeom.XformCache(code).GetLocalToWorldTransform(prim), np.float64)
            if self.space is not None:
                matrix = np.linalg.inv(self.space) @ matrix @ self.space
            samples.append((time, matrix))
        return samples

    def _value(self, prim: Any, name: str, required: bool) -> Any:
        attribute = prim.GetAttribute(name)
        value = None
        if attribute and attribute.HasAuthoredValue():
            value = attribute.Get(self.usd.Usd.TimeCode.EarliestTime())
            if attribute.GetNumTimeSamples() > 0 and name.startswith("lappet:"):
                self.notes.append(
                    f"{prim.GetPath()}: {name} is animated; its first value, {value}, is used throughout."
                )
        if value is None and required:
            self.problem(prim.GetPath(), "no value", f"{name} has no value.", f"Author {name}.")
        return value

    def _wrong_type(self, prim: Any, name: str, value: object, wanted: str) -> None:
        shown = " ".join(str(value).split())
        shown = shown if len(shown) <= 40 else shown[:37] + "..."
        sentence = f"{name} is {shown!r}, not {wanted}."
        self.problem(prim.GetPath(), shown, sentence, f"Author {name} as {wanted}.")

    def _stage_space(self) -> NDArray[np.float64] | None:
        geom = self.usd.UsdGeom
        units, axis = float(geom.GetStageMetersPerUnit(self.stage)), str(geom.GetStageUpAxis(self.stage))
        if not (np.isfinite(units) and units > 0.0):
            sentence = f"The stage has {units:g} metres per unit."
            self.problem("/", f"{units:g}", sentence, "Set metersPerUnit to 0.001 for mm.")
            return None
        matrix = np.eye(4)
        if abs(units - 0.001) > 1e-12:
            matrix[:3, :3] *= units / 0.001
            said = "" if geom.StageHasAuthoredMetersPerUnit(self.stage) else " by USD's default"
            self.notes.append(f"The stage has {units:g} metres per unit{said}; its geometry was converted to mm.")
        if axis == "Y":
            matrix[:3, :3] = matrix[:3, :3] @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
            said = "" if self.stage.HasAuthoredMetadata("upAxis") else " by USD's default"
            self.notes.append(f"The stage has Y up{said}; its geometry was turned to Z up.")
        return None if np.array_equal(matrix, np.eye(4)) else matrix


def _numbers(value: Any) -> NDArray[np.float64] | None:
    try:
        array = np.array(value)
    except (TypeError, ValueError):
        return None
    if array.dtype.kind not in "iuf":
        return None
    return array.astype(np.float64)
