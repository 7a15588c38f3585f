"""The sheets that the tests of a run share are those that models have."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kept_sheets import KeptSheets
from lappet.models import body_model
from lappet.models.model_choice import ModelChoice
from lappet.models.model_sheet import model_sheet
from lappet.models.new_model import new_model


def test_a_kept_sheet_is_the_one_that_is_made_whatever_its_spacing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(body_model, "model_sheet", model_sheet)
    made = new_model("chin", ModelChoice(scenery=False))
    monkeypatch.setattr(body_model, "model_sheet", KeptSheets(tmp_path / "sheets").sheet)
    first, again = (new_model("chin", ModelChoice(scenery=False, spacing=spacing)) for spacing in (3.0, None))
    assert len(list((tmp_path / "sheets").glob("*.pickle"))) == 1
    assert again == made
    np.testing.assert_array_equal(again.tissue.uv, made.tissue.uv)
    assert replace(first.tissue, spacing=made.tissue.spacing) == made.tissue
