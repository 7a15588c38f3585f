"""What a scene does not need is not loaded, and starting costs little.

Where other work slows the machine down the processor's time counts, and not the clock.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lappet.procedure import Hook, Procedure
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import write_procedure

HELP_SECONDS, SOLVE_SECONDS = 0.3, 1.5
TRIES = 3
# A slower machine is told by what loading the libraries of a solve takes on it, and may take so many times that.
LIBRARIES, TIMES_LIBRARIES = "import msgpack, numpy, zmq; from pxr import Usd, UsdGeom", 6.0

# Of things that a plain solve does without: pictures, meshes from files, Blender, plots, the design of flaps.
ABSENT = {"bpy", "matplotlib", "trimesh", "networkx", "scipy", "PIL", "rich"}
ABSENT_PARTS = {
    "lappet.solve.error_estimate", "lappet.tissue.mesh_repair", "lappet.tissue.tissue_from_mesh",
    "lappet.output.render",
    "lappet.designs.transposition",
    "lappet.background", "lappet.bench", "lappet.reports.economy.measurement", "lappet.reports.error_time.measurement",
}  # fmt: skip


@pytest.fixture
def smallest(tmp_path: Path) -> Path:
    """Sixteen cells, one hook, two frames, no cut."""
    tissue = flat_patch((8.0, 8.0, 2.0), resolution=4.0, spacing=2.0)
    hook = Hook("hook", (0.0, 0.0, 2.0), ((1.0, (0.0, 0.0, 2.0)), (2.0, (0.0, 0.0, 2.5))), 1.0, 3.0)
    path = tmp_path / "smallest.usda"
    write_procedure(Procedure(tissue, events=(hook,), start_time=1.0, end_time=2.0), path)
    return path


def seconds_of(command: list[str]) -> float:
    """The lesser of wall and processor seconds that a command takes with all it starts."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return min(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def test_help_is_there_in_less_than_a_third_of_a_second() -> None:
    command = [sys.executable, "-m", "lappet", "--help"]
    assert min(seconds_of(command) for _ in range(TRIES)) < HELP_SECONDS


@pytest.mark.slow
def test_the_smallest_scene_is_solved_from_shell_to_cache_in_a_second_and_a_half(
    smallest: Path, tmp_path: Path
) -> None:
    cache = tmp_path / "smallest.usdc"
    command = [sys.executable, "-m", "lappet", "solve", str(smallest), "-o", str(cache), "--store"]
    # A store of its own each time: nothing is looked up.
    found = min(seconds_of([*command, str(tmp_path / f"store{k}")]) for k in range(TRIES))
    if found >= SOLVE_SECONDS:
        assert found < TIMES_LIBRARIES * min(seconds_of([sys.executable, "-c", LIBRARIES]) for _ in range(TRIES))
    assert cache.is_file()


@pytest.mark.slow
def test_a_plain_solve_loads_nothing_of_what_it_does_without(smallest: Path, tmp_path: Path) -> None:
    program = (
        "import sys\n"
        "from lappet.commands.cli import cli\n"
        f"cli(['solve', {str(smallest)!r}, '-o', {str(tmp_path / 'c.usdc')!r}, '--store', {str(tmp_path / 's')!r},"
        " '--no-error-estimate'], standalone_mode=False)\n"
        "print('\\n'.join(sys.modules))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=120)
    loaded = set(done.stdout.split())
    assert "lappet.solve" in loaded
    assert {name.partition(".")[0] for name in loaded} & ABSENT == set()
    assert loaded & ABSENT_PARTS == set()
    assert (tmp_path / "c.usdc").is_file()
