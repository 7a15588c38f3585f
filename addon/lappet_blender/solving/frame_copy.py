"""Copy solved frames from one store to another when a scene keeps its frames elsewhere from now on."""

from __future__ import annotations

import threading
from collections.abc import Iterable

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
        self._keys, self._old, self._new = list(keys), old, new
        self._thread = threading.Thread(target=self._copy_all, name="lappet copying", daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return not self._thread.is_alive()

    def _copy_all(self) -> None:
        for key in self._keys:
            if key in self._old and key not in self._new and not self._old.copy(key, self._new) and self._new.trouble:
                self.problem = problem(ProblemCode.FRAMES_NOT_COPIED, self._new.folder, self._new.trouble.value)
                return
