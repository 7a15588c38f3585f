"""The force on each bite of a thread: one tension along both pieces that meet there."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.daemon.solved_frame import SolvedFrame
from lappet.solve.bite_forces import bite_forces, bite_points


def frame(*threads: list[tuple[float, float, float]], tension: tuple[float, ...]) -> SolvedFrame:
    inner = [len(thread) - 2 for thread in threads]
    return SolvedFrame(
        1.0,
        np.zeros((0, 3), np.float32),
        suture_index=np.arange(len(threads), dtype=np.int32),
        suture_points=np.array([[thread[0], thread[-1]] for thread in threads]),
        suture_forces=np.array(tension),
        suture_inner_bites=np.array(inner if any(inner) else [], np.int32),
        inner_bite_points=np.array([point for thread in threads for point in thread[1:-1]]).reshape(-1, 3),
    )


def test_the_bites_of_each_thread_come_in_its_order() -> None:
    first, second, third = [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(5, 5, 5), (6, 6, 6)], [(0, 1, 0), (0, 2, 0), (0, 3, 0)]
    points = bite_points(frame(first, second, third, tension=(1.0, 1.0, 1.0)))
    assert [each.tolist() for each in points] == [[list(map(float, p)) for p in t] for t in (first, second, third)]
    assert bite_points(frame(tension=())) == []


def test_two_bites_pull_with_the_force_of_the_suture_also_where_they_meet() -> None:
    (forces,) = bite_forces(frame([(1, 2, 3), (1, 2, 3)], tension=(70.0,)))
    assert forces.tolist() == [70.0, 70.0]


def test_a_thread_pulls_by_how_far_it_turns() -> None:
    # straight on, by a right angle, back
    thread = [(0, 0, 0), (4, 0, 0), (9, 0, 0), (9, 3, 0), (9, 1, 0)]
    (forces,) = bite_forces(frame(thread, tension=(10.0,)))
    assert forces == pytest.approx([10.0, 0.0, 10.0 * np.sqrt(2.0), 20.0, 10.0], abs=1e-5)


def test_where_a_loop_is_tied_both_its_ends_pull() -> None:
    square = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (0, 0, 0)]
    (forces,) = bite_forces(frame(square, tension=(10.0,)))
    assert forces == pytest.approx([10.0 * np.sqrt(2.0)] * 5, abs=1e-5)
