"""The daemons that packaging/cross compiles: they solve as the checkout's does, some under wine and qemu."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cross_wheel
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.usd.stage import pxr

ROOT = Path(__file__).resolve().parents[2]
CROSS = ROOT / "packaging" / "cross"
# What runs the daemon of a target on Linux of x86-64: a program that must be installed, and the one to start.
RUNNERS = {
    "linux-arm64": ("qemu-aarch64", CROSS / "qemu_solverd.sh"),
    "linux-x64": ("true", cross_wheel.programs("linux-x64")[0]),
    "windows-x64": ("wine", CROSS / "wine_solverd.sh"),
}
# Few frames of a coarse lattice: the wound is cut, the flaps are undermined and the hooks begin to pull.
SETTINGS = ("--spacing", "4", "--frames", "1:12", "--no-error-estimate")
# mm. Windows has the compiler of the checkout and the same instruction sets. Another compiler contracts and reorders
# sums in another way, as does another instruction set: a frame then ends elsewhere within the solver's tolerance.
MAX_DIFFERENCES = {"windows-x64": 1e-4, "linux-x64": 0.02, "linux-arm64": 0.02}

# Suites of the daemon's unit tests that end within ten seconds under qemu.
QUICK_ON_ARM = (
    "AugmentedLagrangian BlockLayout BoneBodies BoneDistance ByLittle/BoxesInEachOther CellMaterials "
    "CoarseProduct Decode DecodeLoads DisplacementLimits Embedding Encode FacePieces Fiber FiberFamilies "
    "GateAddress GateTest KeysFolderTest LeaveSaddle Loopback MaterialModels MaterialStates Materials/0 "
    "Materials/1 Materials/2 Materials/3 Message MooneyRivlin Muscle NeoHookean Nonmanifold Platform Prestretch "
    "RandomCuts/CutLattices ResidualClusters RetrySchedule RigidMotion Roles SeriesEstimate ServerOptions "
    "SessionLimits Sewn StateTransfer Strands Svd3 SymmetricEigen3 Thread TissueSamples TokenBucket Untangling "
    "VoxelTree Voxelize WallEnds Weight"
)

pytestmark = pytest.mark.slow


def runner(target: str) -> Path:
    """The program that runs the daemon of a target; skips the test, loudly, where there is none."""
    needed, program = RUNNERS[target]
    if not cross_wheel.programs(target)[0].is_file():
        pytest.skip(f"THE DAEMON FOR {target} IS NOT TESTED: run packaging/cross/build.sh {target}")
    if shutil.which(needed) is None:
        pytest.skip(f"THE DAEMON FOR {target} IS NOT TESTED: {needed} is not installed, which runs it here")
    return program


def run_for_windows(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """The program under wine, with its standard input open as long as it runs."""
    runner("windows-x64")
    wine = {"WINEPREFIX": str(cross_wheel.WORK / "wine"), "WINEDEBUG": "-all"}
    with subprocess.Popen(["sleep", "100"], stdout=subprocess.PIPE) as input_end:
        try:
            return subprocess.run(
                ["wine", str(cross_wheel.programs("windows-x64")[0]), *arguments],
                stdin=input_end.stdout,
                capture_output=True,
                text=True,
                check=False,
                timeout=90,
                env={**os.environ, **wine, **environment},
            )
        finally:
            input_end.kill()


def solved(daemon: Path, folder: Path) -> dict[tuple[str, float], np.ndarray]:
    """The points of the Z-plasty's first frames, by their mesh and time."""
    cache = folder / "z.usdc"
    command = [sys.executable, "-m", "lappet", "solve", str(ROOT / "examples" / "z_plasty" / "z_plasty.usda")]
    done = subprocess.run(
        [*command, *SETTINGS, "--store", str(folder / "store"), "-o", str(cache)],
        capture_output=True,
        text=True,
        check=False,
        timeout=550,
        env={**os.environ, "LAPPET_SOLVERD": str(daemon)},
    )
    assert done.returncode == 0, done.stderr
    usd = pxr()
    stage = usd.Usd.Stage.Open(str(cache))
    points: dict[tuple[str, float], np.ndarray] = {}
    for prim in stage.Traverse():
        if prim.IsA(usd.UsdGeom.PointBased):
            attribute = usd.UsdGeom.PointBased(prim).GetPointsAttr()
            for time in attribute.GetTimeSamples():
                points[str(prim.GetPath()), time] = np.asarray(attribute.Get(time), dtype=float)
    return points


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, float], np.ndarray]:
    """What the checkout's daemon solves."""
    return solved(find_daemon(), tmp_path_factory.mktemp("checkout"))


@pytest.mark.timeout(600)
@pytest.mark.parametrize("target", sorted(RUNNERS))
def test_it_solves_the_z_plasty_as_the_daemon_of_the_checkout_does(
    target: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    program = runner(target)
    expected = request.getfixturevalue("expected")
    found = solved(program, tmp_path)
    assert {time for _, time in expected} == set(range(1, 13))
    assert found.keys() == expected.keys()
    skin = max((key for key in expected if key[1] == 12.0), key=lambda key: len(expected[key]))
    first = next(key for key in sorted(expected, key=lambda key: key[1]) if key[0] == skin[0])
    assert np.abs(expected[skin] - expected[first]).max() > 1.0, "nothing moved, so equal frames say nothing"
    difference = max(np.abs(found[key] - expected[key]).max() for key in expected)
    print(f"{target}: the frames differ by at most {difference:.2g} mm")
    assert difference <= MAX_DIFFERENCES[target]


@pytest.mark.timeout(600)
def test_its_quick_unit_tests_pass_on_arm() -> None:
    tests = cross_wheel.WORK / "linux-arm64" / "daemon" / "solverd" / "solverd_tests"
    if not tests.is_file() or shutil.which("qemu-aarch64") is None:
        pytest.skip("UNIT TESTS ARE NOT RUN ON ARM: run packaging/cross/build.sh linux-arm64 --tests, with qemu-user")
    suites = ":".join(f"{name}.*" for name in QUICK_ON_ARM.split())
    done = subprocess.run(
        ["qemu-aarch64", "-cpu", "cortex-a72", "-L", "/usr/aarch64-linux-gnu", str(tests), f"--gtest_filter={suites}"],
        capture_output=True,
        text=True,
        check=False,
        timeout=550,
        env={**os.environ, "OPENBLAS_CORETYPE": "ARMV8", "LD_LIBRARY_PATH": str(tests.parents[2] / "bin")},
    )
    assert done.returncode == 0, done.stdout[-4000:]
    assert "[  PASSED  ]" in done.stdout


@pytest.mark.parametrize("target", sorted(RUNNERS))
def test_it_listens_privately_and_ends_when_its_input_closes(target: str) -> None:
    daemon = SolverDaemon(runner(target), start_timeout=60.0)
    with daemon:
        assert daemon.address.startswith("tcp://127.0.0.1:" if target == "windows-x64" else "ipc:///")
        assert daemon.alive()
        process = daemon._process
        assert process is not None
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(timeout=20.0) == 0


def test_the_one_for_windows_ends_with_its_parent() -> None:
    done = run_for_windows("--parent", "999996", LAPPET_TOKEN="secret")
    assert done.returncode == 0
    assert "its parent process 999996 ended" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--keys", "anywhere"), "The daemon for Windows serves its own user only; leave out --keys"),
        (("--address", "ipc:///anywhere/socket"), "only loopback is served"),
    ],
)
def test_the_one_for_windows_refuses_what_windows_does_not_have_in_a_sentence(
    arguments: tuple[str, ...], words: str
) -> None:
    done = run_for_windows(*arguments, LAPPET_TOKEN="secret")
    assert done.returncode == 1
    assert words in done.stderr
