"""Manifests made in this session, by key, for undo and redo, and what is known of their frames."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace

from lappet.background.assessment import Assessment
from lappet.background.manifest import EpochShape, Manifest
from lappet.core.problem import Problem
from lappet.solve.store import FrameStore

LIMIT = 64


class ManifestMemory:
    """The manifests and refusals used last, and why frames failed. Equal epochs are one object in all manifests."""

    def __init__(self, limit: int = LIMIT) -> None:
        self.failures: dict[str, Problem] = {}  # by frame key: why it failed
        self.assessments: dict[str, Assessment] = {}  # by manifest key: what is to be known of its frames
        self._limit = limit
        self._manifests: OrderedDict[str, Manifest] = OrderedDict()
        self._refused: OrderedDict[str, tuple[Problem, ...]] = OrderedDict()

    def keep(self, manifest: Manifest, key: str = "") -> Manifest:
        """Keep a manifest, under its key and under that it was asked for with; return it with epochs shared."""
        known = self._epochs()
        epochs: tuple[EpochShape, ...] = tuple(
            known.get((epoch.key, epoch.start_time), epoch) for epoch in manifest.epochs
        )
        manifest = replace(manifest, epochs=epochs)
        for each in dict.fromkeys((manifest.key, key or manifest.key)):
            self._manifests[each] = manifest
            self._manifests.move_to_end(each)
            self._refused.pop(each, None)
        while len(self._manifests) > self._limit:
            self._manifests.popitem(last=False)
        return manifest

    def find(self, key: str, store: FrameStore) -> Manifest | None:
        """The manifest of a key, from memory or from the store."""
        manifest = self._manifests.get(key)
        if manifest is not None:
            self._manifests.move_to_end(key)
            return manifest
        from lappet.background.manifest_store import get_manifest

        stored = get_manifest(store, key, {name: epoch for (name, _), epoch in self._epochs().items()})
        return None if stored is None else self.keep(stored, key)

    def refuse(self, key: str, problems: tuple[Problem, ...]) -> None:
        """Remember why the procedure of a key is refused."""
        self._refused[key] = problems
        while len(self._refused) > self._limit:
            self._refused.popitem(last=False)

    def refused(self, key: str) -> tuple[Problem, ...] | None:
        """Why the procedure of a key is refused, or None."""
        return self._refused.get(key)

    def drop(self, key: str) -> None:
        """Drop the manifest and the refusal of a key, so that it is asked for again."""
        self._manifests.pop(key, None)
        self._refused.pop(key, None)

    def clear(self) -> None:
        """Drop everything."""
        self._manifests.clear()
        self._refused.clear()
        self.failures.clear()
        self.assessments.clear()

    def _epochs(self) -> dict[tuple[str, float], EpochShape]:
        return {(epoch.key, epoch.start_time): epoch for each in self._manifests.values() for epoch in each.epochs}
