"""The messages of the corpus, written as a client does but without its checks, and the files that hold them."""

from __future__ import annotations

import struct
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from box_scene import box, epoch_arrays, open_fields, pull
from lappet.program.payloads import solve_payload

NODES = 75  # of the box of 4 x 4 x 2 cells

RawMessage = list[bytes]  # header, arrays


def file_of(messages: list[RawMessage]) -> bytes:
    """Write a conversation as a file."""
    written = [struct.pack("<I", len(messages))]
    for message in messages:
        written.append(struct.pack("<I", len(message)))
        written += [struct.pack("<I", len(part)) + part for part in message]
    return b"".join(written)


def messages_of(data: bytes) -> list[RawMessage]:
    """Read a conversation from a file."""
    at = 0

    def take(length: int) -> bytes:
        nonlocal at
        at += length
        return data[at - length : at]

    def number() -> int:
        return int.from_bytes(take(4), "little")

    return [[take(number()) for _ in range(number())] for _ in range(number())]


def message(
    kind: str, fields: dict[str, Any] | None = None, arrays: dict[str, NDArray[Any]] | None = None, **header: Any
) -> RawMessage:
    """Write a message as a client does, without its checks."""
    held = {name: np.ascontiguousarray(array) for name, array in (arrays or {}).items()}
    listed = [
        {"name": name, "dtype": array.dtype.str.lstrip("<|"), "shape": list(array.shape)}
        for name, array in held.items()
    ]
    whole = {"v": 1, "type": kind, "id": 1, "arrays": listed, **(fields or {}), **header}
    return [msgpack.packb(whole), *(array.tobytes() for array in held.values())]


def changed(arrays: dict[str, NDArray[Any]], name: str, number: float, at: int = 0) -> dict[str, NDArray[Any]]:
    """Put a number into an array."""
    array = arrays[name].copy()
    array.reshape(-1)[at] = number
    return {**arrays, name: array}


def session_fields(**changes: Any) -> dict[str, Any]:
    """The fields of an `open` whose frames take at most half a second."""
    return open_fields(**{"time_budget": 0.5, **changes})


OPEN = message("open", session_fields(retractors=1))
EPOCH = message("epoch", {"index": 0}, epoch_arrays())
SOLVE = message("solve", {"time": 1.0}, solve_payload(pull()).arrays)


def everything_open(**changes: Any) -> RawMessage:
    """A session of two materials with all that a material may have, on a bone."""
    surface = box()
    rich = {
        "model": "mooneyRivlin", "youngs_modulus": 40.0, "poissons_ratio": 0.45, "density": 1000.0, "mooney_ratio": 0.5,
        "fiber_direction": [0.0, 0.6, 0.8], "fiber_k1": 11.0, "fiber_k2": 12.0, "fiber_dispersion": 0.1,
        "fiber_slack": 1.1, "fiber_angle": 35.0, "muscle_stress": 30.0, "prestretch": [1.1, 1.05],
    }  # fmt: skip
    plain = {"model": "mooneyRivlin", "youngs_modulus": 20.0, "poissons_ratio": 0.4, "density": 900.0}
    settings = session_fields(
        retractors=1, gravity=[0.0, 0.0, -9.81], quadrature=4, precision="double", correction=1, region="whole",
        preconditioner="twoLevel", strain=1, stability=1, live=1, **changes,
    )  # fmt: skip
    bones = {"bone_points": surface.points * [1.0, 1.0, 0.5] - [0.0, 0.0, 3.0], "bone_triangles": surface.triangles}
    return message("open", {**settings, "materials": [plain, rich]}, bones)


def everything_epoch_arrays() -> dict[str, NDArray[Any]]:
    """Every array that an epoch may have."""
    surface = box()
    m = len(surface.triangles)
    support, grip, fixed = np.zeros(m, np.uint8), np.full(m, -1, np.int32), np.zeros(m, np.uint8)
    support[8:10], grip[0:2], fixed[2:4] = 2, 0, 1
    rollers = np.full(m, -1, np.int32)
    rollers[6:8] = 0
    loaded = np.zeros((1, m), np.uint8)
    loaded[0, 10:] = 1
    return epoch_arrays(
        fixed=fixed,
        support=support,
        grip=grip,
        walls=(support == 0).astype(np.uint8),
        fixed_parts=np.where(fixed, 0, -1).astype(np.int32),
        roller_faces=rollers,
        roller_normals=np.array([[1.0, 0.0, 0.0]]),
        loaded_index=np.array([3], np.int32),
        loaded_faces=loaded,
        section_points=np.array([[2.0, 2.0, 1.0]]),
        section_normals=np.array([[0.0, 1.0, 0.0]]),
        landmarks=np.array([[1.0, 1.0, 2.0], [2.5, 2.5, 1.0]]),
        landmark_triangles=np.array([10, 11], np.int32),
        ground_points=surface.points[[0, 2, 4, 6]],
        ground_triangles=np.array([[0, 1, 3], [0, 3, 2]], np.int32),
        skin_points=surface.points,
        skin_triangles=surface.triangles,
        skin_directions=np.tile([1.0, 0.2, 0.0], (8, 1)),
        skin_stretch=np.tile([1.1, 1.0], (8, 1)),
        region_faces=np.ones((1, m), np.uint8),
    )


def everything_epoch(index: int = 0) -> RawMessage:
    """An epoch with everything, and its nodes at rest."""
    fields = {"index": index, "rest_nodes": 1, "regions": [{"material": 1, "depth_from": 0.0, "depth_to": 0.8}]}
    return message("epoch", fields, everything_epoch_arrays())


def everything_solve_arrays() -> dict[str, NDArray[Any]]:
    """A hook, a suture that closes exactly, a thread over three anchors, a retractor, a load and a muscle."""
    return {
        **solve_payload(pull()).arrays,
        "hook_index": np.array([7], np.int32),
        "suture_index": np.array([0, 1], np.int32),
        "suture_anchors": np.array([[[1.0, 1.0, 2.0], [3.0, 1.0, 2.0]], [[1.0, 3.0, 2.0], [3.0, 3.0, 2.0]]]),
        "suture_triangles": np.full((2, 2), 10, np.int32),
        "suture_closure": np.array([0.1, 0.2]),
        "suture_stiffness": np.full(2, 20.0),
        "suture_is_thread": np.array([0, 1], np.uint8),
        "suture_length": np.array([0.0, 1.5]),
        "suture_tension": np.array([0.0, 5.0]),
        "suture_inner_bites": np.array([0, 1], np.int32),
        "inner_bite_anchors": np.array([[2.0, 3.0, 2.0]]),
        "inner_bite_triangles": np.array([10], np.int32),
        "retractor_index": np.array([0], np.int32),
        "retractor_motion": np.eye(4)[None],
        "load_index": np.array([3], np.int32),
        "load_traction": np.array([[0.1, 0.0, 0.0]]),
        "load_pressure": np.array([0.05]),
        "activation": np.array([0.0, 0.3]),
    }


def state(nodes: int = NODES, dtype: str = "f4", sutures: int = 2, materials: int = 1) -> RawMessage:
    """A state at rest, of a session without grips and loads."""
    arrays = {
        "nodes": np.zeros((nodes, 3), dtype),
        "suture_separations": np.full((sutures, 3), np.nan),
        "suture_multipliers": np.zeros((sutures, 3)),
        "grip_multipliers": np.zeros(0),
        "activation": np.zeros(materials),
        "stability": np.zeros(0),
        "roller_multipliers": np.zeros(0),
        "loads": np.zeros((0, 5)),
        "motion": np.zeros((nodes, 3), np.float32),
    }
    return message("state", {"precision": "double" if dtype == "f8" else "float"}, arrays)
