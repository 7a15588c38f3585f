"""The wire's messages: what is written is read back, and what breaks PROTOCOL.md raises WireError and nothing else."""

from __future__ import annotations

import math
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from lappet.core.array_codec import DTYPES
from lappet.daemon.frame_diagnostics import StageSeconds
from lappet.daemon.wire import Message, WireError, decode, encode, read_array, read_fields

names = st.text("abcdefghij_", min_size=1, max_size=12)
own = {"v", "type", "id", "session", "arrays"}
scalars = st.one_of(
    st.booleans(), st.integers(-(2**63), 2**64 - 1), st.floats(allow_nan=False), st.text("aé☃ \n'", max_size=20)
)
values = st.one_of(scalars, st.lists(scalars, max_size=4), st.dictionaries(names, scalars, max_size=4))
shapes = hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=5)
arrays = st.sampled_from(sorted(DTYPES)).flatmap(lambda name: hnp.arrays(DTYPES[name], shapes))


def header(**changes: Any) -> bytes:
    fields = {"v": 1, "type": "ping", "id": 1, "arrays": [], **changes}
    packed: bytes = msgpack.packb({name: value for name, value in fields.items() if value is not ...})
    return packed


def described(shape: list[Any], dtype: Any = "f8", name: Any = "points") -> bytes:
    return header(arrays=[{"name": name, "dtype": dtype, "shape": shape}])


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    kind=names,
    identifier=st.integers(0, 2**64 - 1),
    session=st.none() | st.integers(0, 2**64 - 1),
    fields=st.dictionaries(names.filter(lambda name: name not in own), values, max_size=6),
    held=st.dictionaries(names, arrays, max_size=5),
)
def test_a_message_is_read_back_as_it_was_written(
    kind: str, identifier: int, session: int | None, fields: dict[str, Any], held: dict[str, Any]
) -> None:
    read = decode(encode(Message(kind, identifier, session, fields, held)))
    assert (read.type, read.id, read.session, read.fields) == (kind, identifier, session, fields)
    assert list(read.arrays) == list(held)
    for name, array in held.items():
        assert read.arrays[name].shape == array.shape
        assert read.arrays[name].dtype == array.dtype
        assert read.arrays[name].tobytes() == array.tobytes()
        assert not read.arrays[name].flags.writeable


def test_arrays_in_any_memory_order_and_byte_order_travel_as_little_endian_c_order() -> None:
    array = np.arange(24, dtype=np.float64).reshape(2, 3, 4)
    for variant in (array, np.asfortranarray(array), array.astype(">f8"), np.repeat(array, 2, axis=2)[:, :, ::2]):
        frames = encode(Message("epoch", 1, arrays={"points": variant}))
        assert frames[1] == array.astype("<f8").tobytes(order="C")
    flags = encode(Message("epoch", 1, arrays={"fixed": np.array([True, False])}))
    assert decode(flags).arrays["fixed"].dtype == np.uint8


@given(st.lists(st.binary(max_size=200), max_size=4))
@settings(max_examples=300, deadline=None)
def test_random_frames_raise_wire_error_and_nothing_else(frames: list[bytes]) -> None:
    with pytest.raises(WireError):
        decode(frames)


@given(st.data())
@settings(max_examples=500, deadline=None)
def test_a_damaged_message_raises_wire_error_or_is_a_message(data: st.DataObject) -> None:
    whole = encode(
        Message("frame", 3, 1, {"time": 2.0, "seconds": {"total": 0.5}}, {"points": np.ones((2, 3)), "n": np.ones(2)})
    )
    index = data.draw(st.integers(0, len(whole) - 1))
    frame = bytearray(whole[index])
    for _ in range(data.draw(st.integers(1, 4))):
        frame[data.draw(st.integers(0, len(frame) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(frame)))
    damaged = [*whole[:index], bytes(frame[:cut]), *whole[index + 1 :]]
    try:
        message = decode(damaged, max_message_bytes=10_000)
    except WireError:
        return
    assert cut == len(frame) or index == 0
    assert all(array.nbytes < 10_000 for array in message.arrays.values())


@pytest.mark.parametrize(
    ("frames", "says"),
    [
        ([], "no header part"),
        ([b""], "not a msgpack map"),
        ([b"\xc1"], "not a msgpack map"),
        ([msgpack.packb([1, 2])], "is a list"),
        ([msgpack.packb({1: 2})], "not a msgpack map"),
        ([b"\x82\xa1v\x01\xa1v\x01"], "twice"),
        ([header() + b"\x00"], "not a msgpack map"),
        ([header(v=2)], "version 2"),
        ([header(v=...)], "'v' is None"),
        ([header(id=-1)], "'id' is -1"),
        ([header(id=True)], "'id' is True"),
        ([header(type=5)], "'type' is 5"),
        ([header(arrays=...)], "no list 'arrays'"),
        ([header(blob=b"raw")], "holds a bytes"),
        ([header(time=msgpack.Timestamp(1, 2))], "holds a Timestamp"),
        ([header(ext=msgpack.ExtType(4, b"x"))], "extension"),
        ([header(nothing=None)], "holds a NoneType"),
        ([header(deep=[[[[[[1]]]]]])], "nested deeper"),
        ([header(long="x" * 5000)], "not a msgpack map"),
        ([header(arrays=[{}] * 33), *[b""] * 33], "33 arrays"),
        ([header(arrays=[5]), b""], "must be a map"),
        ([described([2, 3])], "names 1 arrays; 0 parts follow it"),
        ([header(), b"extra"], "names 0 arrays; 1 parts follow it"),
        ([described([2, 3]), b"x" * 47], "has 47 bytes"),
        ([described([2, 3]), b"x" * 49], "has 49 bytes"),
        ([described([2**60]), b""], "too large"),
        ([described([2**60, 0]), b""], "too large"),
        ([described([2**32, 2**32]), b""], "too large"),
        ([described([-1]), b""], "holds -1"),
        ([described([1.0]), b"x" * 8], "holds 1.0"),
        ([described([True]), b"x" * 8], "holds True"),
        ([described([1] * 5), b"x" * 8], "at most 4"),
        ([described([1], "O"), b"x" * 8], "dtype 'O'"),
        ([described([1], ["f8"]), b"x" * 8], "dtype"),
        ([described([1], name=3), b"x" * 8], "name of an array"),
        ([described([2**28]), b""], "1073741824 are taken"),
    ],
)
def test_each_way_to_break_a_message_is_named(frames: list[bytes], says: str) -> None:
    with pytest.raises(WireError) as error:
        decode(frames)
    assert says in str(error.value)


def test_two_arrays_of_one_name_are_refused() -> None:
    entry = {"name": "points", "dtype": "u1", "shape": [1]}
    with pytest.raises(WireError, match="'points' is there twice"):
        decode([header(arrays=[entry, entry]), b"x", b"x"])


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (Message("x", 1, arrays={"a": np.zeros(2, np.complex128)}), "dtype complex128"),
        (Message("x", 1, arrays={"a": np.zeros(2, object)}), "dtype object"),
        (Message("x", 1, arrays={"a": np.zeros(2, np.uint32)}), "dtype uint32"),
        (Message("x", 1, arrays={"a": np.zeros((1,) * 5)}), "5 dimensions"),
        (Message("x", 1, arrays={f"a{i}": np.zeros(1) for i in range(33)}), "33 arrays"),
        (Message("x", 1, fields={"id": 2}), "'id' belongs to every header"),
        (Message("x", 1, fields={"set": {1, 2}}), "cannot be written"),
        (Message("x", 1, fields={"text": "x" * 70_000}), "at most 65536"),
        (Message("x", 1, arrays={"a": np.zeros(1000)}), "the daemon takes 4000"),
    ],
)
def test_what_would_be_refused_is_not_sent(message: Message, says: str) -> None:
    with pytest.raises(WireError) as error:
        encode(message, max_message_bytes=4000)
    assert says in str(error.value)


def test_required_arrays_are_checked_by_name_kind_and_shape() -> None:
    message = Message("frame", 1, arrays={"points": np.zeros((4, 3), "<f4")})
    assert read_array(message, "points", "f4", (None, 3)) is message.arrays["points"]
    assert read_array(message, "points", "f4", (4, 3)) is message.arrays["points"]
    with pytest.raises(WireError, match="no array 'strain'"):
        read_array(message, "strain", "f4", (4,))
    with pytest.raises(WireError, match="must be f8"):
        read_array(message, "points", "f8", (None, 3))
    for shape in ((4,), (5, 3), (None, 2)):
        with pytest.raises(WireError, match="the shape"):
            read_array(message, "points", "f4", shape)


def test_fields_are_checked_by_name_and_kind() -> None:
    told = {"update": 1, "linear": 0.5, "setup": 0.0, "stability": 0.25, "total": 1.5, "more": "not read"}
    assert read_fields(StageSeconds, told, "frame.seconds") == StageSeconds(1.0, 0.5, 0.0, 0.25, 1.5)
    for name, value, says in (
        ("total", "1.5", "'frame.seconds.total' is '1.5'; it must be a float"),
        ("total", True, "it must be a float"),
        ("linear", None, "it must be a float"),
    ):
        with pytest.raises(WireError, match=says):
            read_fields(StageSeconds, {**told, name: value}, "frame.seconds")
    with pytest.raises(WireError, match="has no field 'setup'"):
        read_fields(StageSeconds, {name: told[name] for name in told if name != "setup"}, "frame.seconds")
    with pytest.raises(WireError, match="must be a map"):
        read_fields(StageSeconds, [1.0], "frame.seconds")


def test_not_a_number_survives_the_wire() -> None:
    read = decode(encode(Message("frame", 1, None, {"gap": math.nan}, {"gaps": np.array([np.nan, 1.0])})))
    assert math.isnan(read.fields["gap"])
    assert np.isnan(read.arrays["gaps"]).tolist() == [True, False]
