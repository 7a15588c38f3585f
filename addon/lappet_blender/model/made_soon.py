"""A value that is made on a thread of its own, while Blender answers its user."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

Made = TypeVar("Made")


class MadeSoon(Generic[Made]):
    """make: touches nothing of Blender's. What it raises, `take` raises."""

    def __init__(self, make: Callable[[], Made]) -> None:
        self._make = make
        self._made: list[Made] = []
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="lappet making", daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether it is made, or will never be."""
        return not self._thread.is_alive()

    def take(self) -> Made:
        """The value, waited for."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._made[0]

    def _run(self) -> None:
        try:
            self._made.append(self._make())
        except Exception as error:
            self._error = error
