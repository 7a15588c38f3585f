"""Manifests in the frame store: they are found again without compiling, after an undo or when a file is opened."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lappet.background.manifest import EpochShape, Manifest
from lappet.solve.store import FrameStore


@dataclass(frozen=True, eq=False)
class StoredManifest:
    """A manifest whose epochs lie under keys of their own, since many manifests share them.

    Parameters
    ----------
    manifest
        The manifest without epochs.
    epochs
        Key and start time of each epoch.
    """

    manifest: Manifest
    epochs: tuple[tuple[str, float], ...]


def put_manifest(store: FrameStore, manifest: Manifest) -> bool:
    """Keep a manifest: the surfaces of its epochs that are not there yet, then the manifest itself.

    Parameters
    ----------
    store
        The store.
    manifest
        The manifest.

    Returns
    -------
    bool
        Whether the disk took it (`FrameStore.trouble`).
    """
    for epoch in manifest.epochs:
        if epoch.key not in store and not store.put(epoch.key, epoch):
            return False
    epochs = tuple((epoch.key, epoch.start_time) for epoch in manifest.epochs)
    return store.put(manifest.key, StoredManifest(replace(manifest, epochs=()), epochs))


def get_manifest(store: FrameStore, key: str, shapes: dict[str, EpochShape] | None = None) -> Manifest | None:
    """Look up a manifest.

    Parameters
    ----------
    store
        The store.
    key
        Key of the manifest.
    shapes
        Surfaces that the caller holds, by key; they are not read again, and what is read is added.

    Returns
    -------
    Manifest | None
        The manifest, or None where it or one of its surfaces is not there (any more).
    """
    stored = store.get(key, StoredManifest)
    if stored is None:
        return None
    held = {} if shapes is None else shapes
    epochs = []
    for name, start in stored.epochs:
        shape = held.get(name) or store.get(name, EpochShape)
        if shape is None:
            return None
        held[name] = shape if shape.start_time == start else replace(shape, start_time=start)
        epochs.append(held[name])
    return replace(stored.manifest, epochs=tuple(epochs))
