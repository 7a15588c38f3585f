"""Sheets of the models, each made once for all tests of a run: many operations are drawn on one model."""

from __future__ import annotations

import fcntl
import hashlib
import os
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.models.body_surface import BodySurface
from lappet.models.model_sheet import model_sheet
from lappet.procedure import Tissue


class KeptSheets:
    """Stands for `model_sheet`: it makes a sheet, or reads what this or another worker of the run made of the same.

    folder: of this run, which all its workers know.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(exist_ok=True)

    def sheet(self, skin: BodySurface, around: BodySurface, thickness: float, spacing: float, name: str) -> Tissue:
        digest = hashlib.sha256(f"{name} {thickness!r}".encode())
        for array in (skin.points, skin.triangles, around.points, around.triangles):
            digest.update(np.ascontiguousarray(array).tobytes())
        kept = self._folder / f"{digest.hexdigest()}.pickle"
        with _alone(kept.with_suffix(".lock")):
            if not kept.exists():
                kept.write_bytes(pickle.dumps(model_sheet(skin, around, thickness, spacing, name)))
        made: Tissue = pickle.loads(kept.read_bytes())
        return replace(made, spacing=spacing)  # which nothing else of it depends on


@contextmanager
def _alone(lock: Path) -> Iterator[None]:
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session", autouse=True)
def kept_sheets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    own = tmp_path_factory.getbasetemp()  # with several workers a folder in that of the run
    kept = KeptSheets((own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "kept_sheets")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lappet.models.body_model.model_sheet", kept.sheet)
        yield
