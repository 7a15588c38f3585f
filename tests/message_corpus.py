"""The corpus of messages: what a client may say, once each, and what was found to harm a daemon.

`python tests/message_corpus.py` writes `tests/daemon/corpus/*.messages`; `solverd_fuzz` and
`test_message_corpus` play them.
A file holds what one client sends, in order, as `solverd/fuzz/conversation.h` says. Its name is that of its function
here, whose docstring says what it is for. Findings of campaigns are files `found_*.messages` beside them, with a line
each in `tests/daemon/corpus/README.md`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from box_scene import box, epoch_arrays, pull
from corpus_messages import (
    EPOCH,
    NODES,
    OPEN,
    SOLVE,
    RawMessage,
    changed,
    everything_epoch,
    everything_epoch_arrays,
    everything_open,
    everything_solve_arrays,
    file_of,
    message,
    session_fields,
    state,
)
from lappet.program.payloads import solve_payload

FOLDER = Path(__file__).parent / "daemon" / "corpus"

CONVERSATIONS: dict[str, Callable[[], list[RawMessage]]] = {}


def conversation(make: Callable[[], list[RawMessage]]) -> Callable[[], list[RawMessage]]:
    """Name a conversation after its function."""
    CONVERSATIONS[make.__name__] = make
    return make


@conversation
def greeting() -> list[RawMessage]:
    """What needs no session: `hello`, `ping`, `cancel`, `bye`; a name that would clear a terminal."""
    name = "a\x1b[2J\x07\r\n\x00b"
    return [message("hello", {"token": "no", "client": name}), message("ping"), message("cancel"), message("bye")]


@conversation
def end() -> list[RawMessage]:
    """`shutdown`."""
    return [message("ping"), message("shutdown")]


@conversation
def pulled_box() -> list[RawMessage]:
    """The smallest session: `open`, `epoch`, `solve`, `state`, `close`."""
    return [OPEN, EPOCH, SOLVE, state(), SOLVE, message("close")]


@conversation
def everything() -> list[RawMessage]:
    """Every field and every array that a message may have, in double precision."""
    solve = message("solve", {"time": 2.0}, everything_solve_arrays())
    return [everything_open(), everything_epoch(), solve, everything_epoch(1), solve, message("close")]


@conversation
def whole_tissue() -> list[RawMessage]:
    """Float, Chebyshev, another model and eight points in a cell; a second epoch takes the state over."""
    fields = session_fields(preconditioner="chebyshev", quadrature=8, region="auto", stability=0, strain=0)
    fields["materials"][0]["model"] = "stableNeoHookean"
    taller = message("epoch", {"index": 1}, epoch_arrays(points=box((4.0, 4.0, 3.0)).points))
    return [message("open", fields), EPOCH, SOLVE, taller, SOLVE]


@conversation
def far_anchors() -> list[RawMessage]:
    """Anchors and landmarks so far away that their squares overflow, and so near that no voxel holds them."""
    arrays = everything_solve_arrays()
    solves = [
        message("solve", {"time": 1.0}, changed(arrays, name, number))
        for name in ("hook_anchors", "suture_anchors", "inner_bite_anchors", "hook_targets", "retractor_motion")
        for number in (1e155, 1e7, -9.0)
    ]
    epochs = [
        message("epoch", {"index": 0}, changed(everything_epoch_arrays(), name, number))
        for name in ("points", "landmarks", "ground_points", "section_points")
        for number in (1e155, 1e7, -9.0)
    ]
    return [everything_open(), *epochs, everything_epoch(), *solves]


@conversation
def spent_epochs() -> list[RawMessage]:
    """An epoch that fails when its memory is spent, then a smaller one, which once ended the daemon."""
    large = message("epoch", {"index": 0}, epoch_arrays(points=box((400.0, 400.0, 60.0)).points))
    opened = message("open", session_fields(memory_budget=40 << 20))
    return [opened, large, EPOCH, SOLVE, large, SOLVE]


@conversation
def long_box() -> list[RawMessage]:
    """Twelve triangles of a meter, held, gripped, above bone: they cost what their area is worth."""
    surface = box((1000.0, 3.0, 3.0))
    grip = np.full(12, -1, np.int32)
    grip[10:] = 0
    bones = {"bone_points": surface.points - [0.0, 0.0, 8.0], "bone_triangles": surface.triangles}
    return [
        message("open", session_fields(retractors=1), bones),
        message("epoch", {"index": 0}, epoch_arrays(points=surface.points, grip=grip)),
    ]


@conversation
def no_blocks() -> list[RawMessage]:
    """A tissue that is fixed all through: no cell is computed."""
    arrays = epoch_arrays(points=box((2.0, 2.0, 1.0)).points, fixed=np.ones(12, np.uint8))
    return [
        message("open", session_fields(spacing=2.0)),
        message("epoch", {"index": 0}, arrays),
        message("solve", {"time": 1.0}, {**solve_payload(pull()).arrays, "hook_anchors": np.array([[1.0, 1.0, 1.0]])}),
    ]


@conversation
def taken_session() -> list[RawMessage]:
    """A session's number that is another's, a budget of 2^50 bytes, and settings at the ends of what is taken."""
    return [
        message("open", session_fields(memory_budget=1 << 50, sutures=1000)),
        message("epoch", {"index": 2147483647}, epoch_arrays(), session=2**64 - 1),
        message("epoch", {"index": 2147483647}, epoch_arrays(), session=1),
        message("close", session=77),
    ]


@conversation
def wrong_order() -> list[RawMessage]:
    """Every message when it is not its time."""
    return [
        SOLVE,
        EPOCH,
        state(),
        message("close"),
        OPEN,
        SOLVE,
        state(),
        OPEN,
        message("close"),
        message("close"),
        EPOCH,
    ]


@conversation
def wrong_states() -> list[RawMessage]:
    """States of other sizes, precisions and numbers than the session's."""
    stability = message(
        "state",
        {"precision": "float"},
        {
            "nodes": np.full((NODES, 3), 1e7, np.float32),
            "suture_separations": np.zeros((2, 3)),
            "suture_multipliers": np.full((2, 3), 1e300),
            "grip_multipliers": np.full(3 * NODES, -1e300),
            "activation": np.ones(1),
            "stability": np.array([1e300, -1.0]),
            "loads": np.array([[2e9, 1.0, 1.0, 1.0, 1.0]]),
        },
    )
    return [OPEN, EPOCH, state(NODES + 1), state(0), state(NODES, "f8"), state(NODES, "f4", 3), stability, SOLVE]


@conversation
def wrong_numbers() -> list[RawMessage]:
    """Numbers that are not finite, and indices out of range, in every array of an epoch and of a solve."""
    found = [everything_open()]
    for kind, arrays in (("epoch", everything_epoch_arrays()), ("solve", everything_solve_arrays())):
        fields = {"index": 0} if kind == "epoch" else {"time": 1.0}
        for name, array in arrays.items():
            if array.dtype.kind == "f":
                found += [message(kind, fields, changed(arrays, name, number)) for number in (np.nan, -np.inf)]
            else:
                top = np.iinfo(array.dtype).max
                found += [message(kind, fields, changed(arrays, name, number)) for number in (top, top // 2)]
        found.append(everything_epoch())
    return found


@conversation
def odd_surfaces() -> list[RawMessage]:
    """Surfaces that are empty, flat, open, inside out, tiny, or all in one point."""
    surface = box()
    flat, inside_out = surface.points * [1.0, 1.0, 0.0], surface.triangles[:, ::-1].copy()
    crossing = np.vstack([surface.points, surface.points + np.array([1.3, 0.7, 0.4])])
    labels: dict[str, NDArray[Any]] = {
        "fixed": np.zeros(24, np.uint8),
        "support": np.zeros(24, np.uint8),
        "grip": np.full(24, -1, np.int32),
    }
    empty = {"points": np.zeros((0, 3)), "triangles": np.zeros((0, 3), np.int32)}
    none = {name: array[:0] for name, array in labels.items()}
    changes: list[dict[str, Any]] = [
        {**empty, **none},
        {"points": flat},
        {"points": np.zeros((8, 3))},
        {"points": surface.points * 1e-9},
        {"points": surface.points + 9.9e6},
        {"triangles": inside_out},
        {"triangles": np.zeros((12, 3), np.int32)},
        {"triangles": surface.triangles[:11], **{name: array[:11] for name, array in labels.items()}},
        {"points": crossing, "triangles": np.vstack([surface.triangles, surface.triangles + 8]), **labels},
    ]
    return [OPEN, *(message("epoch", {"index": 0}, epoch_arrays(**change)) for change in changes), EPOCH, SOLVE]


@conversation
def violent_frames() -> list[RawMessage]:
    """Frames that no tissue bears: targets at the ends of what is taken, stiffness and loads of any size."""
    arrays = everything_solve_arrays()
    loud = [
        ("hook_targets", -100.0), ("hook_stiffness", 1e300), ("hook_stiffness", 1e-300), ("suture_stiffness", 1e30),
        ("suture_tension", 1e300), ("suture_length", 1e7), ("load_traction", 1e300), ("load_pressure", -1e30),
    ]  # fmt: skip
    turned = {**arrays, "retractor_motion": np.diag([-1.0, -1.0, 1.0, 1.0])[None]}
    solves = [message("solve", {"time": 1.0}, changed(arrays, name, number, -1)) for name, number in loud]
    return [everything_open(), everything_epoch(), *solves, message("solve", {"time": 1.0}, turned)]


@conversation
def odd_settings() -> list[RawMessage]:
    """Settings and materials at and beyond the ends of what is taken."""
    settings: list[dict[str, Any]] = [
        {"spacing": 1e-300}, {"spacing": 1e7}, {"fine_ratio": 32}, {"fine_ratio": 2**31 - 1}, {"tolerance": 0.999},
        {"gap_tolerance": 1e300}, {"max_newton": 2**31 - 1}, {"gravity": [1e308, -1e308, 0.0]}, {"threads": 4096},
        {"sutures": 2**31 - 1}, {"memory_budget": 0}, {"time_budget": 1e308}, {"time_budget": -1.0},
        {"bed_stiffness": 1e308, "bed_shear": 1e308}, {"origin": [1e7, -1e7, 1e7]},
    ]  # fmt: skip
    found = []
    for change in settings:
        found += [message("open", session_fields(**change)), EPOCH, SOLVE, message("close")]
    for field, number in (
        ("youngs_modulus", 1e308),
        ("youngs_modulus", 1e-308),
        ("density", 1e308),
        ("mooney_ratio", 1e300),
    ):
        fields = session_fields()
        fields["materials"][0][field] = number
        found += [message("open", fields), EPOCH, SOLVE, message("close")]
    return found


@conversation
def odd_headers() -> list[RawMessage]:
    """Headers that are no map, too large, too deep, of other kinds, or twice the same; shapes that overflow."""
    deep: Any = 1
    for _ in range(12):
        deep = [deep]
    shapes: tuple[Any, ...] = (
        [2**63],
        [2**40, 2**40],
        [2**32, 2**32],
        [-1],
        [1.5],
        [1] * 5,
        [2**64 - 1, 2**64 - 1],
        "n",
        [0, 2**41],
    )
    shaped = [
        [
            msgpack.packb(
                {"v": 1, "type": "epoch", "id": 1, "arrays": [{"name": "points", "dtype": "f8", "shape": shape}]}
            ),
            b"",
        ]
        for shape in shapes
    ]
    twice = b"\x84\xa1v\x01\xa2id\x01\xa2id\x02\xa4type\xa4ping"
    listed = {"name": "points", "dtype": "f8", "shape": [0]}
    return [
        [],
        [b""],
        [b"\xc1"],
        [b"\x81"],
        [msgpack.packb(1)],
        [msgpack.packb([])],
        [msgpack.packb({1: 2})],
        [msgpack.packb({"v": 2, "type": "ping", "id": 1, "arrays": []})],
        [msgpack.packb({"v": 1, "type": "ping", "id": -1, "arrays": []})],
        [msgpack.packb({"v": 1, "type": "ping", "id": 2**64 - 1, "arrays": [], "session": "x"})],
        [msgpack.packb({"v": 1, "type": b"ping", "id": 1, "arrays": [], "time": None})],
        [msgpack.packb({"v": 1, "type": "ping", "id": 1, "arrays": [], "deep": deep})],
        [msgpack.packb({"v": 1, "type": "\x1b]0;x\x07" * 80, "id": 1, "arrays": []})],
        [msgpack.packb({"v": 1, "type": "ping", "id": 1, "arrays": [], "long": "x" * 5000})],
        [msgpack.packb({"v": 1, "type": "ping", "id": 1, "arrays": []}) + b"\x00"],
        [b"\xdf\xff\xff\xff\xff"],
        [b"\xdd\xff\xff\xff\xff"],
        [b"\xdb\xff\xff\xff\xff"],
        [twice],
        [b"\x81\xa1x" + b"\xa0" * 70_000],
        [msgpack.packb({"v": 1, "type": "epoch", "id": 1, "arrays": [listed, listed]}), b"", b""],
        [msgpack.packb({"v": 1, "type": "epoch", "id": 1, "arrays": [listed] * 33}), *[b""] * 33],
        *shaped,
    ]


@conversation
def odd_parts() -> list[RawMessage]:
    """Arrays that are missing, too short, too long, too many, of another dtype, or unknown."""
    whole = epoch_arrays()
    wrong_type = {**whole, "points": whole["points"].astype(np.float32)}
    unknown = {**whole, "colors": np.zeros(3)}
    missing = {name: array for name, array in whole.items() if name != "grip"}
    return [
        OPEN,
        EPOCH[:-1],
        [*EPOCH, b""],
        [EPOCH[0], EPOCH[1][:-1], *EPOCH[2:]],
        [EPOCH[0], EPOCH[1] + b"\x00", *EPOCH[2:]],
        [EPOCH[0], *[b""] * 300],
        *(message("epoch", {"index": 0}, arrays) for arrays in (wrong_type, unknown, missing)),
        message("ping", None, {"points": np.zeros(3)}),
        message("close", {"time": 1.0}),
    ]


def main() -> int:
    """Write every conversation beside those that were found."""
    FOLDER.mkdir(exist_ok=True)
    for name, make in CONVERSATIONS.items():
        (FOLDER / f"{name}.messages").write_bytes(file_of(make()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
