"""Materials from a procedure to the solved tissue, by the real daemon and `lappet solve`."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lappet.checks.material_problems import region_problems
from lappet.procedure import MODELS, Incision, Landmark, Material, Procedure, Tissue
from lappet.program.compile import compile_program
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import FAT, skin_over_fat
from lappet.usd.stage import write_procedure

LENGTH, THICKNESS, EDGE = 12.0, 4.0, 0.12  # mm


PLAIN = Material("skin")  # without fibers of its own
BED = {"gravity": 0.0, "bed_stiffness": 10.0, "bed_shear": 10.0}  # so that only the skin's own tension acts


def taut(**changes: Any) -> Material:
    values = {"fiber_k1": 15.0, "fiber_k2": 1.0, "fiber_dispersion": 0.2, "prestretch": (1.2, 1.08)}
    return replace(PLAIN, **{**values, **changes})


def dome(radius: float = 30.0, size: float = 30.0) -> Tissue:
    """A patch bent onto a sphere about (0, 0, 0): its skin at `radius`, its underside 4 mm deeper."""
    patch = flat_patch((size, size, THICKNESS), resolution=2.0, spacing=2.0, **BED)
    x, y, z = patch.points.T
    direction = np.stack([x, y, np.full_like(x, radius)], axis=1)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return replace(patch, points=direction * (radius - THICKNESS + z)[:, None])


def incised(tissue: Tissue, materials: tuple[Material, ...], direction: tuple[float, float]) -> Procedure:
    dx, dy = direction
    top = tissue.points[:, 2].max()

    def at(along: float, aside: float) -> tuple[float, float, float]:
        return (along * dx - aside * dy, along * dy + aside * dx, float(top))

    return Procedure(
        tissue,
        materials,
        (
            Incision("cut", 2.0, (at(-LENGTH / 2, 0.0), at(LENGTH / 2, 0.0)), kerf=0.05),
            Landmark("lips", (at(0.0, EDGE), at(0.0, -EDGE)), "lips"),
        ),
        start_time=1.0,
        end_time=2.0,
    )


def run(folder: Path, procedure: Procedure, *arguments: str) -> dict[str, Any]:
    """The report of `lappet solve` with the defaults; the frames' gape in mm under "gape"."""
    write_procedure(procedure, folder / "p.usda")
    command = [sys.executable, "-m", "lappet", "solve", "p.usda", "-o", "c.usdc", "--report", "r.json", "--store", "s"]
    done = subprocess.run([*command, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report: dict[str, Any] = json.loads((folder / "r.json").read_text(encoding="utf-8"))
    for frame in report["frames"]:
        lips = [np.array(position) for position in frame["landmarks"].values()]
        frame["gape"] = float(np.linalg.norm(lips[0] - lips[1])) - 2 * EDGE
    return report


@pytest.mark.slow
@pytest.mark.usefixtures("binary")
def test_taut_skin_over_fat_gapes_more_across_its_fibers_than_along_them(tmp_path: Path) -> None:
    gapes = []
    for direction in ((1.0, 0.0), (0.0, 1.0)):
        patch = flat_patch((40.0, 40.0, THICKNESS), resolution=2.0, spacing=2.0, **BED)
        report = run(tmp_path, skin_over_fat(incised(patch, (), direction), 2.0, taut()))
        intact, cut = report["frames"]
        assert intact["converged"]
        assert cut["converged"]
        assert intact["newton_iterations"] == 0
        assert all(report["scene_profile"][feature] for feature in ("fibers", "prestretch", "materials"))
        assert report["settings"]["precision"] == "float"
        gapes.append(cut["gape"])
    assert gapes[0] > 0.5
    assert 1.3 * gapes[0] < gapes[1] < 0.7 * LENGTH


@pytest.mark.slow
@pytest.mark.usefixtures("binary")
@pytest.mark.parametrize("model", MODELS)
def test_every_model_opens_an_incision_in_taut_skin(model: str, tmp_path: Path) -> None:
    patch = flat_patch((40.0, 40.0, THICKNESS), resolution=2.0, spacing=2.0, **BED)
    fat = replace(FAT.material, model=model)
    report = run(tmp_path, skin_over_fat(incised(patch, (), (0.0, 1.0)), 2.0, taut(model=model), fat))
    assert report["frames"][1]["converged"]
    assert 1.0 < report["frames"][1]["gape"] < 0.7 * LENGTH


@pytest.mark.slow
@pytest.mark.usefixtures("binary")
def test_a_direction_is_turned_into_the_plane_of_the_skin(tmp_path: Path) -> None:
    patch = flat_patch((40.0, 40.0, THICKNESS), resolution=2.0, spacing=2.0, **BED)
    gapes = {}
    for direction in ((1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 1.0, 0.0)):
        procedure = incised(patch, (taut(fiber_direction=direction),), (0.0, 1.0))
        gapes[direction] = run(tmp_path, procedure, "--tolerance", "1e-4")["frames"][1]["gape"]
    assert gapes[1.0, 0.0, 1.0] == pytest.approx(gapes[1.0, 0.0, 0.0], rel=1e-3)
    assert gapes[0.0, 1.0, 0.0] < 0.8 * gapes[1.0, 0.0, 0.0]


@pytest.mark.slow
@pytest.mark.usefixtures("binary")
def test_a_taut_dome_gapes_across_its_lines_more_than_along_them(tmp_path: Path) -> None:
    gapes = []
    for direction in ((1.0, 0.0), (0.0, 1.0)):
        frames = run(tmp_path, incised(dome(), (taut(),), direction))["frames"]
        assert all(frame["converged"] for frame in frames)
        gapes.append(frames[1]["gape"])
    assert gapes[0] > 0.1
    assert gapes[1] > 1.2 * gapes[0]


def test_the_skin_is_told_without_regions_where_a_material_has_a_direction() -> None:
    tissue = dome()
    for material, told in ((PLAIN, False), (taut(), True), (replace(PLAIN, muscle_stress=9.0), True)):
        program = compile_program(incised(tissue, (material,), (1.0, 0.0)))
        assert len(program.epochs) == 2
        for epoch in program.epochs:
            regions = epoch.regions
            assert len(regions) == 0
            assert (len(regions.skin_triangles) > 0) == told
            assert regions.faces.shape == (0, len(regions.skin_triangles))
            if told:  # the uncut dome, its normals outwards
                assert np.linalg.norm(regions.skin_points, axis=1) == pytest.approx(30.0, abs=1e-4)
                a, b, c = regions.skin_points[regions.skin_triangles].transpose(1, 0, 2)
                normals = np.cross(b - a, c - a)
                normals /= np.linalg.norm(normals, axis=1)[:, None]
                middles = (a + b + c) / np.linalg.norm(a + b + c, axis=1)[:, None]
                assert (normals * middles).sum(axis=1).min() > 0.99


def test_materials_of_different_models_are_a_problem() -> None:
    patch = flat_patch((40.0, 40.0, THICKNESS), resolution=2.0, spacing=2.0)
    mixed = skin_over_fat(Procedure(patch), 2.0, taut(model="mooneyRivlin"))
    (problem,) = region_problems(mixed)
    assert "mooneyRivlin, neoHookean" in str(problem)
    assert region_problems(skin_over_fat(Procedure(patch), 2.0, taut())) == []
