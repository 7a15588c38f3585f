"""Values with arrays as bytes: a msgpack header, a map, and one raw part per array, little-endian and C-ordered.

The header's field `arrays` names each array with its dtype and shape, in the order of the parts. Messages to the
daemon, the frame store and the worker's pipe all use this; they differ in their limits. Everything that is read is
checked before it is used.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import SentenceError
from lappet.core.problem_code import ProblemCode

DTYPES: dict[str, np.dtype[Any]] = {
    "u1": np.dtype("u1"),
    "i4": np.dtype("<i4"),
    "i8": np.dtype("<i8"),
    "f4": np.dtype("<f4"),
    "f8": np.dtype("<f8"),
}
MAX_DIMENSIONS = 4
MAX_ELEMENTS = 1 << 40
_NAMES = {(dtype.kind, dtype.itemsize): name for name, dtype in DTYPES.items()}
_ALIGN = 16  # bytes: arrays in a block are read in place
_LENGTH = 8  # bytes of a length in a block

ExtensionHook = Callable[[int, bytes], Any]
Bytes = bytes | memoryview


class CodecError(SentenceError, ValueError):
    """Bytes that hold no value, or a value that cannot be written; the sentence names the field and its value."""

    code = ProblemCode.PIPE_MALFORMED


@dataclass(frozen=True)
class Limits:
    """What a header may hold at most.

    Parameters
    ----------
    header_bytes
        Bytes of the header.
    total_bytes
        Bytes of the header and all arrays.
    arrays
        Number of arrays.
    text_bytes
        Bytes of one text.
    entries
        Entries of one list or map.
    depth
        Levels of nesting.
    """

    header_bytes: int = 1 << 32
    total_bytes: int = 1 << 32
    arrays: int = 1 << 20
    text_bytes: int = 1 << 32
    entries: int = 1 << 32
    depth: int = 64


UNLIMITED = Limits()


def encode(
    header: Mapping[str, Any],
    arrays: Mapping[str, NDArray[Any]],
    limits: Limits = UNLIMITED,
    default: Callable[[Any], Any] | None = None,
) -> list[bytes]:
    """Write a header and its arrays.

    Parameters
    ----------
    header : mapping
        Numbers, text, truth values, lists and maps by name; `arrays` is added.
    arrays : mapping
        Arrays by name, each of one of `DTYPES`, or of bool, which becomes u1.
    limits : Limits
        What the reader takes.
    default : callable, optional
        Makes a msgpack extension of what msgpack does not know.

    Returns
    -------
    list of bytes
        The header's part, then one per array.

    Raises
    ------
    CodecError
        Where the reader would refuse it.
    """
    if len(arrays) > limits.arrays:
        raise CodecError(f"There are {len(arrays)} arrays; at most {limits.arrays} are read.")
    described = []
    parts = []
    for name, array in arrays.items():
        dtype = _NAMES.get(("u", 1) if array.dtype.kind == "b" else (array.dtype.kind, array.dtype.itemsize))
        if dtype is None:
            raise CodecError(f"The array '{name}' has the dtype {array.dtype}; known are {', '.join(DTYPES)}.")
        if array.ndim > MAX_DIMENSIONS:
            raise CodecError(f"The array '{name}' has {array.ndim} dimensions; at most {MAX_DIMENSIONS} are known.")
        described.append({"name": name, "dtype": dtype, "shape": list(array.shape)})
        parts.append(np.ascontiguousarray(array, dtype=DTYPES[dtype]).tobytes())
    try:
        packed = msgpack.packb({**header, "arrays": described}, use_bin_type=True, default=default)
    except (TypeError, ValueError, OverflowError) as error:
        raise CodecError(f"The header cannot be written: {error}.") from error
    if len(packed) > limits.header_bytes:
        raise CodecError(f"The header has {len(packed)} bytes; at most {limits.header_bytes} are read.")
    total = len(packed) + sum(map(len, parts))
    if total > limits.total_bytes:
        raise CodecError(f"There are {total} bytes; at most {limits.total_bytes} are read.")
    return [packed, *parts]


def decode(
    parts: Sequence[Bytes], limits: Limits = UNLIMITED, extension: ExtensionHook | None = None
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Read a header and its arrays.

    Parameters
    ----------
    parts : sequence of bytes
        As `encode` wrote them.
    limits : Limits
        What is taken.
    extension : callable, optional
        Makes a value of a msgpack extension's code and data; without one they are refused.

    Returns
    -------
    tuple of dict
        The header without `arrays`, and the arrays by name: read-only, C-ordered, in the memory of their parts.

    Raises
    ------
    CodecError
        And only that, whatever the bytes are.
    """
    if not parts:
        raise CodecError("There is no header part.")
    header = _header(parts[0], limits, extension)
    described = header.pop("arrays", None)
    if not isinstance(described, list):
        raise CodecError("The header has no list 'arrays' (an empty one if there are none).")
    if len(described) > limits.arrays:
        raise CodecError(f"There are {len(described)} arrays; at most {limits.arrays} are read.")
    if len(described) != len(parts) - 1:
        raise CodecError(f"The header names {len(described)} arrays; {len(parts) - 1} parts follow it.")
    total = memoryview(parts[0]).nbytes
    arrays: dict[str, NDArray[Any]] = {}
    for entry, part in zip(described, parts[1:], strict=True):
        name, dtype, shape = _description(entry)
        size = math.prod(shape) * dtype.itemsize
        total += size
        if total > limits.total_bytes:
            raise CodecError(f"{total} bytes are needed up to the array '{name}'; {limits.total_bytes} are taken.")
        if name in arrays:
            raise CodecError(f"The array '{name:.60}' is there twice.")
        held = memoryview(part).nbytes
        if held != size:
            raise CodecError(f"The array '{name}' has {held} bytes; its shape {shape} asks for {size}.")
        array: NDArray[Any] = np.frombuffer(part, dtype).reshape(shape)
        array.flags.writeable = False
        arrays[name] = array
    return header, arrays


def join(parts: Sequence[bytes]) -> bytes:
    """Join parts to one block: their number and lengths, 8 bytes each, then each padded to 16 bytes.

    Parameters
    ----------
    parts
        The parts.

    Returns
    -------
    bytes
        The block.
    """
    lengths = [len(parts), *map(len, parts)]
    pieces = [length.to_bytes(_LENGTH, "little") for length in lengths]
    pieces.append(bytes(-len(lengths) * _LENGTH % _ALIGN))
    for part in parts:
        pieces += [part, bytes(-len(part) % _ALIGN)]
    return b"".join(pieces)


def split(block: Bytes) -> list[memoryview]:
    """Split a block of `join` into its parts, without copying.

    Parameters
    ----------
    block
        The block.

    Returns
    -------
    list[memoryview]
        The parts, in the memory of the block.

    Raises
    ------
    CodecError
        If it is no such block.
    """
    view = memoryview(block)
    count = int.from_bytes(view[:_LENGTH], "little")
    start = (1 + count) * _LENGTH
    if view.nbytes < _LENGTH or start > view.nbytes:
        raise CodecError(f"A block of {view.nbytes} bytes cannot hold {count} parts.")
    start += -start % _ALIGN
    parts = []
    for i in range(1, count + 1):
        length = int.from_bytes(view[i * _LENGTH : (i + 1) * _LENGTH], "little")
        if start + length > view.nbytes:
            raise CodecError(f"The block ends within its part {i} of {count}.")
        parts.append(view[start : start + length])
        start += length + -length % _ALIGN
    return parts


def _header(part: Bytes, limits: Limits, extension: ExtensionHook | None) -> dict[str, Any]:
    size = memoryview(part).nbytes
    if size > limits.header_bytes:
        raise CodecError(f"The header part has {size} bytes; at most {limits.header_bytes} are read.")
    text, entries = min(limits.text_bytes, size), min(limits.entries, size)
    try:
        header = msgpack.unpackb(
            part,
            raw=False,
            unicode_errors="replace",
            strict_map_key=True,
            object_pairs_hook=_without_twins,
            ext_hook=extension or _no_extension,
            max_str_len=text,
            max_bin_len=text,
            max_ext_len=text,
            max_array_len=entries,
            max_map_len=entries,
        )
    except CodecError:
        raise
    except Exception as error:  # msgpack raises a dozen kinds
        raise CodecError(f"The header part is not a msgpack map ({type(error).__name__}).") from error
    if not isinstance(header, dict):
        raise CodecError(f"The header part is a {type(header).__name__}; it must be a map.")
    if extension is None:
        _check_plain(header, 0, limits.depth)
    return header


def _without_twins(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        raise CodecError("The header holds a field twice.")
    return result


def _no_extension(code: int, data: bytes) -> Any:
    raise CodecError(f"The header holds a msgpack extension ({code}, {len(data)} bytes).")


def _check_plain(value: object, depth: int, most: int) -> None:
    """Refuse what is neither number, text, truth value, list nor map."""
    if depth > most:
        raise CodecError(f"The header is nested deeper than {most} levels.")
    if isinstance(value, dict):
        for key, entry in value.items():
            if not isinstance(key, str):
                raise CodecError("A key of the header is not a text.")
            _check_plain(entry, depth + 1, most)
    elif isinstance(value, list):
        for entry in value:
            _check_plain(entry, depth + 1, most)
    elif not isinstance(value, (bool, int, float, str)):
        raise CodecError(f"The header holds a {type(value).__name__}, which no field is.")


def _description(entry: object) -> tuple[str, np.dtype[Any], tuple[int, ...]]:
    if not isinstance(entry, Mapping) or entry.keys() != {"name", "dtype", "shape"}:
        raise CodecError("An entry of 'arrays' must be a map of name, dtype and shape.")
    name, dtype, shape = entry["name"], entry["dtype"], entry["shape"]
    if not isinstance(name, str):
        raise CodecError(f"The name of an array is {name!r:.60}; it must be a text.")
    if not isinstance(dtype, str) or dtype not in DTYPES:
        raise CodecError(f"The array '{name:.60}' has the dtype {dtype!r:.60}; known are {', '.join(DTYPES)}.")
    if not isinstance(shape, list) or len(shape) > MAX_DIMENSIONS:
        raise CodecError(f"The shape of '{name:.60}' must be a list of at most {MAX_DIMENSIONS} lengths.")
    elements = 1
    for length in shape:
        if not isinstance(length, int) or isinstance(length, bool) or length < 0:
            raise CodecError(f"The shape of '{name:.60}' holds {length!r:.60}; lengths are 0 or more.")
        elements *= length
        if length > MAX_ELEMENTS or elements > MAX_ELEMENTS:
            raise CodecError(f"The array '{name:.60}' is too large: its shape holds the length {length}.")
    return name, DTYPES[dtype], tuple(shape)
