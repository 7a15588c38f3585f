"""Fixtures of the tests of solving: a worker of formulas that the test drives, and the scene that it solves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import pytest

import fake_worker
from fake_worker import Script
from lappet_blender.solving import controller, reconcile, speed_estimate, workers
from patch_scene import make_patch_scene


@pytest.fixture
def own_store(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A store and memories of the test's own; no worker outlives it."""
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "store"))
    monkeypatch.setattr(speed_estimate, "_speed_estimate", None)
    controller.drop_all()
    controller.frame_cache.clear()
    controller.manifests.clear()
    yield tmp_path / "store"
    controller.drop_all()
    workers.close_all()


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch, own_store: Path) -> Script:
    """What the workers of formulas do."""
    made = Script()
    monkeypatch.setattr(workers, "create", made.create)
    monkeypatch.setattr(reconcile, "identity", lambda: fake_worker.IDENTITY)
    return made


@pytest.fixture
def patch(scene: bpy.types.Scene, script: Script) -> bpy.types.Scene:
    """The patch scene, unsolved."""
    return make_patch_scene(scene)
