"""Messages of the wire (PROTOCOL.md): a header and arrays as `lappet.core.array_codec` writes them, within its limits.

Everything that was received is checked before it is used, with the daemon's own limits.
"""

from __future__ import annotations

import typing
from collections.abc import Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from typing import Any, TypeVar

from numpy.typing import NDArray

from lappet.core import array_codec
from lappet.core.array_codec import DTYPES, Bytes, CodecError, Limits
from lappet.core.printable import printable
from lappet.core.problem_code import ProblemCode

VERSION = 1
DEFAULT_MAX_MESSAGE_BYTES = 1 << 30
LIMITS = Limits(header_bytes=64 * 1024, arrays=32, text_bytes=4096, entries=64, depth=5)
_OWN_FIELDS = frozenset({"v", "type", "id", "session", "arrays"})

Value = TypeVar("Value")


class WireError(CodecError):
    """A message that breaks PROTOCOL.md; the sentence names the field, its value and what is expected."""

    code = ProblemCode.WIRE_MALFORMED


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

    Parameters
    ----------
    message
        The message.
    max_message_bytes
        What the daemon takes.

    Returns
    -------
    list[bytes]
        The frames.

    Raises
    ------
    WireError
        If it would be refused.
    """
    taken = _OWN_FIELDS & message.fields.keys()
    if taken:
        raise WireError(f"The field '{min(taken)}' belongs to every header and cannot be given in fields.")
    header: dict[str, Any] = {"v": VERSION, "type": message.type, "id": message.id}
    if message.session is not None:
        header["session"] = message.session
    try:
        frames = array_codec.encode({**header, **message.fields}, message.arrays, LIMITS)
    except CodecError as error:
        raise WireError(f"The message '{message.type}' cannot be sent. {error.problems[0].value}") from error
    total = sum(map(len, frames))
    if total > max_message_bytes:
        raise WireError(
            f"The message '{message.type}' has {total} bytes; the daemon takes {max_message_bytes}: "
            "use a coarser surface, or start the daemon with a larger --max-message-bytes."
        )
    return frames


def decode(frames: Sequence[Bytes], max_message_bytes: int = DEFAULT_MAX_MESSAGE_BYTES) -> Message:
    """Read a message from its frames.

    Parameters
    ----------
    frames
        The frames.
    max_message_bytes
        What is taken.

    Returns
    -------
    Message
        The message.

    Raises
    ------
    WireError
        If the frames are no message; nothing else is raised.
    """
    try:
        header, arrays = array_codec.decode(frames, replace(LIMITS, total_bytes=max_message_bytes))
    except CodecError as error:
        raise WireError(error.problems[0].value) from error
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
    fields = {name: _shown(value) for name, value in header.items() if name not in _OWN_FIELDS}
    return Message(kind, identifier, session, fields, arrays)


def _shown(value: Any) -> Any:
    return printable(value) if isinstance(value, str) else value


def read_array(message: Message, name: str, dtype: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
    """Take an array of a message.

    Parameters
    ----------
    message
        The message.
    name
        Name of the array.
    dtype
        Its dtype, one of `DTYPES`.
    shape
        Its shape, None for any length.

    Returns
    -------
    NDArray[Any]
        The array.

    Raises
    ------
    WireError
        If an array is missing or does not fit; names it.
    """
    array = message.arrays.get(name)
    if array is None:
        raise WireError(f"'{message.type}' has no array '{name}'.")
    if array.dtype != DTYPES[dtype]:
        raise WireError(f"The array '{name}' of '{message.type}' has the dtype {array.dtype}; it must be {dtype}.")
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise WireError(f"The array '{name}' of '{message.type}' has the shape {array.shape}; it must be {shape}.")
    return array


def read_fields(kind: type[Value], fields_: object, where: str) -> Value:
    """Read a dataclass of numbers, text, truth values and such dataclasses from a map of the same names.

    Parameters
    ----------
    kind
        The dataclass; what it has no field for is not read.
    fields_
        The map.
    where
        What the map is called in sentences.

    Returns
    -------
    Value
        The value.

    Raises
    ------
    WireError
        If a field is missing or of another kind; the sentence names it.
    """
    if not isinstance(fields_, dict):
        raise WireError(f"'{where}' is {fields_!r:.60}; it must be a map.")
    values: dict[str, Any] = {}
    for name, type_ in typing.get_type_hints(kind).items():
        if name not in fields_:
            raise WireError(f"'{where}' has no field '{name}'.")
        values[name] = _read_field(type_, fields_[name], f"{where}.{name}")
    return kind(**values)


def _read_field(kind: Any, value: object, where: str) -> Any:
    if is_dataclass(kind):
        return read_fields(typing.cast(type[Any], kind), value, where)
    accepted = (int, float) if kind is float else (kind,)
    if not isinstance(value, accepted) or (isinstance(value, bool) and kind is not bool):
        raise WireError(f"The field '{where}' is {value!r:.60}; it must be a {kind.__name__}.")
    return kind(value)


def _whole(header: dict[str, Any], name: str) -> int:
    value = header.get(name)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise WireError(f"The header field '{name}' is {value!r:.60}; it must be a whole number of 0 or more.")
    return value
