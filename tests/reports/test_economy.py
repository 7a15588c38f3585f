"""What a scene does not need costs nothing: counted where it can be counted, and left out where it can be left out."""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Usd, UsdGeom

from lappet.commands.cli import cli
from lappet.core.value_codec import pack
from lappet.daemon.client import SolverClient, SolverRefused
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.process import SolverDaemon
from lappet.daemon.solved_frame import SCALARS, SolvedFrame
from lappet.program.program import Program
from lappet.program.settings import MaterialParameters
from lappet.reports.box_scenes import BoxScene
from lappet.reports.economy.files import write_economy
from lappet.reports.economy.instructions import callgrind_costs, count_instructions, isa_to_count, why_not
from lappet.reports.economy.measurement import AGREEMENT, absence, economy
from lappet.reports.economy.scenes import FEATURES, Feature, plain
from lappet.reports.report_files import head
from lappet.usd.stage import write_procedure
from small_procedure import small_procedure

CHECKOUT = Path(__file__).resolve().parents[2]
needs_valgrind = pytest.mark.skipif(why_not() is not None, reason=why_not() or "")

CALLGRIND = """# callgrind format
events: Ir
fn=(1) main
0 10
cfn=(2) lappet::find_equilibrium<float>(int)
calls=2 0
0 300
+3 5

fn=(2)
0 100
-1 20
cfn=(3) memset
calls=1 0
* 180
"""


def test_costs_of_callgrind_are_told_apart_into_those_of_a_function_and_those_inside_it() -> None:
    own, inside = callgrind_costs(CALLGRIND)
    assert own == {"main": 15, "lappet::find_equilibrium<float>(int)": 120}
    assert inside == {"lappet::find_equilibrium<float>(int)": 300, "memset": 180}


def solved(program: Program, frames: int = 1) -> tuple[LatticeCounts, list[SolvedFrame]]:
    """The lattice's counts, and the program's first frame solved so many times over, each from the one before."""
    with SolverClient() as client:
        client.open(replace(program.settings, threads=1), program.bones)
        lattice = client.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
        return lattice, [client.solve(program.frames[0]) for _ in range(frames)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "feature", [each for each in FEATURES if each.put_into is not None], ids=lambda each: each.name
)
def test_a_frame_whose_constraints_did_not_change_costs_one_residual(feature: Feature) -> None:
    assert feature.put_into is not None
    program = feature.put_into(plain() if feature.base is None else feature.base())
    _, (first, again) = solved(program, 2)
    assert first.converged
    assert first.diagnostics.pcg > 1
    work = again.diagnostics.work
    assert (work.evaluations, work.linearizations, work.products) == (1, 0, 0)
    assert pack((again.arrays(), again.state)) == pack((first.arrays(), first.state))


@pytest.mark.slow
def test_cells_that_cannot_move_are_not_in_the_system() -> None:
    # A bar of 16 x 1 x 1 cells, the surface of whose first half is fixed: that is, all its nodes are.
    h = 3.0
    motion = np.eye(4)
    motion[:2, 3] = (4.0, 1.0)
    stiff = MaterialParameters(prestretch=(1.1, 1.1), fiber_k1=5.0, fiber_k2=1.0)
    exact = {"precision": "double", "tolerance": 1e-7, "gap_tolerance": 1e-6}
    whole = BoxScene("whole", "", (16 * h, h, h), (16, 1, 1), fixed=(0,), gripped=(1,), motion=motion, material=stiff)
    half = replace(whole, size=(8 * h, h, h), divisions=(8, 1, 1))
    program = whole.program(h, **exact)
    surface = program.epochs[0].surface
    inside = (surface.points[surface.triangles][:, :, 0] < 8 * h + 1e-9).all(axis=1)
    program = replace(program, epochs=(replace(program.epochs[0], surface=replace(surface, fixed=inside)),))
    lattice, (found,) = solved(program)
    of_half, (expected,) = solved(half.program(h, **exact))
    assert (lattice.cells, of_half.cells) == (16, 8)
    assert lattice.blocks == of_half.blocks == 4
    beyond = surface.points[:, 0] > 8 * h - 1e-9
    rest = half.program(h).epochs[0].surface.points + np.array([8 * h, 0.0, 0.0])
    order = np.array([int(np.linalg.norm(rest - p, axis=1).argmin()) for p in surface.points[beyond]])
    moved = expected.points[order] + np.array([8 * h, 0.0, 0.0])
    assert np.abs(moved - surface.points[beyond]).max() > 3.0
    np.testing.assert_allclose(found.points[beyond], moved, atol=1e-4)
    # What does not move is as it was laid in: stretched by a tenth.
    np.testing.assert_allclose(found.strain[surface.points[:, 0] < 6 * h], 0.1, atol=1e-6)
    assert found.stress[surface.points[:, 0] < 6 * h].min() > 1.0


@pytest.mark.slow
def test_a_second_material_without_a_direction_takes_three_numbers_a_cell() -> None:
    lanes = {"scalar": 1, "sse42": 4, "avx2": 8, "avx512": 16, "neon": 4}
    two_materials = next(each for each in FEATURES if each.name == "heterogeneity")
    assert two_materials.put_into is not None
    bare, _ = solved(plain())
    mixed, _ = solved(two_materials.put_into(plain()))
    with SolverClient() as client:
        width = lanes[str(client.welcome["isa"])]
    # mu, lambda and mu01/mu10 as floats for each cell, and not once for all lanes.
    assert mixed.bytes - bare.bytes == 4 * 3 * (mixed.cells - width)


@pytest.mark.slow
def test_a_solve_without_strain_has_the_same_skin_and_no_strain(tmp_path: Path) -> None:
    procedure = tmp_path / "p.usda"
    write_procedure(small_procedure(end_time=5.0), procedure)
    stages = {}
    for option in ("--strain", "--no-strain"):
        cache = tmp_path / f"{option}.usdc"
        arguments = ["solve", str(procedure), "-o", str(cache), "--store", str(tmp_path / option), option]
        done = CliRunner().invoke(cli, [*arguments, "--no-error-estimate"])
        assert done.exit_code == 0, done.output
        stages[option] = Usd.Stage.Open(str(cache))
    skins = [UsdGeom.Mesh(stage.GetPrimAtPath("/Procedure/Skin/epoch_01")) for stage in stages.values()]
    points = [np.asarray(skin.GetPointsAttr().Get(5.0)) for skin in skins]
    np.testing.assert_array_equal(*points)
    for skin, there in zip(skins, (True, False), strict=True):
        assert [skin.GetPrim().HasAttribute(f"primvars:{name}") for name in SCALARS] == [there] * 3


# --- instructions --------------------------------------------------------------------------------------------------


@pytest.mark.slow
@needs_valgrind
def test_counts_of_instructions_repeat_and_are_those_of_the_passes_that_the_header_tells() -> None:
    first, again = count_instructions(plain()), count_instructions(plain())
    assert first.frame == pytest.approx(again.frame, rel=1e-3)
    assert 0 < sum(first.kernels.values()) < first.search < first.frame
    cells = 256
    product = first.kernels["product"] / first.work["products"] / cells
    # A product has some 500 operations a cell and sends 8 cells through an instruction of AVX2, 4 through one of SSE.
    assert 40.0 < product < 400.0


@pytest.mark.slow
@needs_valgrind
def test_the_report_of_economy_has_a_row_with_and_without_each_feature(tmp_path: Path) -> None:
    chosen = tuple(each for each in FEATURES if each.name in ("fibers", "landmarks", "strain", "region", "followers"))
    report = economy(features=chosen)
    files = write_economy(tmp_path, head(), report)
    assert [file.name for file in files] == ["economy.json", "economy.csv", "economy.md"]
    values = json.loads(files[0].read_text())
    assert {"machine", "compiler", "isa", "threads", "revision", "rows"} <= set(values)
    rows = {(row["feature"], row["present"]): row for row in values["rows"]}
    assert set(rows) == {(each.name, on) for each in chosen for on in (False, True)} - {("followers", True)}
    for row in rows.values():
        assert {"feature", "present", "seconds", "instructions", "bytes"} <= set(row)
        assert row["seconds"] > 0
        assert row["bytes"] > 10_000
        assert row["instructions"] > 1_000_000
    fibers = rows["fibers", True], rows["fibers", False]
    assert fibers[0]["product_per_cell"] > 1.05 * fibers[1]["product_per_cell"]
    assert fibers[0]["bytes"] > fibers[1]["bytes"]
    assert rows["region", True]["instructions"] < 0.9 * rows["region", False]["instructions"]
    # What is done once a frame is seen there, and not in the search.
    for name in ("landmarks", "strain"):
        with_it, without = rows[name, True], rows[name, False]
        assert with_it["instructions"] > without["instructions"] + 1000
        assert with_it["search_instructions"] == pytest.approx(without["search_instructions"], rel=AGREEMENT)
    assert "| fibers |" in files[2].read_text()


# As solverd/cmake/Yardsticks.cmake builds them.
LEFT_OUT = {
    "plain": "contact;fibers;muscle;prestretch;heterogeneity;mesh_cells;landmarks;error_estimate;strain",
    "fibers": "contact;muscle;prestretch;heterogeneity;mesh_cells",
}


@pytest.mark.slow
@pytest.mark.timeout(3000)
@needs_valgrind
def test_a_plain_scene_takes_the_instructions_of_a_daemon_built_without_any_feature() -> None:
    found = absence(plain(), "the plain bar", yardstick("plain"), LEFT_OUT["plain"])
    assert abs(found.share) <= AGREEMENT, found
    for kernel in ("evaluate", "product"):
        here, there = found.kernels[kernel]
        assert here == pytest.approx(there, rel=AGREEMENT), kernel
    # Were a feature looked at in every cell, it would show: fibers cost a tenth of a product.
    with_fibers = next(each for each in FEATURES if each.name == "fibers")
    assert with_fibers.put_into is not None
    assert count_instructions(with_fibers.put_into(plain())).search > (1.0 + AGREEMENT) * found.instructions


@pytest.mark.slow
@pytest.mark.timeout(3000)
@needs_valgrind
def test_fibers_without_muscle_take_the_instructions_of_a_daemon_built_without_muscle() -> None:
    with_fibers = next(each for each in FEATURES if each.name == "fibers")
    assert with_fibers.put_into is not None
    scene = with_fibers.put_into(plain())
    found = absence(scene, "the bar with fibers", yardstick("fibers"), LEFT_OUT["fibers"])
    assert abs(found.share) <= AGREEMENT, found


@pytest.mark.slow
@pytest.mark.timeout(3000)
@pytest.mark.parametrize(
    "feature",
    [each for each in FEATURES if each.put_into is not None and each.base is None],
    ids=lambda each: each.name,
)
def test_a_daemon_built_without_a_feature_refuses_a_scene_that_needs_it(feature: Feature) -> None:
    assert feature.put_into is not None
    program = feature.put_into(plain())

    def ask(client: SolverClient) -> None:
        client.open(program.settings, program.bones)
        client.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])

    with (
        SolverDaemon(yardstick("plain")) as daemon,
        SolverClient(daemon.address, daemon.token) as client,
        pytest.raises(SolverRefused, match="was built without"),
    ):
        ask(client)


def yardstick(name: str) -> Path:
    """A daemon without some features, of the objects of the whole one but for those that read what is left out."""
    if shutil.which("cmake") is None or not (CHECKOUT / "build" / "build.ninja").is_file():
        pytest.skip("the daemon is not built in the checkout, so no yardstick can be")
    if platform.machine() in ("x86_64", "AMD64") and isa_to_count() != "avx2":
        pytest.skip("the yardsticks' kernels are those of AVX2, which this processor or LAPPET_ISA does without")
    program = f"lappet-solverd-{name}"
    done = subprocess.run(
        ["cmake", "--build", str(CHECKOUT / "build"), "--target", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return CHECKOUT / "build" / "solverd" / program
