"""Content keys: what a solved frame depends on, hashed, so that equal work is recognised wherever it comes from.

key(frame) = H(key(previous frame), epoch, constraints of the frame, solver settings, solver, bones if any)

Only what the daemon is told takes part (`lappet.program.payloads`), and the numbers that tell which hook, suture or
landmark it is: renaming a prim, moving a UV or editing what happens later changes no key. Settings that do not change
an equilibrium are left out (`lappet.program.settings`).
"""

from __future__ import annotations

from numpy.typing import NDArray

from lappet.core.digest import digest
from lappet.cutting.epoch import Epoch
from lappet.program.payloads import Payload, epoch_payload, open_payload, solve_payload
from lappet.program.program import FrameConstraints, Landmarks, Program
from lappet.program.settings import in_key


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
    opened = _opened(program, solver)
    epochs = {
        epoch.index: _epoch(epoch, grip, landmarks)
        for epoch, grip, landmarks in zip(program.epochs, program.grips, program.landmarks_at, strict=True)
    }
    keys = []
    previous = b""
    for frame in program.frames:
        previous = digest("frame", previous, epochs[frame.epoch], _constraints(frame), opened)
        keys.append(previous.hex())
    return tuple(keys)


def _opened(program: Program, solver: str) -> bytes:
    told = open_payload(program.settings, program.bones)
    settings = {name: value for name, value in told.fields["settings"].items() if in_key(name)}
    return digest("open", solver, settings, told.fields["materials"], told.arrays)


def _epoch(epoch: Epoch, grip: NDArray, landmarks: Landmarks) -> bytes:
    told = epoch_payload(epoch, grip, landmarks)
    fields = {name: value for name, value in told.fields.items() if name != "index"}
    return _digest("epoch", Payload(fields, {**told.arrays, "landmark_index": landmarks.index}))


def _constraints(frame: FrameConstraints) -> bytes:
    told = solve_payload(frame)
    return _digest("solve", Payload(told.fields, {**told.arrays, "hook_index": frame.hook_index}))


def _digest(kind: str, told: Payload) -> bytes:
    return digest(kind, told.fields, told.arrays)
