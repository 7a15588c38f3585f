"""Read single values from USD prims, with a `Problem` for every value that is missing or has the wrong type.

`usd` is `lappet.usd.stage.pxr()`; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Point
from lappet.usd.stage_space import StageSpace


class Reader:
    """A reader of single values that collects the problems and notes of one stage.

    Geometry is returned in mm with Z up: `space` takes it there.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    notes
        Gets a note of what was converted or left aside.
    """

    def __init__(self, stage: Any, usd: Any, notes: list[Problem]) -> None:
        self.stage, self.usd, self.notes = stage, usd, notes
        self.problems: list[Problem] = []
        self.space = StageSpace(stage, usd, self.problems, notes)

    def problem(self, code: ProblemCode, path: object, value: object, **fields: Any) -> None:
        """Add an error.

        Parameters
        ----------
        code
            What kind of problem it is.
        path
            Path of the prim.
        value
            What was found.
        **fields
            What else the texts name.
        """
        self.problems.append(problem(code, path, value, **fields))

    def number(self, prim: Any, name: str, default: float | None = None) -> float:
        """Read a number or time code.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.
        default
            Number where nothing is authored; without one it must be authored.

        Returns
        -------
        float
            The number, or NaN where it could not be read.
        """
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
        """Read the samples of an animated number.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.

        Returns
        -------
        tuple[tuple[float, float], ...]
            Samples (time code, number); one at the start where it does not move, none where nothing is authored.
        """
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

    def vector_samples(self, prim: Any, name: str) -> tuple[tuple[float, Point], ...]:
        """Read the samples of an animated vector of three numbers.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.

        Returns
        -------
        tuple[tuple[float, Point], ...]
            Samples (time code, vector); one at the start where it does not move, none where nothing is authored.
        """
        attribute = prim.GetAttribute(name)
        if not (attribute and attribute.HasAuthoredValue()):
            return ()
        times = attribute.GetTimeSamples()
        at = [self.usd.Usd.TimeCode(time) for time in times] or [self.usd.Usd.TimeCode.Default()]
        found: list[tuple[float, Point]] = []
        for time, code in zip(times or [float(self.stage.GetStartTimeCode())], at, strict=True):
            value = _numbers(attribute.Get(code))
            if value is None or value.shape != (3,):
                self._wrong_type(prim, name, attribute.Get(code), "3 numbers")
                return ()
            found.append((float(time), (float(value[0]), float(value[1]), float(value[2]))))
        return tuple(found)

    def text(self, prim: Any, name: str, default: str | None = None) -> str:
        """Read a token or string.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.
        default
            Text where nothing is authored; without one it must be authored.

        Returns
        -------
        str
            The text, empty where it could not be read.
        """
        value = self._value(prim, name, default is None)
        if value is None:
            return default or ""
        if not isinstance(value, str):
            self._wrong_type(prim, name, value, "a token or string")
            return default or ""
        return value

    def texts(self, prim: Any, name: str, default: tuple[str, ...]) -> tuple[str, ...]:
        """Read an array of tokens.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.
        default
            Texts where nothing is authored.

        Returns
        -------
        tuple[str, ...]
            The texts, the default where they could not be read.
        """
        value = self._value(prim, name, False)
        if value is None:
            return default
        if isinstance(value, str) or not all(isinstance(each, str) for each in value):
            self._wrong_type(prim, name, value, "an array of tokens")
            return default
        return tuple(str(each) for each in value)

    def flag(self, prim: Any, name: str, default: bool) -> bool:
        """Read a bool.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.
        default
            Value where nothing is authored.

        Returns
        -------
        bool
            The bool.
        """
        value = self._value(prim, name, False)
        if value is None:
            return default
        if not isinstance(value, (bool, int)):
            self._wrong_type(prim, name, value, "a bool")
            return default
        return bool(value)

    def vector(self, prim: Any, name: str, width: int, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """Read a vector.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.
        width
            How many numbers it has.
        default
            Vector where nothing is authored; without one it must be authored.

        Returns
        -------
        tuple[float, ...]
            The numbers, NaN where they could not be read.
        """
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
        """Read an authored array of 3-vectors.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.

        Returns
        -------
        NDArray[np.float64]
            The vectors, shape (n, 3); none where they could not be read.
        """
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
        """Read an array of integers of a built-in attribute.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.
        optional
            Whether it may be left out.

        Returns
        -------
        NDArray[np.int32]
            The integers, shape (n,); none where they could not be read.
        """
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

    def numbers(self, prim: Any, name: str) -> tuple[float, ...]:
        """Read an array of numbers.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the attribute.

        Returns
        -------
        tuple[float, ...]
            The numbers; none where they could not be read or nothing is authored.
        """
        value = self._value(prim, name, False)
        if value is None:
            return ()
        array = _numbers(value)
        if array is None or array.ndim != 1:
            self._wrong_type(prim, name, value, "an array of numbers")
            return ()
        return tuple(float(each) for each in array)

    def target(self, prim: Any, name: str) -> str:
        """Read a relationship's one target.

        Parameters
        ----------
        prim
            The prim.
        name
            Name of the relationship.

        Returns
        -------
        str
            Path of the target, "" where there is none.
        """
        relationship = prim.GetRelationship(name)
        targets = relationship.GetForwardedTargets() if relationship else []
        if len(targets) > 1:
            found = ", ".join(str(target) for target in targets)
            code = ProblemCode.RELATIONSHIP_TARGETS
            self.problem(code, prim.GetPath(), found, name=name, count=len(targets))
        return str(targets[0]) if targets else ""

    def points(self, prim: Any) -> NDArray[np.float64]:
        """Read the rest points of a mesh, curve or Points prim.

        Parameters
        ----------
        prim
            The prim.

        Returns
        -------
        NDArray[np.float64]
            Points in mm, shape (n, 3).
        """
        return self.space.placed(self.vectors(prim, "points"), prim)

    def _value(self, prim: Any, name: str, required: bool) -> Any:
        attribute = prim.GetAttribute(name)
        value = None
        if attribute and attribute.HasAuthoredValue():
            value = attribute.Get(self.usd.Usd.TimeCode.EarliestTime())
            if attribute.GetNumTimeSamples() > 0 and name.startswith("lappet:"):
                self.notes.append(problem(ProblemCode.ATTRIBUTE_ANIMATED, prim.GetPath(), value, name=name))
        if value is None and required:
            self.problem(ProblemCode.ATTRIBUTE_MISSING, prim.GetPath(), "no value", name=name)
        return value

    def _wrong_type(self, prim: Any, name: str, value: object, wanted: str) -> None:
        shown = " ".join(str(value).split())
        shown = shown if len(shown) <= 40 else shown[:37] + "..."
        self.problem(ProblemCode.ATTRIBUTE_TYPE, prim.GetPath(), shown, name=name, wanted=wanted)


def _numbers(value: Any) -> NDArray[np.float64] | None:
    try:
        array = np.array(value)
    except (TypeError, ValueError):
        return None
    if array.dtype.kind not in "iuf":
        return None
    return array.astype(np.float64)
