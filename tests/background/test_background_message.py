"""What owner and worker tell each other comes out as it went in, to the bit."""

from __future__ import annotations

import contextlib
import io
import os
from dataclasses import fields, is_dataclass, replace
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import procedure_strategies
from lappet.background.frame_stream import StreamError, read_frame, write_frame
from lappet.background.plan import EpochShape, FrameReady, LiveFrame, Plan, Planned, PlannedFrame, Refused, ShownFrame
from lappet.background.plan_key import plan_key
from lappet.background.procedure_message import MessageError, pack, unpack
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Bone, Hook, Incision, Landmark, Procedure, Suture
from lappet.program.settings import SolverSettings
from small_procedure import small_procedure

numbers = st.floats(allow_nan=False, width=64)
choices = st.builds(
    SolverSettings,
    st.none() | numbers,
    numbers,
    st.sampled_from([1, 4, 8]),
    st.sampled_from(["float", "double"]),
    st.integers(0, 64),
)


def same_bits(a: Any, b: Any) -> bool:
    """Whether two values are of the same classes and hold the same bits."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if is_dataclass(a):
        return all(same_bits(getattr(a, item.name), getattr(b, item.name)) for item in fields(a))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same_bits(a[name], b[name]) for name in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same_bits, a, b))
    if isinstance(a, float):
        return np.float64(a).tobytes() == np.float64(b).tobytes()
    return bool(a == b)


@settings(max_examples=150, deadline=None)
@given(procedure_strategies.procedures())
def test_every_procedure_comes_back_with_every_bit(procedure: Procedure) -> None:
    back = unpack(pack(procedure))
    assert back == procedure
    assert same_bits(back, procedure)


@settings(max_examples=50, deadline=None)
@given(choices)
def test_settings_come_back_with_every_bit(choice: SolverSettings) -> None:
    assert same_bits(unpack(pack(choice)), choice)


def a_plan(seed: int = 0) -> Plan:
    random = np.random.default_rng(seed)
    shape = EpochShape(
        f"{seed:064x}",
        1.5,
        random.normal(size=(5, 3)).astype(np.float32),
        random.integers(0, 5, (4, 3)).astype(np.int32),
        np.array([0, 1, 2, 3], np.uint8),
        random.normal(size=(4, 3, 2)).astype(np.float32),
        random.normal(size=5).astype(np.float32),
        np.array([3, -1, 0, 1], np.int32),
    )
    frames = (PlannedFrame(1, 0, "ab" * 32), PlannedFrame(2, 0, "cd" * 32, (0,), (0, 1)))
    return Plan("ef" * 32, (shape,), frames, ("hook",), ("a", "b"), ("mark 1",), ((0,),), ("Größer als «1 mm».",))


def test_plans_and_happenings_come_back_with_every_bit() -> None:
    shown = ShownFrame(
        np.zeros((3, 3), np.float32),
        {"newton": 3, "residual": 1e-300, "seconds": {"total": 0.1}, "converged": True, "reason": ""},
        {"hook_points": np.full((1, 3), np.nan), "empty": np.zeros((0, 2, 3))},
    )
    for value in (
        Planned(1, a_plan(), (True, False)),
        Refused(2, (Problem(ProblemCode.UNSORTED, "/Procedure/Tissue", "1", "It is wrong.", "Repair it.", "warning"),)),
        FrameReady(3, 7, "00" * 32, False, shown),
        FrameReady(3, 7, "00" * 32, True, None),
        LiveFrame(4, 7, (0.1, -0.0, 1e308), shown, False, 0.25),
    ):
        assert same_bits(unpack(pack(value)), value)


@pytest.mark.parametrize("dtype", ["u1", "<i4", "<i8", "<f4", "<f8", ">f4", "?"])
def test_an_array_is_read_in_place_and_aligned(dtype: str) -> None:
    for length in range(20):
        array = np.arange(2 * length).reshape(length, 2).astype(dtype)
        back = unpack(pack((length * "x", array)))[1]
        np.testing.assert_array_equal(back, array)
        assert back.flags.aligned
        assert not back.flags.writeable


@settings(max_examples=300, deadline=None)
@given(
    st.binary(max_size=60) | st.binary(max_size=40).map(lambda b: msgpack.packb(msgpack.ExtType(1 + b[:1].count(0), b)))
)
def test_bytes_that_are_no_message_are_refused_and_nothing_else_happens(data: bytes) -> None:
    with contextlib.suppress(MessageError):
        unpack(data)


def test_only_known_classes_are_made() -> None:
    for inner in (["Popen", "true"], ["Finished", 1], [3], []):
        with pytest.raises(MessageError):
            unpack(msgpack.packb(msgpack.ExtType(1, msgpack.packb(inner))))
    with pytest.raises(MessageError, match="background worker"):
        pack(object())


def test_a_stream_gives_its_messages_and_ends() -> None:
    receiving, sending = os.pipe()
    messages = [b"", b"x" * 1000, bytes(range(256))]
    with io.FileIO(receiving, "rb") as reader:
        with io.FileIO(sending, "wb") as writer:
            for message in messages:
                write_frame(writer, message)
            writer.write((5).to_bytes(8, "little") + b"abc")  # breaks off
        assert [read_frame(reader) for _ in messages] == messages
        assert read_frame(reader) is None


def test_a_length_that_cannot_be_is_refused_before_memory_is_taken() -> None:
    with pytest.raises(StreamError, match=str(2**63)):
        read_frame(io.BytesIO((2**63).to_bytes(8, "little")))  # type: ignore[arg-type]


@settings(max_examples=60, deadline=None)
@given(procedure_strategies.procedures(), procedure_strategies.procedures())
def test_the_key_of_a_plan_tells_procedures_apart_as_equality_does(a: Procedure, b: Procedure) -> None:
    key = plan_key(a, SolverSettings(), "solver")
    assert plan_key(unpack(pack(a)), SolverSettings(), "solver") == key
    assert (plan_key(b, SolverSettings(), "solver") == key) == (a == b)


def test_every_value_of_a_procedure_and_what_changes_a_frame_is_in_the_key() -> None:
    base = small_procedure()
    slit, hook, stitch, mark = base.events
    assert isinstance(slit, Incision)
    assert isinstance(hook, Hook)
    assert isinstance(stitch, Suture)
    assert isinstance(mark, Landmark)
    tissue = base.tissue
    bone = Bone("skull", tissue.points, tissue.face_vertex_counts, tissue.face_vertex_indices)
    renamed = {f"{name}_2": faces for name, faces in tissue.subsets.items()}
    others = [
        *(replace(base, **change) for change in ({"fps": 25.0}, {"end_time": 9.0}, {"start_time": 0.0})),
        replace(base, events=(hook, slit, stitch, mark)),
        replace(base, events=(replace(slit, name="cut"), hook, stitch, mark)),
        replace(base, events=(slit, hook, stitch, replace(mark, label="other"))),
        replace(base, events=(slit, replace(hook, stiffness=np.nextafter(hook.stiffness, 0.0)), stitch, mark)),
        replace(base, tissue=replace(tissue, subsets=renamed)),
        replace(base, tissue=replace(tissue, uv=None)),
        replace(base, tissue=replace(tissue, gravity=9.81)),
        replace(base, bones=(bone,)),
    ]
    keys = {plan_key(each, SolverSettings(), "s") for each in (base, *others)}
    assert len(keys) == 1 + len(others)
    changes: list[dict[str, Any]] = [{"spacing": 0.5}, {"tolerance": 1e-4}, {"quadrature": 8}, {"precision": "double"}]
    choices = [SolverSettings(**change) for change in changes]
    assert len({plan_key(base, choice, "s") for choice in (SolverSettings(), *choices)}) == 5
    assert plan_key(base, SolverSettings(), "s") != plan_key(base, SolverSettings(), "t")


def test_what_changes_no_frame_changes_no_key() -> None:
    base = small_procedure()
    key = plan_key(base, SolverSettings(), "s")
    assert plan_key(base, SolverSettings(threads=3), "s") == key
    assert plan_key(base, SolverSettings(spacing=base.tissue.spacing), "s") == key
    assert plan_key(replace(base, start_time=1, fps=24), SolverSettings(), "s") == key
    (slit, *others) = base.events
    assert isinstance(slit, Incision)
    assert plan_key(replace(base, events=(replace(slit, time=3), *others)), SolverSettings(), "s") == key
