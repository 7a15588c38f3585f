"""Copies solved frames from one store to another when a scene keeps its frames elsewhere from now on."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Iterable
from pathlib import Path

from lappet.background.plan import Plan
from lappet.solve.store import FrameStore


class FrameCopy:
    """Copies the frames, surfaces and plans of some plans, on a thread. done: it has ended; trouble: why it stopped
    before all was copied, a sentence, or ""."""

    def __init__(self, plans: Iterable[Plan], old: FrameStore, new: FrameStore) -> None:
        keys: dict[str, None] = {}
        for plan in plans:
            each = (plan.key, *(epoch.key for epoch in plan.epochs), *(frame.key for frame in plan.frames))
            keys.update(dict.fromkeys(each))
        self.trouble = ""
        self._pairs = [(old.path(key), new.path(key)) for key in keys]
        self._folder = new.folder
        self._thread = threading.Thread(target=self._copy_all, name="lappet copying", daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return not self._thread.is_alive()

    def _copy_all(self) -> None:
        try:
            for source, target in self._pairs:
                if source.is_file() and not target.is_file():
                    _copy(source, target)
        except OSError as error:
            self.trouble = (
                f"Solved frames cannot be kept in {self._folder} ({error.strerror or error}); free some space there, "
                "or switch off Beside the .blend, in the Settings of Solve."
            )


def _copy(source: Path, target: Path) -> None:
    """A file appears whole or not at all."""
    target.parent.mkdir(parents=True, exist_ok=True)
    writing = target.with_name(f".writing-{target.name}")
    try:
        shutil.copyfile(source, writing)
        writing.replace(target)
    except OSError:
        writing.unlink(missing_ok=True)
        raise
