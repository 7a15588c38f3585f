"""Dashes of a line that closes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from lappet.drawing.dashed_line import DASH, GAP, dashes


def test_an_undermined_area_is_marked_in_dashes_that_close_evenly() -> None:
    turn = np.linspace(0.0, 2 * np.pi, 181)
    circle = 20.0 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    parts = dashes(circle)
    around = 2 * np.pi * 20.0
    assert len(parts) == round(around / (DASH + GAP))
    length = sum(float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum()) for part in parts)
    assert length == pytest.approx(around * DASH / (DASH + GAP), rel=0.01)
    gaps = [np.linalg.norm(b[0] - a[-1]) for a, b in pairwise([*parts, parts[0]])]
    np.testing.assert_allclose(gaps, GAP, rtol=0.05)
