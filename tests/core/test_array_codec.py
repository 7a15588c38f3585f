"""Frames joined to one block come apart again, and a damaged block is refused."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lappet.core.array_codec import CodecError, Limits, decode, encode, join, split


@settings(deadline=None)
@given(st.lists(st.binary(max_size=40), max_size=5))
def test_a_block_comes_apart_into_its_frames_each_aligned(frames: list[bytes]) -> None:
    block = join(frames)
    assert [bytes(frame) for frame in split(block)] == frames
    start = np.frombuffer(block, np.uint8).ctypes.data
    for frame in split(block):
        if len(frame):
            assert (np.frombuffer(frame, np.uint8).ctypes.data - start) % 16 == 0


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=80), st.integers(0, 100))
def test_what_is_no_block_is_refused_and_nothing_else_happens(data: bytes, cut: int) -> None:
    for bad in (data, join([b"header", bytes(20)])[:cut]):
        with contextlib.suppress(CodecError):
            split(bad)
    with pytest.raises(CodecError, match="cannot hold"):
        split((2**60).to_bytes(8, "little"))


def test_limits_are_those_of_the_reader_both_ways() -> None:
    arrays = {"a": np.zeros(4), "b": np.zeros(4)}
    for limits in (Limits(arrays=1), Limits(total_bytes=70), Limits(header_bytes=10)):
        with pytest.raises(CodecError):
            encode({}, arrays, limits)
        with pytest.raises(CodecError):
            decode(encode({}, arrays), limits)
    deep = encode({"list": [[[1]]]}, {})
    assert decode(deep, Limits(depth=4))[0] == {"list": [[[1]]]}
    with pytest.raises(CodecError, match="deeper than 3"):
        decode(deep, Limits(depth=3))
