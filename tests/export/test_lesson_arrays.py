"""Arrays of a lesson come back as they were, positions as near as a hundredth of a millimeter, in little space."""

from __future__ import annotations

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.export.lesson_arrays import STEP, LessonArrays
from lesson_reader import numbers, positions

HALF_DIAGONAL = np.sqrt(3.0) / 2.0


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
@pytest.mark.parametrize("back", [1, 7, 1000])
def test_numbers_come_back_whatever_they_are(kind: type, back: int) -> None:
    most = np.iinfo(kind).max
    values = np.random.default_rng(5).integers(0, most, 500, dtype=kind, endpoint=True)
    values[:4] = [0, most, 0, most]
    arrays = LessonArrays()
    arrays.add(values[:3])
    entry = arrays.add(values, back)
    block = b"".join(arrays._parts)
    assert len(block) == arrays.size
    np.testing.assert_array_equal(numbers(block, entry), values)


def test_an_array_without_numbers_comes_back() -> None:
    arrays = LessonArrays()
    assert len(numbers(b"", arrays.add(np.zeros(0, np.uint16)))) == 0


@pytest.mark.parametrize("extent", [1.0, 300.0, 2000.0])
def test_positions_come_back_within_half_a_step(extent: float) -> None:
    tracks = np.random.default_rng(3).uniform(-extent / 2, extent / 2, (4, 50, 3))
    arrays = LessonArrays()
    entry = arrays.positions(tracks)
    off = np.linalg.norm(positions(b"".join(arrays._parts), entry) - tracks, axis=2).max()
    assert off <= HALF_DIAGONAL * entry["step"] * (1 + 1e-9)
    assert off < 0.05
    assert entry["step"] == pytest.approx(max(STEP, np.ptp(tracks.reshape(-1, 3), axis=0).max() / 65535))


def test_forty_frames_of_twenty_thousand_vertices_take_less_than_five_megabytes() -> None:
    rest, _, _ = synthetic.patch(0.9, True)
    assert 19_000 < len(rest) < 22_000
    times = np.linspace(synthetic.INCISED, synthetic.SUTURED, 40)
    noise = np.random.default_rng(1).normal(0.0, 0.02, (40, len(rest), 3))  # rougher than any solved skin
    arrays = LessonArrays()
    arrays.positions(np.stack([synthetic.deform(rest, time, True) for time in times]) + noise)
    arrays.add(np.random.default_rng(2).integers(0, 40, (40, len(rest) // 2), np.uint8), len(rest) // 2)
    in_base64 = len(arrays.block()) * 4 / 3
    assert in_base64 < 5e6
