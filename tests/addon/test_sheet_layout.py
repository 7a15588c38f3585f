"""How the panels of a filmstrip lie on their sheet."""

from __future__ import annotations

import pytest

from lappet_blender.figure.sheet_layout import columns_for, sheet_layout


@pytest.mark.parametrize("count", range(1, 7))
def test_panels_of_a_sheet_lie_inside_it_and_do_not_overlap(count: int) -> None:
    (width, height), corners, caption = sheet_layout(count, (640, 480))
    assert len(corners) == count
    assert columns_for(count) <= 3
    for k, (x, y) in enumerate(corners):
        assert x >= 0
        assert x + 640 <= width
        assert y + 480 + caption <= height
        for u, v in corners[:k]:
            assert abs(x - u) >= 640 or abs(y - v) >= 480 + caption
