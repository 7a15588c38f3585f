"""The digest of values, equal for equal values, whoever computes it: the keys of frames, plans and surfaces.

Every value is hashed with its kind and, where it has one, its length: no two values give the same bytes. Numbers count
by value (1 as 1.0, -0 as 0), arrays by dtype, shape and contents in little-endian C order, dataclasses by the name of
their class and their fields.
"""

from __future__ import annotations

import hashlib
import struct
import weakref
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

SIZE = 32  # bytes
_number = struct.Struct("<xd").pack  # no other kind begins with a zero
_names: dict[type[Any], tuple[str, ...]] = {}
_remembered: dict[int, tuple[weakref.ref[Any], bytes]] = {}  # by id: what is large and never changes


def digest(*values: object, remember: Sequence[type[Any]] = ()) -> bytes:
    """Hash numbers, text, bytes, arrays, lists, tuples, maps and dataclasses of these.

    Parameters
    ----------
    *values
        What to hash, in order.
    remember
        Classes whose objects are large and never change: each object is hashed once.

    Returns
    -------
    bytes
        The digest, `SIZE` bytes.

    Raises
    ------
    TypeError
        If a value is of another kind.
    """
    hasher = hashlib.blake2b(digest_size=SIZE)
    for value in values:
        _feed(hasher, value, tuple(remember))
    return hasher.digest()


def _feed(hasher: Any, value: Any, remember: tuple[type[Any], ...]) -> None:
    if remember and isinstance(value, remember):
        hasher.update(b"M" + _remembered_digest(value))
    elif value is None:
        hasher.update(b"N")
    elif isinstance(value, str):
        text = value.encode("utf-8", "surrogatepass")
        hasher.update(b"S%d:" % len(text) + text)
    elif isinstance(value, bytes):
        hasher.update(b"B%d:" % len(value) + value)
    elif isinstance(value, bool | int | float | np.number | np.bool_):
        hasher.update(_number(float(value) + 0.0))
    elif isinstance(value, np.ndarray):
        _feed_array(hasher, value)
    elif isinstance(value, dict):
        hasher.update(b"D%d:" % len(value))
        for name, entry in value.items():
            _feed(hasher, name, remember)
            _feed(hasher, entry, remember)
    elif isinstance(value, list | tuple):
        hasher.update(b"L%d:" % len(value))
        for entry in value:
            _feed(hasher, entry, remember)
    elif is_dataclass(value):
        kind = type(value)
        hasher.update(b"V")
        _feed(hasher, kind.__name__, ())
        for name in _field_names(kind):
            _feed(hasher, getattr(value, name), remember)
    else:
        raise TypeError(f"a {type(value).__name__} has no digest")


def _feed_array(hasher: Any, value: np.ndarray) -> None:
    array = np.ascontiguousarray(value)
    array = array + 0.0 if array.dtype.kind == "f" else array
    little = array.dtype.newbyteorder("<")
    hasher.update(f"A{little.str}{value.shape}".encode())
    hasher.update(array.astype(little, copy=False).tobytes())


def _remembered_digest(value: object) -> bytes:
    found = _remembered.get(id(value))
    if found is not None and found[0]() is value:
        return found[1]
    result = digest(value)
    name = id(value)
    _remembered[name] = (weakref.ref(value, lambda _: _remembered.pop(name, None)), result)
    return result


def _field_names(kind: type[Any]) -> tuple[str, ...]:
    names = _names.get(kind)
    if names is None:
        names = _names[kind] = tuple(item.name for item in fields(kind))
    return names
