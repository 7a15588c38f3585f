"""A file plays as the cache does, with pauses."""

from __future__ import annotations

from lappet.export.play_times import Shown, play_times


def test_steps_and_the_last_frame_are_held_and_what_follows_comes_later() -> None:
    assert play_times((3.0, 4.0, 6.0, 7.0), {4.0}, 10.0) == [
        Shown(3.0, 0.0, 0.0),
        Shown(4.0, 1.0, 11.0),
        Shown(6.0, 13.0, 13.0),
        Shown(7.0, 14.0, 24.0),
    ]


def test_without_a_pause_times_are_those_of_the_cache() -> None:
    assert [each.begin for each in play_times((1.0, 2.0, 5.0), {2.0}, 0.0)] == [0.0, 1.0, 4.0]
