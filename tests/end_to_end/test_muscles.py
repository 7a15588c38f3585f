"""Muscles as strands: bars that pull along them as the force–length curve says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from lappet import check
from lappet.core.problem_code import ProblemCode
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Material, Muscle, Procedure, Strand
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

LENGTH, WIDTH, E, STRESS = 24.0, 6.0, 40.0, 100.0
# Along the strand, though its material says y.
MUSCLE = Material("bar_muscle", "neoHookean", E, 0.0, fiber_direction=(0.0, 1.0, 0.0), muscle_stress=STRESS)


def force_length(stretch: float) -> float:
    """The curve of Blemker, Pinsky, Delp 2005 at the optimal stretch 1."""
    change = abs(stretch - 1.0)
    if change <= 0.4:
        return 1.0 - 4.0 * change**2
    return 9.0 * (change - 0.6) ** 2 if change < 0.6 else 0.0


def bar(activation: float, both_ends: bool) -> Procedure:
    patch = flat_patch((LENGTH, WIDTH, WIDTH), resolution=1.5, gravity=0.0)
    middles = patch.points[patch.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    ends = middles[:, 0] < -LENGTH / 2 + 1e-6
    if both_ends:
        ends |= middles[:, 0] > LENGTH / 2 - 1e-6
    tissue = replace(patch, subsets={"fixed": np.flatnonzero(ends).astype(np.int32)}, spacing=1.5, material="soft")
    rises = replace(MUSCLE, muscle_activation=((1.0, 0.0), (2.0, activation)))
    strand = Strand(((-LENGTH, 0.0, WIDTH / 2), (LENGTH, 0.0, WIDTH / 2)), (WIDTH, WIDTH))
    soft = replace(MUSCLE, name="soft", muscle_stress=0.0)
    muscle = Muscle("bar", (strand,), "bar_muscle")
    return Procedure(tissue, (soft, rises), muscles=(muscle,), start_time=1.0, end_time=2.0)


def solved(procedure: Procedure, folder: Path) -> SolveResult:
    store = FrameStore(folder / "store")
    result = solve_procedure(procedure, folder / "cache.usdc", store=store, error_estimate=False)
    assert result.complete, result.reason
    return result


def test_a_free_active_bar_shortens_to_where_its_passive_stress_bears_the_muscle(tmp_path: Path) -> None:
    activation = 0.2
    shear = E / 2.0  # Poisson's ratio 0
    stretch = brentq(lambda s: shear * (s - 1.0 / s) + activation * STRESS * force_length(s), 0.3, 1.0)
    procedure = bar(activation, both_ends=False)
    rest, points = (frame.solved.points for frame in solved(procedure, tmp_path).frames)
    end = rest[:, 0] > LENGTH / 2 - 1e-3
    assert points[end, 0] + LENGTH / 2 == pytest.approx(stretch * LENGTH, rel=0.003)


def test_a_bar_held_at_both_ends_pulls_with_its_activation_times_its_greatest_stress(tmp_path: Path) -> None:
    activation = 0.35
    rest, frame = (frame.solved for frame in solved(bar(activation, both_ends=True), tmp_path).frames)
    assert np.abs(frame.points - rest.points).max() < 0.01
    assert frame.stress == pytest.approx(activation * STRESS, rel=0.02)


def test_a_strand_outside_the_tissue_is_refused() -> None:
    aside = Strand(((-LENGTH, 40.0, 0.0), (LENGTH, 40.0, 0.0)), (3.0, 3.0))
    procedure = replace(bar(0.3, both_ends=False), muscles=(Muscle("bar", (aside,), "bar_muscle"),))
    [found] = check(procedure)
    assert (found.code, found.prim) == (ProblemCode.MUSCLE_OUTSIDE, "/Procedure/Muscles/bar")
