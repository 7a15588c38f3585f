"""The set-up installs what is named, names what it installs, and the wheel carries the daemon."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import click
import pytest

import lappet_wheel
from requirements import INSTALLERS, extras, requirements

ROOT = Path(__file__).resolve().parents[2]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def system_packages() -> list[str]:
    lines = (ROOT / "packaging/system_packages.txt").read_text(encoding="utf-8").splitlines()
    return [name for line in lines if (name := line.partition("#")[0].strip())]


def distribution(requirement: str) -> str:
    match = re.match(r"[A-Za-z0-9._-]+", requirement)
    assert match, requirement
    return match.group(0)


def test_every_dependency_has_its_licence_named() -> None:
    named = re.findall(r"^\| ([\w.+-]+)", (ROOT / "packaging/licenses.md").read_text(encoding="utf-8"), re.MULTILINE)
    needed = [
        *system_packages(),
        *map(distribution, requirements(extras())),
        *INSTALLERS,
    ]
    assert sorted(set(needed) - set(named)) == []


def test_no_system_package_is_named_twice() -> None:
    packages = system_packages()
    assert len(packages) == len(set(packages))


def test_an_unknown_extra_is_refused_by_name() -> None:
    known = "compress, dev, docs, examples, film, plates, render, report, test"
    with pytest.raises(ValueError, match=f"no extra 'rendr'; it has {known}"):
        requirements(["rendr"])


def test_the_set_up_refuses_an_unknown_argument() -> None:
    done = subprocess.run(
        ["bash", str(ROOT / "packaging/setup.sh"), "--all"], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1
    assert "unknown argument '--all'" in done.stderr


@pytest.mark.parametrize("name", [".venv", "build"])
def test_the_set_up_installs_nothing_into_another_checkout_through_a_link(name: str, tmp_path: Path) -> None:
    other = tmp_path / "other" / name
    here = tmp_path / "here"
    for folder in (other, here / "packaging"):
        folder.mkdir(parents=True)
    shutil.copy(ROOT / "packaging" / "setup.sh", here / "packaging")
    (here / name).symlink_to(other, target_is_directory=True)
    done = subprocess.run(
        ["bash", str(here / "packaging/setup.sh")], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1
    assert f"{here / name} is a link to {other}." in done.stderr
    assert f"rm {name}" in done.stderr
    assert not list(other.iterdir())


def test_missing_packages_without_root_or_sudo_are_a_sentence(tmp_path: Path) -> None:
    """A copy of the script sees a Debian on which nothing is installed, as a user, with no sudo."""
    (tmp_path / "packaging").mkdir()
    for name in ("setup.sh", "system_packages.txt"):
        shutil.copy(ROOT / "packaging" / name, tmp_path / "packaging" / name)
    tools = tmp_path / "tools"
    tools.mkdir()
    for tool in ("bash", "comm", "dirname", "sed", "sort"):
        found = shutil.which(tool)
        assert found is not None
        (tools / tool).symlink_to(found)
    for tool, text in (("dpkg-query", "exit 1"), ("apt-get", "exit 99"), ("id", "echo 1000")):
        (tools / tool).write_text(f"#!{tools}/bash\n{text}\n")
        (tools / tool).chmod(0o755)
    done = subprocess.run(
        [str(tools / "bash"), str(tmp_path / "packaging/setup.sh")],
        env={"PATH": str(tools)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 1
    assert f"Debian packages are missing ({len(system_packages())})" in done.stderr
    assert "neither root nor sudo" in done.stderr
    assert "apt-get install --no-install-recommends " in done.stderr
    assert " cppzmq-dev " in done.stderr


def test_a_daemon_that_does_not_compile_leaves_the_program_of_lessons_made(tmp_path: Path) -> None:
    """A copy of the script runs a Python that only writes down its commands, and a CMake that fails."""
    (tmp_path / "packaging").mkdir()
    shutil.copy(ROOT / "packaging" / "setup.sh", tmp_path / "packaging")
    for name in ("pyproject.toml", "packaging/lock.txt"):
        (tmp_path / name).write_text("")
    ran = tmp_path / "ran"
    tools = tmp_path / "tools"
    for folder in (tools, tmp_path / ".venv" / "bin"):
        folder.mkdir(parents=True)
    for tool in ("bash", "cat", "cut", "dirname", "grep", "sha256sum"):
        found = shutil.which(tool)
        assert found is not None
        (tools / tool).symlink_to(found)
    for program, status in ((tmp_path / ".venv/bin/python", 0), (tools / "cmake", 1)):
        program.write_text(f'#!{tools}/bash\necho "{program.name} $*" >>"{ran}"\nexit {status}\n')
        program.chmod(0o755)
    command = [str(tools / "bash"), str(tmp_path / "packaging/setup.sh")]
    done = subprocess.run(command, env={"PATH": str(tools)}, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert "could not configure the daemon" in done.stderr
    first, last = ran.read_text().splitlines()[-2:]
    assert first == "python packaging/viewer.py"
    assert last.startswith("cmake ")


def test_make_alone_lists_the_commands() -> None:
    done = subprocess.run(["make", "--no-print-directory"], cwd=ROOT, capture_output=True, text=True, check=True)
    listed = re.findall(r"^make (\w+) +\w", done.stdout, re.MULTILINE)
    assert {"demo", "test", "lint", "bench", "clean", "docs", "site", "setup", "daemon", "help"} <= set(listed)


@pytest.mark.slow
def test_setting_up_again_installs_nothing() -> None:
    done = subprocess.run(
        ["bash", "packaging/setup.sh", "--tests"], cwd=ROOT, capture_output=True, text=True, check=False, timeout=280
    )
    assert done.returncode == 0, done.stdout + done.stderr
    said = [line for line in done.stdout.splitlines() if line.startswith("setup: ")]
    assert said == ["setup: ready: .venv/bin/lappet and build/solverd/lappet-solverd"]


@pytest.mark.slow
def test_the_daemon_carries_the_version_of_the_project() -> None:
    daemon = ROOT / "build/solverd/lappet-solverd"
    printed = subprocess.run([daemon, "--version"], capture_output=True, text=True, check=True, timeout=60).stdout
    assert PYPROJECT["project"]["version"] in printed


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_wheel_installed_elsewhere_brings_the_command_and_its_daemon(tmp_path: Path) -> None:
    """Build the wheel from a copy without build products, install it in an environment of its own, run both."""
    wheel = lappet_wheel.built()
    names = zipfile.ZipFile(wheel).namelist()
    own = ("lappet/commands/cli.py", "lappet/viewer/lesson.js", "lappet_blender/figure/__main__.py")
    assert {"lappet/bin/lappet-solverd", *own} <= set(names)
    assert any(name.startswith("lappet/usd/schema/") for name in names)

    environment = tmp_path / "environment"
    venv.create(environment, with_pip=False)
    python = environment / "bin" / "python"
    subprocess.run(
        [sys.executable, "-m", "pip", f"--python={python}", "install", "--quiet", "--no-deps", str(wheel)], check=True
    )
    # The dependencies come from the environment of the tests; its own lappet must not be seen through that path.
    site = Path(click.__file__).parent.parent
    runner = f"import lappet, sys; sys.path.append({str(site)!r}); "
    version = subprocess.run(
        [python, "-I", "-c", runner + "from lappet.commands.cli import cli; cli(['--help'])"],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert version.returncode == 0, version.stderr
    assert "solve" in version.stdout
    found = subprocess.run(
        [python, "-I", "-c", runner + "from lappet.daemon import find_daemon; print(find_daemon())"],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert found.returncode == 0, found.stderr
    daemon = Path(found.stdout.strip())
    assert daemon.is_relative_to(environment)
    help_text = subprocess.run([daemon, "--help"], capture_output=True, text=True, check=True, timeout=60).stdout
    assert "--parent" in help_text
