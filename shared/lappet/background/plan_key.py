"""The key of a plan: equal for equal procedures, settings and solvers, whoever computes it."""

from __future__ import annotations

import hashlib
import struct
import weakref
from dataclasses import fields
from typing import Any

import numpy as np

from lappet.background.plan import SolveSettings
from lappet.procedure import Bone, Procedure, Tissue

_number = struct.Struct("<xd").pack  # no other kind begins with a zero
_FORMAT = b"lappet plan 1"
_SIZE = 32
_names: dict[type[Any], tuple[str, ...]] = {}
_known: dict[int, tuple[weakref.ref[Any], bytes]] = {}  # digests of meshes by id; they are large and never change


def plan_key(procedure: Procedure, settings: SolveSettings, solver_identity: str) -> str:
    """Compute the key of a plan: a hash of every value of the procedure and of what of the settings changes a frame.

    The names of events, materials and subsets and the order of the events take part; numbers count by value (1 as 1.0,
    -0 as 0), and the threads, which change no frame, not at all. The tissue and the bones are hashed once per object.

    Parameters
    ----------
    procedure
        The procedure.
    settings
        How to solve.
    solver_identity
        What identifies the solver, as for `lappet.program.keys.frame_keys`.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    spacing = procedure.tissue.spacing if settings.spacing is None else settings.spacing
    choice = (spacing, settings.tolerance, settings.quadrature, settings.precision)
    hasher = hashlib.blake2b(_FORMAT, digest_size=_SIZE)
    _feed(hasher, (solver_identity, choice))
    _feed(hasher, procedure)
    return hasher.hexdigest()


def digest(value: object) -> bytes:
    """Compute the digest of values of a procedure.

    Parameters
    ----------
    value
        Events, tissue, numbers, text or tuples of these.

    Returns
    -------
    bytes
        The digest.
    """
    hasher = hashlib.blake2b(digest_size=_SIZE)
    _feed(hasher, value)
    return hasher.digest()


def _feed(hasher: Any, value: object) -> None:
    if isinstance(value, Tissue | Bone):
        hasher.update(b"M" + _mesh_digest(value))
    else:
        _feed_plain(hasher, value)


def _mesh_digest(mesh: Tissue | Bone) -> bytes:
    found = _known.get(id(mesh))
    if found is not None and found[0]() is mesh:
        return found[1]
    hasher = hashlib.blake2b(digest_size=_SIZE)
    _feed_plain(hasher, mesh)
    result: bytes = hasher.digest()
    name = id(mesh)
    _known[name] = (weakref.ref(mesh, lambda _: _known.pop(name, None)), result)
    return result


def _feed_plain(hasher: Any, value: Any) -> None:
    """Every value begins with its kind and, where it has one, its length: no two values give the same bytes."""
    if value is None:
        hasher.update(b"N")
    elif isinstance(value, str):
        text = value.encode("utf-8", "surrogatepass")
        hasher.update(b"S%d:" % len(text) + text)
    elif isinstance(value, bool | int | float | np.number | np.bool_):
        hasher.update(_number(float(value) + 0.0))
    elif isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        array = array + 0.0 if array.dtype.kind == "f" else array
        hasher.update(f"A{array.dtype.newbyteorder('<').str}{value.shape}".encode())
        hasher.update(array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes())
    elif isinstance(value, dict):
        hasher.update(b"D%d:" % len(value))
        for name, entry in value.items():
            _feed(hasher, name)
            _feed(hasher, entry)
    elif isinstance(value, list | tuple):
        hasher.update(b"L%d:" % len(value))
        for entry in value:
            _feed(hasher, entry)
    else:
        kind: type[Any] = type(value)
        hasher.update(b"V")
        _feed_plain(hasher, kind.__name__)
        for name in _field_names(kind):
            _feed(hasher, getattr(value, name))


def _field_names(kind: type[Any]) -> tuple[str, ...]:
    names = _names.get(kind)
    if names is None:
        names = _names[kind] = tuple(item.name for item in fields(kind))
    return names
