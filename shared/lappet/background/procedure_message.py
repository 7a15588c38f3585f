"""Procedures, settings, plans and happenings as msgpack and back, exactly: what owner and worker tell each other.

A dataclass is extension 1: its name and its fields in order. An array is extension 2: its dtype and shape, padded to 16
bytes, then its little-endian contents. Lists become tuples; float64 keeps every bit. Only the classes named here are
read.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import msgpack
import numpy as np

from lappet.background import plan
from lappet.core.problem import Place, Problem, ProblemsError
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    Bone,
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Procedure,
    Region,
    Retractor,
    Suture,
    Tissue,
    Undermine,
)

_CLASSES: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        *(Procedure, Tissue, Material, Region, Bone, Problem, Place),
        *(Incision, Excision, Undermine, Hook, Retractor, Suture, Landmark),
        *(plan.SolveSettings, plan.EpochShape, plan.PlannedFrame, plan.Plan, plan.ShownFrame),
        *(plan.Planned, plan.Refused, plan.IterationDone, plan.FrameReady, plan.FrameFailed, plan.Finished),
        *(plan.Note, plan.LiveFrame),
    )
}
_FIELDS = {kind: tuple(item.name for item in fields(kind)) for kind in _CLASSES.values()}
_VALUE, _ARRAY = 1, 2
_ALIGN = 16  # so that an array read in place starts where its numbers may


class MessageError(ProblemsError, ValueError):
    """Bytes that are no message of this module, or a value that cannot be told in one."""

    code_of_sentences = ProblemCode.PIPE_MALFORMED


def pack(value: object) -> bytes:
    """Write a value as bytes.

    Parameters
    ----------
    value
        A value made of the known dataclasses, arrays, numbers, text, tuples and maps.

    Returns
    -------
    bytes
        The bytes.

    Raises
    ------
    MessageError
        If the value cannot be told in a message.
    """
    try:
        return bytes(msgpack.packb(value, default=_outgoing))
    except (TypeError, ValueError, OverflowError) as error:
        raise MessageError(f"A {type(value).__name__} cannot be told to the background worker: {error}.") from error


def unpack(data: bytes | bytearray | memoryview) -> Any:
    """Read a value from bytes.

    Parameters
    ----------
    data
        The bytes.

    Returns
    -------
    Any
        The value; arrays are read-only.

    Raises
    ------
    MessageError
        If the bytes are no message; nothing else is raised.
    """
    try:
        return msgpack.unpackb(data, ext_hook=_incoming, use_list=False, strict_map_key=False)
    except MessageError:
        raise
    except Exception as error:  # msgpack and the values' constructors raise a dozen kinds
        raise MessageError(f"The message cannot be read ({type(error).__name__}: {error}).") from error


def _outgoing(value: Any) -> Any:
    names = _FIELDS.get(type(value))
    if names is not None:
        inner = [type(value).__name__, *(getattr(value, name) for name in names)]
        return msgpack.ExtType(_VALUE, msgpack.packb(inner, default=_outgoing))
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        array = array.astype(array.dtype.newbyteorder("<"), copy=False)
        if array.dtype.kind not in "biuf":
            raise TypeError(f"an array of {array.dtype} is none of numbers")
        head = msgpack.packb((array.dtype.str, value.shape))
        room = -(len(head) + 1) % _ALIGN
        return msgpack.ExtType(_ARRAY, bytes([room]) + head + bytes(room) + array.tobytes())
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"a {type(value).__name__} is none of its values")


def _incoming(code: int, data: bytes) -> Any:
    if code == _VALUE:
        name, *values = msgpack.unpackb(data, ext_hook=_incoming, use_list=False, strict_map_key=False)
        kind = _CLASSES.get(name)
        if kind is None or len(values) != len(_FIELDS[kind]):
            raise MessageError(f"The message holds a {name!r:.60} that is not known; install one release of Lappet.")
        return kind(*values)
    if code == _ARRAY:
        unpacker = msgpack.Unpacker(use_list=False)
        unpacker.feed(memoryview(data)[1:128])
        dtype, shape = unpacker.unpack()
        start = 1 + unpacker.tell() + data[0]
        return np.frombuffer(data, np.dtype(dtype), int(np.prod(shape, dtype=np.int64)), start).reshape(shape)
    raise MessageError(f"The message holds the msgpack extension {code}, which is none of its own.")
