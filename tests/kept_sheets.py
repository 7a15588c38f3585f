"""Sheets of the models, each made once for all tests of a run: many operations are drawn on one model."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from folder_of_run import alone, folder_of_run
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
        with alone(kept.with_suffix(".lock")):
            if not kept.exists():
                kept.write_bytes(pickle.dumps(model_sheet(skin, around, thickness, spacing, name)))
        made: Tissue = pickle.loads(kept.read_bytes())
        return replace(made, spacing=spacing)  # which nothing else of it depends on


@pytest.fixture(scope="session", autouse=True)
def kept_sheets(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    kept = KeptSheets(folder_of_run(tmp_path_factory, "kept_sheets"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lappet.models.body_model.model_sheet", kept.sheet)
        yield
