"""Numbers that are finite and far beyond any tissue are refused, wherever a message holds them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from box_scene import box, epoch_arrays, open_fields, pull
from lappet.daemon.wire import Message
from lappet.program.payloads import solve_payload
from raw_peer import Raw

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]

FAR = (2e8, -1e20, 1e155, -1e300)
CLOSING = 0.5


def solve_arrays(**changes: Any) -> dict[str, NDArray[Any]]:
    """A hook, a suture that closes exactly, a thread over three anchors and a retractor."""
    return {
        **solve_payload(pull()).arrays,
        "suture_index": np.array([0, 1], np.int32),
        "suture_anchors": np.array([[[1.0, 1.0, 2.0], [3.0, 1.0, 2.0]], [[1.0, 3.0, 2.0], [3.0, 3.0, 2.0]]]),
        "suture_triangles": np.full((2, 2), 10, np.int32),
        "suture_closure": np.full(2, CLOSING),
        "suture_stiffness": np.full(2, 20.0),
        "suture_is_thread": np.array([0, 1], np.uint8),
        "suture_length": np.array([0.0, 1.0]),
        "suture_tension": np.zeros(2),
        "suture_inner_bites": np.array([0, 1], np.int32),
        "inner_bite_anchors": np.array([[2.0, 3.0, 2.0]]),
        "inner_bite_triangles": np.array([10], np.int32),
        "retractor_index": np.array([0], np.int32),
        "retractor_motion": np.eye(4)[None],
        **changes,
    }


def gripped(**changes: Any) -> dict[str, NDArray[Any]]:
    """The box with landmarks, a skin, a ground under an undermined face, and a retractor at a side of it."""
    surface = box()
    support, grip = np.zeros(12, np.uint8), np.full(12, -1, np.int32)
    support[10], grip[0] = 2, 0
    extra = {
        "support": support,
        "grip": grip,
        "landmarks": np.array([[2.0, 2.0, 2.0]]),
        "landmark_triangles": np.array([10], np.int32),
        "ground_points": np.array([[0.0, 0.0, 2.0], [4.0, 0.0, 2.0], [4.0, 4.0, 2.0]]),
        "ground_triangles": np.array([[0, 2, 1]], np.int32),
        "skin_points": surface.points,
        "skin_triangles": surface.triangles,
        "skin_directions": np.tile([1.0, 0.0, 0.0], (8, 1)),
    }
    return epoch_arrays(**{**extra, **changes})


def with_number(array: NDArray[Any], number: float) -> NDArray[Any]:
    changed = array.copy()
    with np.errstate(over="ignore"):  # in single precision the largest are infinite
        changed.reshape(-1)[0] = number
    return changed


def refusal(raw: Raw, kind: str, fields: dict[str, Any], arrays: dict[str, Any]) -> Message:
    reply = raw.ask(kind, fields, arrays)
    assert reply.type == "error", (kind, reply.type)
    assert reply.fields["code"] == "invalid_input", reply.fields
    return reply


@pytest.mark.parametrize("number", FAR)
def test_coordinates_of_an_epoch_are_bounded(raw: Raw, number: float) -> None:
    assert raw.ask("open", open_fields(retractors=1)).type == "opened"
    for name in ("points", "landmarks", "ground_points", "skin_points", "skin_directions"):
        refusal(raw, "epoch", {"index": 0}, gripped(**{name: with_number(gripped()[name], number)}))
    assert raw.ask("epoch", {"index": 0}, gripped()).type == "lattice"


@pytest.mark.parametrize("number", FAR)
def test_coordinates_of_a_frame_and_of_a_state_are_bounded(raw: Raw, number: float) -> None:
    assert raw.ask("open", open_fields(retractors=1)).type == "opened"
    assert raw.ask("epoch", {"index": 0}, gripped()).type == "lattice"
    before = raw.ask("solve", {"time": 1.0}, solve_arrays())
    assert before.type == "frame"
    for name in (
        "hook_anchors", "hook_targets", "suture_anchors", "suture_length", "inner_bite_anchors", "retractor_motion"
    ):  # fmt: skip
        refusal(raw, "solve", {"time": 2.0}, solve_arrays(**{name: with_number(solve_arrays()[name], number)}))
    state = {
        name: before.arrays[name]
        for name in (
            "nodes", "suture_separations", "suture_multipliers", "grip_multipliers", "activation", "stability"
        )
    }  # fmt: skip
    for name in ("nodes", "suture_separations"):
        refusal(raw, "state", {"precision": "float"}, {**state, name: with_number(state[name], number)})
    after = raw.ask("solve", {"time": 1.0}, solve_arrays())
    assert after.fields["converged"]
    assert np.isfinite(after.arrays["points"]).all()


@pytest.mark.parametrize("number", FAR)
def test_coordinates_of_a_session_are_bounded(raw: Raw, number: float) -> None:
    surface = box()
    bones = {"bone_points": with_number(surface.points - [0.0, 0.0, 9.0], number), "bone_triangles": surface.triangles}
    refusal(raw, "open", open_fields(), bones)
    refusal(raw, "open", open_fields(spacing=abs(number)), {})
    refusal(raw, "open", open_fields(origin=[0.0, number, 0.0]), {})
    assert raw.ask("open", open_fields()).type == "opened"


@pytest.mark.parametrize("away", [20.0, 1e4, 1e8])
def test_an_anchor_that_no_tissue_is_near_refusal(raw: Raw, away: float) -> None:
    """The box is 6 mm from corner to corner; its trilinear functions grow with the third power of the distance."""
    assert raw.ask("open", open_fields(retractors=1)).type == "opened"
    refusal(raw, "epoch", {"index": 0}, gripped(landmarks=np.array([[0.0, away, 0.0]])))
    assert raw.ask("epoch", {"index": 0}, gripped()).type == "lattice"
    for name in ("hook_anchors", "suture_anchors", "inner_bite_anchors"):
        reply = raw.ask("solve", {"time": 1.0}, solve_arrays(**{name: with_number(solve_arrays()[name], away)}))
        assert "farther from the tissue than the tissue is large" in reply.fields["message"], name
    assert raw.ask("solve", {"time": 1.0}, solve_arrays()).fields["converged"]
