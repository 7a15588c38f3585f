"""Content keys: what a solved frame depends on, hashed, so that equal work is recognised wherever it comes from.

key(frame) = H(key(previous frame), epoch, constraints of the frame, solver settings, solver, bones if any)

Only what the daemon is told takes part: renaming a prim, moving a UV or editing what happens later changes no key. The
numbers of sutures and retractors in the procedure, the threads and the budgets are left out as well: they do not change
an equilibrium.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.program.program import Bones, FrameConstraints, Landmarks, Program, SolverSettings

NOT_IN_KEY = frozenset({"sutures", "retractors", "threads", "time_budget", "memory_budget", "correction"})
_SIZE = 32


def frame_keys(program: Program, solver: str) -> tuple[str, ...]:
    """Compute the content key of every frame.

    Parameters
    ----------
    program
        The program.
    solver
        What identifies the daemon that would solve it.

    Returns
    -------
    tuple[str, ...]
        Keys in the frames' order, each of 64 hexadecimal digits.
    """
    settings = settings_digest(program.settings, solver) + bones_digest(program.bones)
    epochs = {
        epoch.index: epoch_digest(epoch, grip, landmarks)
        for epoch, grip, landmarks in zip(program.epochs, program.grips, program.landmarks_at, strict=True)
    }
    keys = []
    previous = b""
    for frame in program.frames:
        parts = [previous, epochs[frame.epoch], constraints_digest(frame), settings]
        previous = _digest(b"frame", *parts)
        keys.append(previous.hex())
    return tuple(keys)


def settings_digest(settings: SolverSettings, solver: str) -> bytes:
    """Compute the digest of the settings that change a solution, and of the solver.

    Parameters
    ----------
    settings
        The settings.
    solver
        What identifies the solver.

    Returns
    -------
    bytes
        The digest.
    """
    names = sorted(item.name for item in fields(settings) if item.name not in NOT_IN_KEY)
    lines = [f"{name}={getattr(settings, name)!r}" for name in names]
    return _digest(b"settings", solver.encode(), *(line.encode() for line in lines))


def bones_digest(bones: Bones) -> bytes:
    """Compute the digest of the bones that the message `open` carries.

    Parameters
    ----------
    bones
        The bones.

    Returns
    -------
    bytes
        The digest; empty where there are none.
    """
    if len(bones.triangles) == 0:
        return b""
    return _arrays(b"bones", [(bones.points, "<f8"), (bones.triangles, "<i4")])


def epoch_digest(epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> bytes:
    """Compute the digest of what the message `epoch` carries, but for its index.

    Parameters
    ----------
    epoch
        The epoch.
    grip
        Retractor that grips each triangle, or -1, shape (m,).
    landmarks
        The landmarks that the epoch's tissue holds.

    Returns
    -------
    bytes
        The digest.
    """
    surface, regions = epoch.surface, epoch.regions
    return _arrays(
        b"epoch",
        [
            (surface.points, "<f8"),
            (surface.triangles, "<i4"),
            (surface.fixed, "u1"),
            (epoch.support, "u1"),
            (grip, "<i4"),
            (landmarks.points, "<f8"),
            (landmarks.triangles, "<i4"),
            (regions.skin_points, "<f8"),
            (regions.skin_triangles, "<i4"),
            (regions.faces, "u1"),
            (regions.material, "<i4"),
            (regions.depth_from, "<f8"),
            (regions.depth_to, "<f8"),
        ],
    )


def constraints_digest(frame: FrameConstraints) -> bytes:
    """Compute the digest of what the message `solve` carries.

    Parameters
    ----------
    frame
        The frame's constraints.

    Returns
    -------
    bytes
        The digest.
    """
    arrays: list[tuple[Any, str]] = [(np.float64(frame.time), "<f8")]
    for item in fields(frame):
        value = getattr(frame, item.name)
        if isinstance(value, np.ndarray):
            arrays.append((value, "<i4" if value.dtype.kind in "iu" else "<f8"))
    return _arrays(b"constraints", arrays)


def _arrays(kind: bytes, arrays: Sequence[tuple[Any, str]]) -> bytes:
    """The digest of arrays in a canonical form: little-endian, C order, -0 as 0, each with its shape."""
    parts = []
    for value, dtype in arrays:
        array = np.ascontiguousarray(np.asarray(value), dtype)
        if array.dtype.kind == "f":
            array = array + 0.0
        parts += [repr(np.shape(value)).encode(), array.tobytes()]
    return _digest(kind, *parts)


def _digest(*parts: bytes) -> bytes:
    hasher = hashlib.blake2b(digest_size=_SIZE)
    for part in parts:
        hasher.update(len(part).to_bytes(8, "little"))
        hasher.update(part)
    return hasher.digest()
