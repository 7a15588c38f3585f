"""Only files whose hashes packaging/lock.txt has are installed, and it has what pyproject.toml asks for."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import lock
import locked
import pypi_wheels
from locked import Locked, canonical
from requirements import INSTALLERS, PYPROJECT, everything

ROOT = Path(__file__).resolve().parents[2]
PAGE = "<!DOCTYPE html><html><body>{}</body></html>"


def wheel(folder: Path, name: str = "incision", version: str = "1.0", text: str = "") -> Path:
    """A wheel of one module, as pip installs it."""
    tree = folder / f"tree-{name}-{version}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    files = {
        f"{name}.py": text,
        f"{name}-{version}.dist-info/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{name}-{version}.dist-info/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    for path, content in files.items():
        (tree / path).parent.mkdir(parents=True, exist_ok=True)
        (tree / path).write_text(content)
    folder.mkdir(exist_ok=True)
    subprocess.run(
        [sys.executable, "-m", "wheel", "pack", "--dest-dir", str(folder), str(tree)], check=True, capture_output=True
    )
    return folder / f"{name}-{version}-py3-none-any.whl"


def sha256(path: Path) -> str:
    return f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}"


def pip_installs(requirements: str, wheels: Path, into: Path) -> subprocess.CompletedProcess[str]:
    """As packaging/setup.sh does, but from a folder of wheels into a folder."""
    into.mkdir()
    (into / "requirements.txt").write_text(requirements)
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input", "install", "--no-deps"]
    command += ["--no-build-isolation", "--no-index", f"--find-links={wheels}", f"--target={into}"]
    return subprocess.run(
        [*command, "--requirement", str(into / "requirements.txt")],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


# --- a file that is not the locked one -----------------------------------------------------------------------------


def test_a_wheel_with_the_locked_hash_is_installed_and_one_that_was_changed_is_not(tmp_path: Path) -> None:
    made = wheel(tmp_path / "wheels", text="answer = 1")
    requirements = locked.entries([Locked("incision", "1.0", (sha256(made),))])
    done = pip_installs(requirements, made.parent, tmp_path / "good")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "good" / "incision.py").read_text() == "answer = 1"

    made.unlink()
    changed = wheel(tmp_path / "wheels", text="answer = 2")
    assert changed == made
    done = pip_installs(requirements, made.parent, tmp_path / "bad")
    assert done.returncode != 0
    assert "HASH" in done.stderr.upper()
    assert not (tmp_path / "bad" / "incision.py").exists()


def test_a_wheel_without_any_hash_is_not_installed(tmp_path: Path) -> None:
    made = wheel(tmp_path / "wheels")
    done = pip_installs(locked.entries([]) + "incision==1.0\n", made.parent, tmp_path / "into")
    assert done.returncode != 0
    assert not (tmp_path / "into" / "incision.py").exists()


def test_a_wheel_in_the_cache_of_the_extension_that_was_changed_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """pip looks into a folder here, not into the package index."""
    served = wheel(tmp_path / "served", text="answer = 1")
    package = Locked("incision", "1.0", (sha256(served),))
    monkeypatch.setattr(pypi_wheels, "locked", lambda name: package)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(served.parent))
    (kept,) = pypi_wheels.download("incision", ["3.11"], "linux-x64", tmp_path / "cache")
    assert sha256(kept) == sha256(served)

    wrong = wheel(tmp_path / "wrong", text="answer = 2").read_bytes()
    kept.write_bytes(wrong)
    (again,) = pypi_wheels.download("incision", ["3.11"], "linux-x64", tmp_path / "cache")
    assert sha256(again) == sha256(served)

    kept.write_bytes(wrong)
    served.write_bytes(wrong)
    with pytest.raises(LookupError, match=r"no wheel of incision 1\.0 with a hash of packaging/lock\.txt"):
        pypi_wheels.download("incision", ["3.11"], "linux-x64", tmp_path / "cache")


def test_what_is_there_is_not_downloaded_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    served = wheel(tmp_path / "served")
    package = Locked("incision", "1.0", (sha256(served),))
    monkeypatch.setattr(pypi_wheels, "locked", lambda name: package)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(served.parent))
    pypi_wheels.download("incision", ["3.11"], "linux-x64", tmp_path / "cache")
    served.unlink()
    assert len(pypi_wheels.download("incision", ["3.11"], "linux-x64", tmp_path / "cache")) == 1


# --- the lock and the project --------------------------------------------------------------------------------------


def test_the_lock_has_a_version_that_every_requirement_of_the_project_allows() -> None:
    packages = locked.read()
    wanted = [Requirement(one) for one in everything()]
    assert {canonical(one.name) for one in wanted} - packages.keys() == set()
    refused = [str(one) for one in wanted if not one.specifier.contains(packages[canonical(one.name)].version)]
    assert refused == []


def test_the_lock_has_what_the_installed_packages_ask_for_and_nothing_else() -> None:
    """Their own metadata says what they ask for. Fails too where .venv is not what the lock says: run `make setup`."""
    assert lock.closure(everything(), {}) == {one.name: one.version for one in locked.read().values()}


def test_every_package_of_the_lock_has_hashes_of_its_files_and_two_are_built_from_sources() -> None:
    packages = locked.read()
    assert len(packages) > 90
    for package in packages.values():
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", one) for one in package.hashes), package.name
        assert package.hashes, package.name
    assert [one.name for one in packages.values() if one.from_source] == ["docopt", "meshoptimizer"]
    for name in pypi_wheels.BUNDLED:
        platforms = 1 if name == "platformdirs" else len(pypi_wheels.PLATFORMS)
        assert len(packages[name].hashes) >= platforms, name


@pytest.mark.slow
def test_what_has_no_wheel_builds_where_only_the_installers_of_the_set_up_are(tmp_path: Path) -> None:
    """As on a new machine: what the sources import while they build has to be there before the other packages are."""
    setup = (ROOT / "packaging/setup.sh").read_text(encoding="utf-8")
    (listed,) = re.findall(r"^installers=\((.*)\)$", setup, re.MULTILINE)
    packages = locked.read()
    sources = [one.name for one in packages.values() if one.from_source]
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "venv")], check=True)
    pip = [str(tmp_path / "venv" / "bin" / "python"), "-m", "pip", "--quiet", "--no-input"]
    for command, names in (
        (["install"], listed.split()),
        (["wheel", "--no-cache-dir", f"--wheel-dir={tmp_path}"], sources),
    ):
        wanted = tmp_path / "wanted.txt"
        wanted.write_text(locked.entries(packages[name] for name in names), encoding="utf-8")
        subprocess.run([*pip, *command, "--no-deps", "--no-build-isolation", f"--requirement={wanted}"], check=True)
    assert len(list(tmp_path.glob("*.whl"))) == len(sources)


def test_the_older_blender_of_the_tests_has_hashes_too() -> None:
    (blender,) = locked.read(locked.LOCK.with_name("blender_4_5.txt")).values()
    assert (blender.name, blender.version.rpartition(".")[0]) == ("bpy", "4.5")
    assert blender.hashes


def test_what_builds_the_wheel_has_one_version_only() -> None:
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))
    for one in project["build-system"]["requires"]:
        requirement = Requirement(one)
        assert str(requirement.specifier) == f"=={locked.locked(requirement.name).version}"
    assert set(INSTALLERS) <= locked.read().keys()


def test_what_is_written_is_what_is_read(tmp_path: Path) -> None:
    packages = [Locked("a", "1.0", ("sha256:12", "sha256:34")), Locked("b-c", "2", ("sha256:56",), from_source=True)]
    (tmp_path / "lock.txt").write_text(lock.HEAD + locked.entries(packages))
    assert list(locked.read(tmp_path / "lock.txt").values()) == packages


@pytest.mark.parametrize("line", ["a==1.0", "a>=1 \\\n    --hash=sha256:12", "--index-url=elsewhere", "./a.whl"])
def test_a_line_without_version_or_hash_is_refused(tmp_path: Path, line: str) -> None:
    (tmp_path / "lock.txt").write_text(locked.entries([Locked("z", "1", ("sha256:12",))]) + line + "\n")
    with pytest.raises(ValueError, match="a line without a version or a hash"):
        locked.read(tmp_path / "lock.txt")


def test_a_package_twice_is_refused(tmp_path: Path) -> None:
    one = Locked("z", "1", ("sha256:12",))
    (tmp_path / "lock.txt").write_text(locked.entries([one, one]))
    with pytest.raises(ValueError, match="has z twice"):
        locked.read(tmp_path / "lock.txt")


def test_a_package_that_is_not_locked_is_named_with_the_remedy() -> None:
    with pytest.raises(LookupError, match=r"has no leftpad; add it to pyproject\.toml and run packaging/lock\.py"):
        locked.locked("leftpad")


# --- making it -----------------------------------------------------------------------------------------------------


def index_page(folder: Path, files: dict[str, str]) -> None:
    """A page as pip reads it: names of files and what their links have besides, with a hash for each."""
    links = [
        f'<a href="{name}#sha256={hashlib.sha256(name.encode()).hexdigest()}" {more}>{name}</a>'
        for name, more in files.items()
    ]
    (folder / "page.html").write_text(PAGE.format("\n".join(links)))


FILES = (
    "incision-1.0-cp311-cp311-manylinux_2_17_x86_64.whl",
    "incision-1.0-cp311-cp311-manylinux_2_34_x86_64.whl",
    "incision-1.0-cp311-cp311-manylinux_2_39_x86_64.whl",
    "incision-1.0-cp313-cp313-win_amd64.whl",
    "incision-1.0.tar.gz",
    "incision-2.0-cp311-cp311-manylinux_2_17_x86_64.whl",
)


@pytest.mark.parametrize(
    ("platforms", "python", "chosen"),
    [
        (lock.tags("linux-x64"), "3.11", FILES[1]),  # Debian 12's C library is 2.36
        (list(pypi_wheels.PLATFORMS["linux-x64"]), "3.11", FILES[0]),  # Blender's Linux is older
        (["win_amd64"], "3.13", FILES[3]),
        (["win_amd64"], "3.11", FILES[4]),
    ],
)
def test_the_hash_is_that_of_the_file_that_the_platform_installs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, platforms: list[str], python: str, chosen: str
) -> None:
    index_page(tmp_path, dict.fromkeys(FILES, ""))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "page.html"))
    file = lock.Index(platforms, python).file("incision", "1.0")
    assert file == (chosen, f"sha256:{hashlib.sha256(chosen.encode()).hexdigest()}")


def test_a_version_that_was_withdrawn_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    index_page(tmp_path, {FILES[0]: 'data-yanked="cuts too deep"'})
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "page.html"))
    with pytest.raises(ValueError, match=r"was withdrawn \(cuts too deep\); raise incision"):
        lock.Index(lock.tags("linux-x64"), "3.11").file("incision", "1.0")


def test_a_version_that_is_not_there_has_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    index_page(tmp_path, {FILES[0]: ""})
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "page.html"))
    assert lock.Index(lock.tags("linux-x64"), "3.11").file("incision", "3.0") is None
