"""Read a table of a plan key by key, and collect what is wrong with it as problems with their place and remedy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode


class PlanTable:
    """A table of a plan that is being read.

    Parameters
    ----------
    where
        Where it stands, for problems, such as "lesson.toml, chapter 2".
    values
        Its keys and values.
    problems
        Where problems go.
    """

    def __init__(self, where: str, values: Mapping[str, Any], problems: list[Problem]) -> None:
        self.where, self._values, self._problems = where, values, problems
        self._known: list[str] = []

    def told(self, code: ProblemCode, value: object = "", **fields: object) -> None:
        """Keep a problem of this table.

        Parameters
        ----------
        code
            What kind of problem it is.
        value
            What was found.
        **fields
            What else its texts name.
        """
        self._problems.append(problem(code, self.where, value, place=None, **fields))

    def has(self, key: str) -> bool:
        """Tell whether a key is there.

        Parameters
        ----------
        key
            The key.

        Returns
        -------
        bool
            Whether it is.
        """
        return key in self._values

    def text(self, key: str, needed: bool = False, fallback: str = "") -> str:
        """Read a text.

        Parameters
        ----------
        key
            Its key.
        needed
            Whether it must be there and not be empty.
        fallback
            What it is where it is not there.

        Returns
        -------
        str
            The text without white space around it.
        """
        value = self._take(key, needed)
        if value is None:
            return fallback
        if not isinstance(value, str) or (needed and not value.strip()):
            self._wrong(key, value, "a text in quotes")
            return fallback
        return value.strip()

    def texts(self, key: str) -> tuple[str, ...]:
        """Read a list of texts; one text is a list of one.

        Parameters
        ----------
        key
            Its key.

        Returns
        -------
        tuple[str, ...]
            The texts.
        """
        value = self._take(key, False)
        if value is None:
            return ()
        every = [value] if isinstance(value, str) else value
        if not isinstance(every, list) or not all(isinstance(each, str) and each.strip() for each in every):
            self._wrong(key, value, 'a list of texts, like ["one", "two"]')
            return ()
        return tuple(each.strip() for each in every)

    def choice(self, key: str, known: Sequence[str], fallback: str) -> str:
        """Read one of several words.

        Parameters
        ----------
        key
            Its key.
        known
            The words.
        fallback
            The word where none is there.

        Returns
        -------
        str
            The word.
        """
        value = self._take(key, False)
        if value is None or value in known:
            return fallback if value is None else str(value)
        self._wrong(key, value, f"one of {', '.join(known)}")
        return fallback

    def number(self, key: str, low: float, high: float = math.inf) -> float | None:
        """Read a number.

        Parameters
        ----------
        key
            Its key.
        low, high
            It must lie above `low` and not above `high`.

        Returns
        -------
        float | None
            The number, None where none is there or it is wrong.
        """
        value = self._take(key, False)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low < value <= high:
            most = "" if high == math.inf else f" and at most {high:g}"
            self._wrong(key, value, f"a number above {low:g}{most}")
            return None
        return float(value)

    def whole(self, key: str, low: int, high: int) -> int | None:
        """Read a whole number.

        Parameters
        ----------
        key
            Its key.
        low, high
            The least and the greatest.

        Returns
        -------
        int | None
            The number, None where none is there or it is wrong.
        """
        value = self._take(key, False)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            self._wrong(key, value, f"a whole number from {low} to {high}")
            return None
        return value

    def numbers(self, key: str) -> tuple[float, ...] | None:
        """Read a list of numbers.

        Parameters
        ----------
        key
            Its key.

        Returns
        -------
        tuple[float, ...] | None
            The numbers, None where none are there or they are wrong.
        """
        value = self._take(key, False)
        if value is None:
            return None
        plain = isinstance(value, list) and all(isinstance(each, (int, float)) for each in value)
        if not plain or not value or any(isinstance(each, bool) for each in value):
            self._wrong(key, value, "a list of numbers, like [1, 7, 20]")
            return None
        return tuple(float(each) for each in value)

    def whole_numbers(self, key: str) -> tuple[tuple[int, ...], bool]:
        """Read a whole number or a list of them.

        Parameters
        ----------
        key
            Its key.

        Returns
        -------
        tuple[tuple[int, ...], bool]
            The numbers, empty where none are there or they are wrong, and whether they are a list.
        """
        value = self._take(key, False)
        if value is None:
            return (), False
        every = value if isinstance(value, list) else [value]
        if any(isinstance(each, bool) or not isinstance(each, int) for each in every):
            self._wrong(key, value, "the number of the right choice, or a list of the numbers of all right ones")
            return (), False
        return tuple(every), isinstance(value, list)

    def tables(self, key: str) -> list[PlanTable]:
        """Read a list of tables.

        Parameters
        ----------
        key
            Its key.

        Returns
        -------
        list[PlanTable]
            The tables, each with its number in the place that problems name.
        """
        value = self._take(key, False)
        if value is None:
            return []
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            self._wrong(key, value, f"tables under headings like [[{key}]]")
            return []
        return [PlanTable(f"{self.where}, {key} {k}", each, self._problems) for k, each in enumerate(value, 1)]

    def done(self) -> None:
        """Report keys that nothing read."""
        for key in self._values:
            if key not in self._known:
                self.told(ProblemCode.LESSON_KEY, key, known=", ".join(self._known))

    def _take(self, key: str, needed: bool) -> Any:
        self._known.append(key)
        if needed and key not in self._values:
            self.told(ProblemCode.LESSON_MISSING, key)
        return self._values.get(key)

    def _wrong(self, key: str, value: object, wanted: str) -> None:
        self.told(ProblemCode.LESSON_VALUE, repr(value), key=key, wanted=wanted)
