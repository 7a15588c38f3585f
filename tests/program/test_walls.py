"""With self-contact the solver is told which faces are walls of wounds, and without it no message changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lappet.demo import z_plasty
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.program.payloads import epoch_payload
from lappet.program.settings import SolverSettings
from lappet.usd.stage import read_procedure


def test_walls_of_wounds_are_told_with_self_contact_alone() -> None:
    procedure, settings = read_procedure(z_plasty()), SolverSettings(spacing=4.0)
    plain = compile_program(procedure, settings=settings)
    program = compile_program(procedure, settings=replace(settings, self_contact=True))
    counts = []
    for epoch, grip, landmarks in zip(program.epochs, program.grips, program.landmarks_at, strict=True):
        walls = epoch_payload(epoch, grip, landmarks).arrays["walls"]
        np.testing.assert_array_equal(walls, epoch.surface.origin == FaceOrigin.WOUND_WALL)
        counts.append(int(walls.sum()))
    assert counts[0] == 0, "nothing is cut yet"
    assert counts[-1] > 0
    for epoch, grip, landmarks in zip(plain.epochs, plain.grips, plain.landmarks_at, strict=True):
        assert "walls" not in epoch_payload(epoch, grip, landmarks).arrays
    assert frame_keys(plain, "a daemon") != frame_keys(program, "a daemon")
