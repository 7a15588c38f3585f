"""Flaps that are folded at random onto what lies around them never pass through tissue with self-contact."""

from __future__ import annotations

from foldings import foldings, random_folding


def test_no_frame_of_random_foldings_passes_through_itself() -> None:
    found = foldings(seed=2, count=5)
    assert found.through == []
    assert found.unexplained == []
    assert found.foldings == 5
    assert found.frames > 20
    assert found.touching > 0.4 * found.frames  # something was there to be kept apart


def test_a_seed_makes_one_folding_and_others_make_others() -> None:
    assert random_folding(7) == random_folding(7)
    assert len({len(random_folding(seed).events) for seed in range(20)}) > 2
    assert random_folding(7) != random_folding(8)
