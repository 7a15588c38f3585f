"""An epoch costs what its surface is worth, and ends within a moment when it is not wanted or takes too long."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from box_scene import box, epoch_arrays, open_fields
from lappet.daemon.process import SolverDaemon
from raw_peer import Raw

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]

LARGE = (160.0, 160.0, 20.0)  # mm; half a million cells
MOMENT = 0.2  # s


@pytest.fixture
def peer(binary: Path) -> Iterator[Raw]:
    with SolverDaemon(binary) as daemon, contextlib.closing(Raw(daemon)) as raw:
        yield raw


def told(size: tuple[float, float, float], **changes: Any) -> dict[str, Any]:
    return epoch_arrays(points=box(size).points, **changes)


def seconds_of_epoch(peer: Raw, size: tuple[float, float, float], **changes: Any) -> float:
    start = time.monotonic()
    peer.send("epoch", {"index": 0}, told(size, **changes))
    reply = peer.receive(100.0)
    assert reply.type == "lattice", reply.fields
    return time.monotonic() - start


def test_a_long_face_costs_what_its_area_is_worth(peer: Raw) -> None:
    """Twelve triangles of 2 m, held, gripped and above bone: with samples by the longest edge they took minutes."""
    surface = box((2000.0, 3.0, 3.0))
    bone = {"bone_points": surface.points - [0.0, 0.0, 8.0], "bone_triangles": surface.triangles}
    assert peer.ask("open", open_fields(retractors=1), bone).type == "opened"
    grip = np.full(12, -1, np.int32)
    grip[10:] = 0
    assert seconds_of_epoch(peer, (2000.0, 3.0, 3.0), grip=grip) < 20.0


def test_a_cancelled_epoch_ends_within_a_moment_wherever_it_is(peer: Raw) -> None:
    assert peer.ask("open", open_fields(memory_budget=8 << 30, threads=0)).type == "opened"
    whole = seconds_of_epoch(peer, LARGE)
    waits = []
    for part in np.linspace(0.05, 0.9, 18):
        epoch = peer.send("epoch", {"index": 1}, told(LARGE))
        time.sleep(part * whole)
        start = time.monotonic()
        cancel = peer.send("cancel")
        replies = {reply.id: reply for reply in (peer.receive(60.0), peer.receive(60.0))}
        assert replies[cancel].type == "accepted"
        if replies[epoch].type == "error":
            assert replies[epoch].fields["code"] == "cancelled"
            waits.append(time.monotonic() - start)
    print("waits", np.round(sorted(waits), 3), "of", round(whole, 2))
    assert len(waits) > 9
    assert np.median(waits) < MOMENT
    assert max(waits) < MOMENT + 0.1 * whole  # a busy machine is as much slower in both
    assert peer.ask("solve", {"time": 1.0}, {}).type == "error"  # malformed, but the session is there
    assert peer.ask("ping").type == "pong"


def test_an_epoch_ends_after_ten_time_budgets_and_the_next_is_taken(peer: Raw) -> None:
    assert peer.ask("open", open_fields(memory_budget=8 << 30, threads=0, time_budget=0.03)).type == "opened"
    start = time.monotonic()
    peer.send("epoch", {"index": 0}, told(LARGE))
    reply = peer.receive(60.0)
    assert reply.fields["code"] == "time_budget", reply.fields
    assert "longer than 0.3 s" in reply.fields["message"]
    assert time.monotonic() - start < 0.3 + 5.0 * MOMENT
    assert peer.ask("epoch", {"index": 0}, told((4.0, 4.0, 2.0))).type == "lattice"


@pytest.mark.parametrize("seconds", [1e10, 1e308])
def test_a_budget_that_no_clock_counts_ends_no_epoch(peer: Raw, seconds: float) -> None:
    assert peer.ask("open", open_fields(time_budget=seconds)).type == "opened"
    assert peer.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
