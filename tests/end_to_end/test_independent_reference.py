"""A beam under a hundredth of its own weight against scikit-fem, which shares no code with Lappet.

At such loads every material is linear. Trilinear hexahedra with full quadrature are what eight points per cell must be;
quadratic ones show what one point per cell is worth.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.daemon.daemon_solver import connect_to
from lappet.reports.box_scenes import SKIN, BoxScene
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore

GRAVITY = 9.81e-2  # m/s²
BEAM = BoxScene("beam", "", (24.0, 12.0, 12.0), (8, 4, 4), fixed=(0,), gravity=GRAVITY)
PLACES = np.array([[24.0, 6.0, 12.0], [24.0, 12.0, 6.0], [12.0, 6.0, 12.0]])  # mm

pytestmark = pytest.mark.slow


def by_skfem(spacing: float, quadratic: bool) -> NDArray[np.float64]:
    """The vertical displacements (3,) in mm at `PLACES` by scikit-fem."""
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    axes = [np.linspace(0.0, length, round(length / spacing) + 1) for length in BEAM.size]
    element = skfem.ElementVector(skfem.ElementHex2() if quadratic else skfem.ElementHex1())
    basis = skfem.Basis(skfem.MeshHex.init_tensor(*axes), element, intorder=4)
    weight = SKIN.density * GRAVITY * 1e-6  # kPa/mm
    stiffness = skfem.asm(linear_elasticity(*lame_parameters(SKIN.youngs_modulus, SKIN.poissons_ratio)), basis)
    load = skfem.asm(skfem.LinearForm(lambda v, _: -weight * v[2]), basis)
    held = basis.get_dofs(lambda x: x[0] < 1e-9).all()
    solution = skfem.solve(*skfem.condense(stiffness, load, D=held))
    found = basis.probes(PLACES.T - 1e-9) @ solution
    return np.asarray(found).reshape(3, -1)[2]


def by_lappet(spacing: float, quadrature: int, store: Path) -> NDArray[np.float64]:
    """The same by the daemon."""
    program = BEAM.program(spacing, quadrature=quadrature, precision="double", tolerance=1e-6)
    rest = program.epochs[0].surface.points
    frames = solve_program(program, FrameStore(store), connect_to(None), "test", SolveObserver()).frames
    at = [int(np.argmin(np.linalg.norm(rest - place, axis=1))) for place in PLACES]
    return frames[-1].solved.points[at, 2].astype(float) - rest[at, 2]


@pytest.mark.parametrize("spacing", [3.0, 2.0])
def test_eight_points_per_cell_are_the_trilinear_elements_of_scikit_fem(spacing: float, tmp_path: Path) -> None:
    # 1e-3: at this load the shape changes by 1e-3 as well.
    np.testing.assert_allclose(by_lappet(spacing, 8, tmp_path), by_skfem(spacing, quadratic=False), rtol=1e-3)


def test_one_point_per_cell_is_as_near_to_the_truth_as_quadratic_elements_of_the_same_size(tmp_path: Path) -> None:
    # The limit by extrapolating one point per cell from halved spacings, which the quadratic elements must approach
    # too.
    coarse, fine = by_lappet(1.5, 1, tmp_path), by_lappet(0.75, 1, tmp_path)
    limit = fine + (fine - coarse) / (2.0**1.4 - 1.0)
    quadratic = [np.abs(by_skfem(h, quadratic=True) - limit) for h in (4.0, 3.0)]
    assert np.all(quadratic[1] < quadratic[0])
    assert np.all(np.abs(by_lappet(3.0, 1, tmp_path) - limit) < 1.5 * quadratic[1])
    trilinear = np.abs(by_lappet(3.0, 8, tmp_path) - limit)
    assert np.all(trilinear > 4.0 * quadratic[1])


def test_the_held_edge_lowers_the_order_of_every_method_alike(tmp_path: Path) -> None:
    # Where a held side meets a free one the stress has a singularity, so that even quadratic elements converge with an
    # order below 2.
    values = [by_skfem(h, quadratic=True)[0] for h in (6.0, 3.0)]
    limit = by_lappet(0.75, 1, tmp_path)[0]
    off = [abs(value - limit) for value in values]
    assert np.log2(off[0] / off[1]) < 2.0


def test_the_beam_is_in_the_linear_range(tmp_path: Path) -> None:
    once = by_lappet(3.0, 1, tmp_path / "one")
    scene = replace(BEAM, gravity=2.0 * GRAVITY)
    program = scene.program(3.0, precision="double", tolerance=1e-6)
    rest = program.epochs[0].surface.points
    frame = solve_program(program, FrameStore(tmp_path / "two"), connect_to(None), "test", SolveObserver()).frames[-1]
    at = [int(np.argmin(np.linalg.norm(rest - place, axis=1))) for place in PLACES]
    twice = frame.solved.points[at, 2] - rest[at, 2]
    np.testing.assert_allclose(twice, 2.0 * once, rtol=2e-3)
