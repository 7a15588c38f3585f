"""Dataclasses with arrays as one block of bytes and back, to the bit: what the frame store and the worker's pipe hold.

In the header of `array_codec` a dataclass is the extension 1, its name and its fields in order, a member of an
enumeration likewise with its value, and an array the extension 2, its name. Lists become tuples.
"""

from __future__ import annotations

import typing
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from lappet.core.array_codec import Bytes, CodecError, decode, encode, join, split

_VALUE, _ARRAY = 1, 2


def pack(value: object) -> bytes:
    """Write a value as one block of bytes.

    Parameters
    ----------
    value
        A value of dataclasses, enumerations, arrays, numbers, text, tuples and maps.

    Returns
    -------
    bytes
        The block.

    Raises
    ------
    CodecError
        If it holds anything else.
    """
    arrays: dict[str, NDArray[Any]] = {}

    def write(each: Any) -> bytes:
        return bytes(msgpack.packb(each, default=outgoing, strict_types=True))

    def outgoing(each: Any) -> Any:
        if is_dataclass(each) and not isinstance(each, type):
            inner = [type(each).__name__, *(getattr(each, item.name) for item in fields(each))]
            return msgpack.ExtType(_VALUE, write(inner))
        if isinstance(each, np.ndarray):
            name = str(len(arrays))
            arrays[name] = each
            return msgpack.ExtType(_ARRAY, name.encode())
        if isinstance(each, np.generic):
            return each.item()
        if isinstance(each, Enum):
            return msgpack.ExtType(_VALUE, write([type(each).__name__, each.value]))
        if isinstance(each, tuple):
            return list(each)
        raise TypeError(f"a {type(each).__name__} is none of its values")

    try:
        tree = write(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise CodecError(f"A {type(value).__name__} cannot be written: {error}.") from error
    return join(encode({"value": msgpack.ExtType(_VALUE, tree)}, arrays))


def unpack(data: Bytes, kind: Any) -> Any:
    """Read a value from one block of bytes.

    Parameters
    ----------
    data
        As `pack` wrote them.
    kind
        A type, or union of types, that it may be; only this and what the types of its fields name is made.

    Returns
    -------
    Any
        The value; arrays are read-only and lie in `data`.

    Raises
    ------
    CodecError
        If the bytes are no such value; nothing else is raised.
    """
    known = classes_of(kind)
    trees: list[bytes] = []

    def keep(code: int, tree: bytes) -> None:
        trees.append(tree)

    header, arrays = decode(split(data), extension=keep)
    if header.keys() != {"value"} or len(trees) != 1:
        raise CodecError("The header holds no value.")

    def incoming(code: int, data: bytes) -> Any:
        if code == _ARRAY:
            return arrays[data.decode()]
        if code != _VALUE:
            raise CodecError(f"The value holds the msgpack extension {code}, which is none of its own.")
        name, *values = msgpack.unpackb(data, ext_hook=incoming, use_list=False, strict_map_key=False)
        if name not in known or len(values) != _size(known[name]):
            raise CodecError(f"The value holds a {name!r:.60} that is not known; install one release of Lappet.")
        return known[name](*values)

    try:
        value = msgpack.unpackb(trees[0], ext_hook=incoming, use_list=False, strict_map_key=False)
    except CodecError:
        raise
    except Exception as error:  # msgpack and the values' constructors raise a dozen kinds
        raise CodecError(f"The value cannot be read ({type(error).__name__}: {error}).") from error
    if not isinstance(value, kind):
        raise CodecError(f"The value is a {type(value).__name__}, which is not what is read here.")
    return value


@lru_cache
def classes_of(kind: Any) -> dict[str, type[Any]]:
    """Find the dataclasses and enumerations that a type is made of.

    Parameters
    ----------
    kind
        A type, or a union of types.

    Returns
    -------
    dict[str, type[Any]]
        By name: its own, and those that the types of fields name.
    """
    found: dict[str, type[Any]] = {}
    waiting = [kind]
    while waiting:
        each = waiting.pop()
        if isinstance(each, type) and (is_dataclass(each) or issubclass(each, Enum)):
            if each.__name__ not in found:
                found[each.__name__] = each
                if is_dataclass(each):
                    waiting += typing.get_type_hints(each).values()
            assert found[each.__name__] is each, f"two classes are called {each.__name__}"
        else:
            waiting += typing.get_args(each)
    return found


def _size(kind: type[Any]) -> int:
    """Return how many values a member of an enumeration, or a dataclass, is made of."""
    return 1 if issubclass(kind, Enum) else len(fields(kind))
