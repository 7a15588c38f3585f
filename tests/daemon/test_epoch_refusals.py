"""A refused epoch leaves nothing behind, however late it fails: the session goes on as if it had not come."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from box_scene import box, epoch_arrays, open_fields, pull
from lappet.daemon.process import SolverDaemon
from lappet.daemon.wire import Message
from lappet.program.payloads import solve_payload
from raw_peer import Raw

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]

BUDGET = 1 << 20  # bytes; a lattice of the small boxes needs a tenth of it


def opened(daemon: SolverDaemon) -> Raw:
    """A peer with a session whose bone lies far below the tissue."""
    peer = Raw(daemon)
    surface = box((40.0, 40.0, 4.0))
    bone = {"bone_points": surface.points - [18.0, 18.0, 10.0], "bone_triangles": surface.triangles}
    assert peer.ask("open", open_fields(memory_budget=BUDGET, bed_stiffness=0.0, bed_shear=0.0), bone).type == "opened"
    return peer


def told(size: tuple[float, float, float], below: float = 0.0) -> dict[str, NDArray[Any]]:
    return epoch_arrays(points=box(size).points - [0.0, 0.0, below])


def solved(peer: Raw, time: float, by: float) -> Message:
    reply = peer.ask("solve", {"time": time}, solve_payload(pull(time, by)).arrays)
    assert reply.type == "frame", reply.fields
    assert reply.fields["converged"]
    return reply


def test_epochs_that_fail_early_and_late_leave_the_session_as_it_was(daemon: SolverDaemon) -> None:
    with contextlib.closing(opened(daemon)) as disturbed, contextlib.closing(opened(daemon)) as alone:
        for peer in (disturbed, alone):
            assert peer.ask("epoch", {"index": 0}, told((4.0, 4.0, 2.0))).type == "lattice"
            solved(peer, 1.0, 0.2)
        refusals = {
            "memory_budget": told((400.0, 400.0, 20.0)),  # before anything is built
            "invalid_input": told((4.0, 4.0, 2.0), below=7.0),  # once all is built: the tissue lies in bone
        }
        for code, arrays in refusals.items():
            reply = disturbed.ask("epoch", {"index": 1}, arrays)
            assert (reply.type, reply.fields["code"]) == ("error", code), reply.fields
            assert solved(disturbed, 2.0, 0.4).arrays["points"].shape == (8, 3)
        solved(alone, 2.0, 0.4)
        solved(alone, 2.0, 0.4)
        for code, arrays in refusals.items():
            assert disturbed.ask("epoch", {"index": 1}, arrays).fields["code"] == code
        for peer in (disturbed, alone):
            assert peer.ask("epoch", {"index": 2}, told((3.0, 3.0, 2.0))).type == "lattice"
        expected, found = solved(alone, 3.0, 0.1), solved(disturbed, 3.0, 0.1)
        for name, array in expected.arrays.items():
            np.testing.assert_array_equal(found.arrays[name], array, err_msg=name)
