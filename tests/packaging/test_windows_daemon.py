"""The daemon for Windows under wine: it starts, ends and refuses as it should, and solves what that for Linux does."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from test_sbom import check_schema

import sbom
import windows_wheel
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.usd.stage import pxr

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = windows_wheel.WORK / "bin" / windows_wheel.PROGRAM
WRAPPER = ROOT / "packaging" / "windows" / "wine_solverd.sh"
WINE = shutil.which("wine")
# Few frames of a coarse lattice: the wound is cut, the flaps are undermined and the hooks begin to pull.
SETTINGS = ("--spacing", "4", "--frames", "1:12", "--no-error-estimate")
MAX_DIFFERENCE = 1e-4  # mm

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not PROGRAM.is_file() or WINE is None,
        reason="THE DAEMON FOR WINDOWS IS NOT TESTED: run packaging/windows/cross_build.sh, which also installs wine",
    ),
]


def run_program(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """The program under wine, with its standard input open as long as it runs."""
    wine = {"WINEPREFIX": str(windows_wheel.WORK / "wine"), "WINEDEBUG": "-all"}
    with subprocess.Popen(["sleep", "100"], stdout=subprocess.PIPE) as input_end:
        try:
            return subprocess.run(
                [str(WINE), str(PROGRAM), *arguments],
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
        timeout=300,
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


def test_it_solves_the_z_plasty_as_the_daemon_for_linux_does(tmp_path: Path) -> None:
    (tmp_path / "linux").mkdir()
    (tmp_path / "windows").mkdir()
    expected = solved(find_daemon(), tmp_path / "linux")
    found = solved(WRAPPER, tmp_path / "windows")
    assert {time for _, time in expected} == set(range(1, 13))
    assert found.keys() == expected.keys()
    skin = max((key for key in expected if key[1] == 12.0), key=lambda key: len(expected[key]))
    first = next(key for key in sorted(expected, key=lambda key: key[1]) if key[0] == skin[0])
    assert np.abs(expected[skin] - expected[first]).max() > 1.0, "nothing moved, so equal frames say nothing"
    assert max(np.abs(found[key] - expected[key]).max() for key in expected) <= MAX_DIFFERENCE


def test_it_listens_on_loopback_and_ends_when_its_input_closes() -> None:
    daemon = SolverDaemon(WRAPPER, start_timeout=60.0)
    with daemon:
        assert daemon.address.startswith("tcp://127.0.0.1:")
        assert daemon.alive()
        process = daemon._process
        assert process is not None
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(timeout=20.0) == 0


def test_it_ends_with_its_parent() -> None:
    done = run_program("--parent", "999996", LAPPET_TOKEN="secret")
    assert done.returncode == 0
    assert "its parent process 999996 ended" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--keys", "anywhere"), "The daemon for Windows serves its own user only; leave out --keys"),
        (("--address", "ipc:///anywhere/socket"), "only loopback is served"),
    ],
)
def test_it_refuses_what_windows_does_not_have_in_a_sentence(arguments: tuple[str, ...], words: str) -> None:
    done = run_program(*arguments, LAPPET_TOKEN="secret")
    assert done.returncode == 1
    assert words in done.stderr


def test_its_wheel_has_the_program_with_its_library_and_the_licenses_of_all_of_it(tmp_path: Path) -> None:
    wheel = windows_wheel.made(tmp_path)
    assert wheel.name.endswith(f"-{windows_wheel.TAG}.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        (bill_name,) = (name for name in names if name.endswith(f"sboms/{sbom.NAME}"))
        bill = json.loads(archive.read(bill_name))
        (tags,) = (archive.read(name).decode() for name in names if name.endswith(".dist-info/WHEEL"))
        programs = {name for name in names if archive.read(name)[:2] == b"MZ"}
    assert programs == {f"lappet/bin/{windows_wheel.PROGRAM}", f"lappet/bin/{windows_wheel.BLAS}"}
    assert {"lappet/demo/z_plasty.usda", "lappet/viewer/lesson.js"} <= names
    assert "Root-Is-Purelib: false" in tags
    assert tags.count("Tag:") == 1
    check_schema(bill)
    texts = {Path(name).stem for name in names if "/licenses/libraries/" in name}
    assert {one.name for one in windows_wheel.linked()} <= texts
