"""Suture forces against what they must be: the lattice's place does not matter, they converge, a strip has its own.

`test_turned_tissue.py` has the same of tissue that is turned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from advancement_scene import TOP, advancement, last_frame, shifted
from lappet.procedure import Event, Excision, Hook, Incision, Landmark, Material, Procedure, Suture
from lappet.procedure.stitches import Station, simple
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.suture_forces import MOST_SHARED, suture_forces
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import skin_over_fat

pytestmark = pytest.mark.slow


def sums(program: Program, folder: Path, lattices: Sequence[tuple[float, tuple[float, float, float]]]) -> list[float]:
    """The sum of the forces (mN) for spacings and shifts of the lattice in cells."""
    return [float(shifted(program, folder, spacing, shift).suture_forces.sum()) for spacing, shift in lattices]


@pytest.mark.parametrize(
    ("depth", "shifts"),
    [
        (0.0, [(0.5, 0.5, 0.0), (0.25, 0.7, 0.0), (0.0, 0.0, 0.5), (0.3, 0.1, 0.25)]),
        (1.5, [(0.5, 0.5, 0.0), (0.0, 0.0, 0.5), (0.3, 0.1, 0.25)]),
    ],
)
def test_the_sum_does_not_depend_on_where_the_lattice_lies(
    tmp_path: Path, depth: float, shifts: list[tuple[float, float, float]]
) -> None:
    program = compile_program(advancement(depth), settings=SolverSettings(spacing=1.0))
    first, *others = sums(program, tmp_path, [(1.0, (0.0, 0.0, 0.0)), *((1.0, shift) for shift in shifts)])
    assert first > 300.0
    for other in others:
        assert other == pytest.approx(first, rel=0.05)


@pytest.mark.parametrize(("spacing", "spread"), [(2.0, 1.05), (1.0, 1.02)])
def test_layers_under_the_sutures_do_not_depend_on_where_the_lattice_lies(
    tmp_path: Path, spacing: float, spread: float
) -> None:
    fat = Material("fat", youngs_modulus=5.0)
    layered = skin_over_fat(advancement(1.0, top=6.0), 2.0, Material("skin", youngs_modulus=100.0), fat)
    program = compile_program(layered, settings=SolverSettings(spacing=spacing))
    forces = sums(program, tmp_path, [(spacing, (0.0, 0.0, -shift)) for shift in (0.0, 0.25, 0.5, 0.75)])
    assert max(forces) < spread * min(forces)


@pytest.mark.parametrize("thickness", [3.1, 3.375])
def test_skin_of_any_thickness_pulls_alike_wherever_the_lattice_lies_below_it(tmp_path: Path, thickness: float) -> None:
    """Neither is a multiple of a fine voxel, so the lattice holds another part of one at each shift."""
    program = compile_program(advancement(0.0, top=thickness), settings=SolverSettings(spacing=1.0))
    forces = sums(program, tmp_path, [(1.0, (0.0, 0.0, shift)) for shift in (0.0, 0.1, 0.3, 0.5, 0.8)])
    assert max(forces) < 1.04 * min(forces)


@pytest.mark.parametrize("depth", [0.0, 1.5])
def test_the_sum_falls_from_spacing_to_spacing(tmp_path: Path, depth: float) -> None:
    program = compile_program(advancement(depth), settings=SolverSettings(spacing=1.0))
    forces = sums(program, tmp_path, [(spacing, (0.0, 0.0, 0.0)) for spacing in (2.0, 1.5, 1.25, 1.0, 0.75)])
    assert forces == sorted(forces, reverse=True)
    assert forces[0] < 1.15 * forces[3]


@pytest.mark.parametrize(("edge", "gap", "within"), [(1.5, 0.6, 0.0125), (3.675, 0.6, 0.0125), (3.675, 1.0, 0.01)])
def test_a_strip_that_is_sewn_pulls_with_the_force_of_its_stretch(
    tmp_path: Path, edge: float, gap: float, within: float
) -> None:
    """Stretch of neo-Hookean skin between clamps 60 mm apart, of which what lies between the edges is excised.

    Without lateral contraction the clamps do not disturb it; what lies between sutures and edges is not stretched. A
    suture holds the tissue within 1 mm: nearer to the edge it holds more of it on one side.
    """
    side = 6.0
    tissue = flat_patch((60.0, 2.0 * side, TOP), resolution=2.0, gravity=0.0)
    ends = [i for i, face in enumerate(_middles(tissue)) if abs(abs(face[0]) - 30.0) < 1e-6]
    tissue = replace(tissue, subsets={"fixed": np.array(ends, np.int32)}, bed_stiffness=0.0, bed_shear=0.0)
    cuts = [Incision(f"cut_{k}", 2, ((x, -side - 2, TOP), (x, side + 2, TOP))) for k, x in enumerate((-edge, edge))]
    rows = [(y, z) for y in np.linspace(-side + 0.8, side - 0.8, 6) for z in (0.75, 2.25)]
    sutures = [
        Suture(f"row_{k}", ((-edge - gap, float(y), float(z)), (edge + gap, float(y), float(z))), 2, 1)
        for k, (y, z) in enumerate(rows)
    ]
    events: tuple[Event, ...] = (*cuts, Excision("piece", 2, ((0.0, 0.0, TOP),)), *sutures)
    skin = Material("skin", youngs_modulus=50.0, poissons_ratio=0.0)
    procedure = Procedure(tissue, (skin,), events=events, start_time=2, end_time=3)
    program = compile_program(procedure, settings=SolverSettings(spacing=1.0))
    total = float(last_frame(program, tmp_path).suture_forces.sum())
    assert total == pytest.approx(_uniaxial(60.0 / (60.0 - 2.0 * (edge + gap)), 50.0) * 2.0 * side * TOP, rel=within)


def test_a_thread_of_nylon_closes_a_wound_almost_as_exactly(tmp_path: Path) -> None:
    kinds: tuple[dict[str, Any], ...] = ({}, {"mode": "thread", "thread": "nylon 5-0"})
    exact, nylon = (
        last_frame(compile_program(advancement(1.5, **changes), settings=SolverSettings(spacing=2.0)), tmp_path)
        for changes in kinds
    )
    apart = np.linalg.norm(nylon.suture_points[:, 0] - nylon.suture_points[:, 1], axis=1)
    assert nylon.suture_forces.sum() == pytest.approx(exact.suture_forces.sum(), rel=0.1)
    assert 1e-3 < apart.max() < 0.2
    assert np.linalg.norm(exact.suture_points[:, 0] - exact.suture_points[:, 1], axis=1).max() < 2.1e-3


def test_a_loop_at_the_end_of_a_cut_is_not_resolved_where_a_stitch_of_two_bites_is_not(tmp_path: Path) -> None:
    """The cell at the cut's end is whole; the pieces down and up beside the cut share no tissue, those across it do."""
    thick, bite = 6.0, 0.5
    slit = Incision("slit", 2, ((-7.0, 0.0, thick), (7.0, 0.0, thick)))
    sutures = [
        simple(Station((x, 0.0, thick), (0.0, 1.0, 0.0)), bite, 4.0).suture(f"loop_{k}", 2)
        for k, x in enumerate((1.0, 6.7))
    ]
    sutures += [Suture(f"plain_{k}", ((x, -bite, thick), (x, bite, thick)), 2) for k, x in enumerate((-1.0, -6.7))]
    tissue = flat_patch((36.0, 28.0, thick), resolution=2.0, gravity=0.0)
    procedure = Procedure(tissue, (Material("skin"),), events=(slit, *sutures), start_time=2, end_time=2)
    program = compile_program(procedure, settings=SolverSettings(spacing=2.0))
    frame = last_frame(program, tmp_path)
    assert len(frame.suture_shared) == 2 * 4 + 2
    rows = {row.suture: row.resolved for row in suture_forces(program, frame)}
    assert rows == {"loop_0": True, "loop_1": False, "plain_0": True, "plain_1": False}
    index = [program.sutures[i] for i in frame.suture_index].index("loop_1")
    down, across, up, over = frame.suture_shared[4 * index : 4 * index + 4]
    assert max(down, up) <= MOST_SHARED < min(across, over)


def test_a_hook_deep_in_the_tissue_that_is_not_pulled_does_not_press(tmp_path: Path) -> None:
    tissue = flat_patch((24.0, 24.0, 10.0), resolution=4.0, gravity=0.0)
    deep = (1.3, 0.4, 5.0)
    events = (Hook("hook", deep, ((1.0, deep),), 1.0, 3.0), Landmark("probe", (deep,), "probe"))
    procedure = Procedure(tissue, (Material("skin"),), events=events, start_time=1, end_time=1)
    frame = last_frame(compile_program(procedure, settings=SolverSettings(spacing=2.0)), tmp_path)
    assert np.abs(frame.hook_forces).max() < 1e-3
    assert np.abs(frame.landmarks[0] - deep).max() < 1e-6


def _middles(tissue: Any) -> list[np.ndarray]:
    corners = np.split(tissue.face_vertex_indices, np.cumsum(tissue.face_vertex_counts)[:-1])
    return [tissue.points[each].mean(axis=0) for each in corners]


def _uniaxial(stretch: float, youngs_modulus: float) -> float:
    """The nominal stress (kPa) of a neo-Hookean bar of Poisson's ratio 0: W = mu/2 (I1 - 3) - mu ln J."""
    return 0.5 * youngs_modulus * (stretch - 1.0 / stretch)
