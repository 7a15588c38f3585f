"""Messages of the wire (PROTOCOL.md): a msgpack header frame and one raw little-endian frame per array, both ways.

Everything that was received is checked before it is used, with the daemon's own limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import ProblemsError
from lappet.core.problem_code import ProblemCode

VERSION = 1
MAX_HEADER_BYTES = 64 * 1024
MAX_ARRAYS = 32
MAX_DIMENSIONS = 4
MAX_TEXT_BYTES = 4096
MAX_ENTRIES = 64
MAX_DEPTH = 5
MAX_ELEMENTS = 1 << 40
DEFAULT_MAX_MESSAGE_BYTES = 1 << 30

DTYPES: dict[str, np.dtype[Any]] = {
    "u1": np.dtype("u1"),
    "i4": np.dtype("<i4"),
    "i8": np.dtype("<i8"),
    "f4": np.dtype("<f4"),
    "f8": np.dtype("<f8"),
}
_NAMES = {(dtype.kind, dtype.itemsize): name for name, dtype in DTYPES.items()}
_OWN_FIELDS = frozenset({"v", "type", "id", "session", "arrays"})


class WireError(ProblemsError, ValueError):
    """A message that breaks PROTOCOL.md; the sentence names the field, its value and what is expected."""

    code_of_sentences = ProblemCode.WIRE_MALFORMED


@dataclass(frozen=True, eq=False)
class Message:
    """One message.

    Parameters
    ----------
    type
        Type of the message.
    id
        Number that comes back in every reply.
    session
        Number of the session, or None.
    fields
        Other fields of the header.
    arrays
        Arrays by name, read-only, C-ordered, little-endian.
    """

    type: str
    id: int
    session: int | None = None
    fields: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)


def encode(message: Message, max_message_bytes: int = DEFAULT_MAX_MESSAGE_BYTES) -> list[bytes]:
    """Write a message as frames, the header first.

    Arrays of bool become u1; other dtypes must be one of `DTYPES`.

    Parameters
    ----------
    message
        The message.
    max_message_bytes
        The most that the daemon takes.

    Returns
    -------
    list[bytes]
        The frames.

    Raises
    ------
    WireError
        If the message would be refused.
    """
    taken = _OWN_FIELDS & message.fields.keys()
    if taken:
        raise WireError(f"The field '{min(taken)}' belongs to every header and cannot be given in fields.")
    if len(message.arrays) > MAX_ARRAYS:
        raise WireError(f"The message has {len(message.arrays)} arrays; at most {MAX_ARRAYS} are read.")
    described = []
    frames = []
    for name, array in message.arrays.items():
        dtype = _NAMES.get(("u", 1) if array.dtype.kind == "b" else (array.dtype.kind, array.dtype.itemsize))
        if dtype is None:
            raise WireError(f"The array '{name}' has the dtype {array.dtype}; known are {', '.join(DTYPES)}.")
        if array.ndim > MAX_DIMENSIONS:
            raise WireError(f"The array '{name}' has {array.ndim} dimensions; at most {MAX_DIMENSIONS} are known.")
        described.append({"name": name, "dtype": dtype, "shape": list(array.shape)})
        frames.append(np.ascontiguousarray(array, dtype=DTYPES[dtype]).tobytes())
    header: dict[str, Any] = {"v": VERSION, "type": message.type, "id": message.id, "arrays": described}
    if message.session is not None:
        header["session"] = message.session
    header.update(message.fields)
    try:
        packed = msgpack.packb(header, use_bin_type=True)
    except (TypeError, ValueError, OverflowError) as error:
        raise WireError(f"The header of '{message.type}' cannot be written: {error}.") from error
    if len(packed) > MAX_HEADER_BYTES:
        raise WireError(f"The header of '{message.type}' has {len(packed)} bytes; at most {MAX_HEADER_BYTES} are read.")
    total = len(packed) + sum(map(len, frames))
    if total > max_message_bytes:
        raise WireError(
            f"The message '{message.type}' has {total} bytes; the daemon takes {max_message_bytes}: "
            "use a coarser surface, or start the daemon with a larger --max-message-bytes."
        )
    return [packed, *frames]


def decode(frames: Sequence[bytes | memoryview], max_message_bytes: int = DEFAULT_MAX_MESSAGE_BYTES) -> Message:
    """Read a message from its frames.

    Parameters
    ----------
    frames
        The frames, the header first.
    max_message_bytes
        The most that is taken.

    Returns
    -------
    Message
        The message.

    Raises
    ------
    WireError
        If the bytes are no message; nothing else is raised, whatever they are.
    """
    if not frames:
        raise WireError("The message has no header frame.")
    header = _header(frames[0])
    version = _whole(header, "v")
    if version != VERSION:
        raise WireError(
            f"The message speaks version {version} of the protocol, this client version {VERSION}: "
            "install client and daemon from the same release."
        )
    identifier = _whole(header, "id")
    session = _whole(header, "session") if "session" in header else None
    kind = header.get("type")
    if not isinstance(kind, str):
        raise WireError(f"The header field 'type' is {kind!r:.60}; it must be a text.")
    described = header.get("arrays")
    if not isinstance(described, list):
        raise WireError("The header has no list 'arrays' (an empty one if there are none).")
    if len(described) > MAX_ARRAYS:
        raise WireError(f"The message has {len(described)} arrays; at most {MAX_ARRAYS} are read.")
    if len(described) != len(frames) - 1:
        raise WireError(f"The header names {len(described)} arrays and the message holds {len(frames) - 1} frames.")
    total = len(frames[0])
    arrays: dict[str, NDArray[Any]] = {}
    for entry, frame in zip(described, frames[1:], strict=True):
        name, dtype, shape = _description(entry)
        size = math.prod(shape) * dtype.itemsize
        total += size
        if total > max_message_bytes:
            raise WireError(f"The message needs {total} bytes up to its array '{name}'; {max_message_bytes} are taken.")
        if name in arrays:
            raise WireError(f"The message holds the array '{name:.60}' twice.")
        held = memoryview(frame).nbytes
        if held != size:
            raise WireError(f"The array '{name}' has {held} bytes; its shape {shape} asks for {size}.")
        array: NDArray[Any] = np.frombuffer(frame, dtype).reshape(shape)
        array.flags.writeable = False
        arrays[name] = array
    fields = {name: value for name, value in header.items() if name not in _OWN_FIELDS}
    return Message(kind, identifier, session, fields, arrays)


def require(message: Message, **arrays: tuple[str | tuple[str, ...], tuple[int | None, ...]]) -> None:
    """Check the arrays of a message.

    Parameters
    ----------
    message
        The message.
    **arrays
        For each name the dtype or dtypes and the shape, None in a shape for any length.

    Raises
    ------
    WireError
        If an array is missing or does not fit; names it.
    """
    for name, (dtypes, shape) in arrays.items():
        array = message.arrays.get(name)
        if array is None:
            raise WireError(f"'{message.type}' has no array '{name}'.")
        known = (dtypes,) if isinstance(dtypes, str) else dtypes
        if array.dtype not in [DTYPES[dtype] for dtype in known]:
            raise WireError(
                f"The array '{name}' of '{message.type}' has the dtype {array.dtype}; it must be {' or '.join(known)}."
            )
        fits = array.ndim == len(shape) and all(
            want is None or have == want for have, want in zip(array.shape, shape, strict=True)
        )
        if not fits:
            raise WireError(f"The array '{name}' of '{message.type}' has the shape {array.shape}; it must be {shape}.")


def _header(frame: bytes | memoryview) -> dict[str, Any]:
    size = memoryview(frame).nbytes
    if size > MAX_HEADER_BYTES:
        raise WireError(f"The header frame has {size} bytes; at most {MAX_HEADER_BYTES} are read.")
    try:
        header = msgpack.unpackb(
            frame,
            raw=False,
            unicode_errors="replace",
            strict_map_key=True,
            object_pairs_hook=_without_twins,
            ext_hook=_no_extension,
            max_str_len=MAX_TEXT_BYTES,
            max_bin_len=MAX_TEXT_BYTES,
            max_ext_len=MAX_TEXT_BYTES,
            max_array_len=MAX_ENTRIES,
            max_map_len=MAX_ENTRIES,
        )
    except WireError:
        raise
    except Exception as error:  # msgpack raises a dozen kinds
        raise WireError(f"The header frame is not a msgpack map ({type(error).__name__}).") from error
    if not isinstance(header, dict):
        raise WireError(f"The header frame is a {type(header).__name__}; it must be a map.")
    _plain(header, 0)
    return header


def _without_twins(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        raise WireError("The header holds a field twice.")
    return result


def _no_extension(code: int, data: bytes) -> Any:
    raise WireError(f"The header holds a msgpack extension ({code}, {len(data)} bytes).")


def _plain(value: object, depth: int) -> None:
    """Refuse what is neither number, text, truth value, list nor map."""
    if depth > MAX_DEPTH:
        raise WireError(f"The header is nested deeper than {MAX_DEPTH} levels.")
    if isinstance(value, dict):
        for key, entry in value.items():
            if not isinstance(key, str):
                raise WireError("A key of the header is not a text.")
            _plain(entry, depth + 1)
    elif isinstance(value, list):
        for entry in value:
            _plain(entry, depth + 1)
    elif not isinstance(value, (bool, int, float, str)):
        raise WireError(f"The header holds a {type(value).__name__}, which no field of the protocol is.")


def _whole(header: dict[str, Any], name: str) -> int:
    value = header.get(name)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise WireError(f"The header field '{name}' is {value!r:.60}; it must be a whole number of 0 or more.")
    return value


def _description(entry: object) -> tuple[str, np.dtype[Any], tuple[int, ...]]:
    if not isinstance(entry, Mapping) or entry.keys() != {"name", "dtype", "shape"}:
        raise WireError("An entry of 'arrays' must be a map of name, dtype and shape.")
    name, dtype, shape = entry["name"], entry["dtype"], entry["shape"]
    if not isinstance(name, str):
        raise WireError(f"The name of an array is {name!r:.60}; it must be a text.")
    if not isinstance(dtype, str) or dtype not in DTYPES:
        raise WireError(f"The array '{name:.60}' has the dtype {dtype!r:.60}; known are {', '.join(DTYPES)}.")
    if not isinstance(shape, list) or len(shape) > MAX_DIMENSIONS:
        raise WireError(f"The shape of '{name:.60}' must be a list of at most {MAX_DIMENSIONS} lengths.")
    elements = 1
    for length in shape:
        if not isinstance(length, int) or isinstance(length, bool) or length < 0:
            raise WireError(f"The shape of '{name:.60}' holds {length!r:.60}; lengths are 0 or more.")
        elements *= length
        if length > MAX_ELEMENTS or elements > MAX_ELEMENTS:
            raise WireError(f"The array '{name:.60}' is too large: its shape holds the length {length}.")
    return name, DTYPES[dtype], tuple(shape)
