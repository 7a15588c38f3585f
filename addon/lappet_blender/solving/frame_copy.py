"""Copy solved frames from one store to another when a scene keeps its frames elsewhere from now on."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Iterable
from pathlib import Path

from lappet.background.manifest import Manifest
from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.solve.store import FrameStore


class FrameCopy:
    """A copy of the frames, surfaces and manifests of some manifests, made on a thread.

    done: it has ended; problem: why it stopped before all was copied, or None.
    """

    def __init__(self, manifests: Iterable[Manifest], old: FrameStore, new: FrameStore) -> None:
        keys: dict[str, None] = {}
        for manifest in manifests:
            each = (manifest.key, *(epoch.key for epoch in manifest.epochs), *(frame.key for frame in manifest.frames))
            keys.update(dict.fromkeys(each))
        self.problem: Problem | None = None
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
            self.problem = problem(ProblemCode.FRAMES_NOT_COPIED, self._folder, error.strerror or error)


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
