"""Make the zip that Blender installs: `extension.py [--platform P] [--lappet-wheel FILE] [--website URL]`.

The add-on's sources, its manifest with the list of wheels filled in, the wheels (Lappet with its daemon, and what it
imports) and a bill of materials. Blender's own tool builds and checks it. Without `--lappet-wheel` the daemon is
compiled here, for Linux.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

import lappet_wheel
import sbom
import system_versions
from lappet_wheel import edited, metadata_folder
from pypi_wheels import CACHE, PLATFORMS, ROOT, bundled

ADDON = ROOT / "addon" / "lappet_blender"
VIEWER = "lappet/viewer"  # the program of lessons, which the command line writes
MANIFEST = "blender_manifest.toml"
LEFT_OUT = ("__pycache__", "*.pyc", "tests", ".*")


def blender_extension_tool(bpy: Path | None = None) -> Path:
    """Blender's `blender_ext.py`, which builds and validates extensions without Blender running.

    bpy: the folder of the module (that of this Python when None). Raises FileNotFoundError where there is none.
    """
    if bpy is None:
        spec = importlib.util.find_spec("bpy")
        if spec is None or spec.origin is None:
            raise FileNotFoundError("Blender's module bpy is not installed in this Python; run `make setup`.")
        bpy = Path(spec.origin).parent
    found = sorted(bpy.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    if not found:
        raise FileNotFoundError(f"{bpy} has no */scripts/addons_core/bl_pkg/cli/blender_ext.py; is it Blender's bpy?")
    return found[-1]


def project_version() -> str:
    """The version in pyproject.toml."""
    version: str = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return version


def for_extension(wheel: Path, into: Path) -> Path:
    """Lappet's wheel without the add-on, which the zip holds beside it, and without what only the command line uses.

    Its version tells what is in it: Blender extracts a wheel again only when its version changes, so two builds of one
    version must differ in name.
    """

    def strip(folder: Path) -> None:
        for left_out in ("lappet_blender", VIEWER):
            shutil.rmtree(folder / left_out, ignore_errors=True)
        metadata = metadata_folder(folder)
        digest = hashlib.sha256()
        for path in sorted(folder.rglob("*")):
            if path.is_file() and not path.is_relative_to(metadata):
                digest.update(f"{path.relative_to(folder).as_posix()}\0".encode() + path.read_bytes())
        _, version = metadata.name.removesuffix(".dist-info").split("-")
        told = f"{version}+{digest.hexdigest()[:8]}"
        text = (metadata / "METADATA").read_text(encoding="utf-8")
        text = re.sub(r"^Version: .*$", f"Version: {told}", text, count=1, flags=re.MULTILINE)
        (metadata / "METADATA").write_text(text, encoding="utf-8")
        if (bill := metadata / "sboms" / sbom.NAME).is_file():
            of_told = sbom.of_version(sbom.without(json.loads(bill.read_text(encoding="utf-8")), VIEWER), told)
            bill.write_text(sbom.text(of_told), encoding="utf-8")
        metadata.rename(folder / f"lappet-{told}.dist-info")

    made = edited(wheel, into, strip)
    _compress_harder(made)
    return made


def _compress_harder(wheel: Path) -> None:
    """Compress the programs and libraries in a wheel by LZMA, which takes 40 % less than what pip's wheels have.

    For Blender alone, which unpacks wheels with Python's zipfile, on every system a Python that has LZMA.
    """
    smaller = wheel.with_suffix(".smaller")
    with zipfile.ZipFile(wheel) as before, zipfile.ZipFile(smaller, "w") as after:
        for old in before.infolist():
            data = before.read(old)
            method = zipfile.ZIP_LZMA if sbom.is_native(data[:4]) else old.compress_type
            after.writestr(_entry(old, method, old.external_attr), data)
    smaller.replace(wheel)


def valid_tags(tool: Path) -> Path:
    """The tags of Get Extensions, a file that comes with `blender_ext.py`, which checks them only when told."""
    return tool.parents[3] / "modules" / "_bpy_internal" / "extensions" / "tags.py"


def website_address(text: str) -> str:
    """The address of a website; raises ArgumentTypeError for one that does not begin with https://."""
    if not re.fullmatch(r"https://[\w.-]+(/\S*)?", text):
        raise argparse.ArgumentTypeError(f"{text!r} is no website; give an address such as https://example.org/lappet")
    return text


def with_wheels(manifest: str, wheels: list[str], platform: str, website: str = "") -> str:
    """The manifest's text with `platforms` and `wheels` before its first table, where keys of the whole file stand.

    website: where documentation, sources and support are, written too unless it is empty; whoever publishes knows it.
    Raises ValueError where it has one of them already, or where its version is not the project's.
    """
    values = tomllib.loads(manifest)
    for key in ("platforms", "wheels", "website"):
        if key in values:
            raise ValueError(f"{MANIFEST} names {key}; packaging/extension.py writes them, so take that line out.")
    if values["version"] != project_version():
        raise ValueError(
            f"{MANIFEST} says version {values['version']} and pyproject.toml {project_version()}; make them the same."
        )
    lines = [f"website = {json.dumps(website)}"] if website else []
    lines += [f"platforms = {json.dumps([platform])}", "wheels = ["]
    lines += [f"  {json.dumps(f'./wheels/{name}')}," for name in wheels]
    head, table, tail = manifest.partition("\n[")
    return "\n".join([head.rstrip(), *lines, "]", ""]) + table + tail


def assemble(
    platform: str, lappet: Path, output: Path, *, others: list[Path], addon: Path = ADDON, website: str = ""
) -> Path:
    """Make, build and validate the zip of a platform, and return its path in the folder `output`.

    platform: Blender's name, a key of PLATFORMS. lappet: the wheel of Lappet for it. others: the wheels of other
    projects. addon: the add-on's folder. website: for its manifest. Raises ValueError for a wheel of another platform,
    LookupError for one of unknown license, CalledProcessError, after Blender's tool has printed why, where that refuses
    the extension.
    """
    tag = lappet.stem.split("-")[-1]
    runs_on = re.compile({"linux": "manylinux_", "macos": "macosx_", "windows": "win_"}[platform.partition("-")[0]])
    machine = {"x64": ("x86_64", "amd64"), "arm64": ("aarch64", "arm64")}[platform.partition("-")[2]]
    if not runs_on.match(tag) or not tag.endswith((*machine, "universal2")):
        raise ValueError(f"{lappet.name} is a wheel for {tag}, not for {platform}; give one that is.")
    tool = blender_extension_tool()
    output.mkdir(parents=True, exist_ok=True)
    made = output / f"lappet_blender-{project_version()}-{platform}.zip"
    with tempfile.TemporaryDirectory() as work:
        staged = Path(work) / "lappet_blender"
        shutil.copytree(addon, staged, ignore=shutil.ignore_patterns(*LEFT_OUT))
        shutil.copyfile(ROOT / "LICENSE", staged / "LICENSE")
        ours = for_extension(lappet, staged / "wheels")
        for wheel in others:
            shutil.copyfile(wheel, staged / "wheels" / wheel.name)
        names = sorted([ours.name, *(wheel.name for wheel in others)])
        text = (staged / MANIFEST).read_text(encoding="utf-8")
        (staged / MANIFEST).write_text(with_wheels(text, names, platform, website), encoding="utf-8")
        bill = sbom.of_extension(staged, project_version())
        (staged / sbom.NAME).write_text(sbom.text(bill), encoding="utf-8")
        built = Path(work) / made.name
        _blender_tool(tool, "build", f"--source-dir={staged}", f"--output-filepath={built}")
        _settle(built, made)
    _blender_tool(tool, "validate", str(made), f"--valid-tags={valid_tags(tool)}")
    return made


def _settle(built: Path, made: Path) -> None:
    """Write a zip anew in the order of its names, without times and rights: the same files make the same bytes."""
    with zipfile.ZipFile(built) as before, zipfile.ZipFile(made, "w") as after:
        for old in sorted(before.infolist(), key=lambda each: each.filename):
            after.writestr(_entry(old, old.compress_type, 0o644 << 16), before.read(old), compresslevel=9)


def _entry(old: zipfile.ZipInfo, method: int, rights: int) -> zipfile.ZipInfo:
    """The head of a file as a zip of every build has it: of 1980, and as if made on Linux."""
    entry = zipfile.ZipInfo(old.filename)
    entry.compress_type, entry.external_attr, entry.create_system = method, rights, 3
    return entry


def outdated() -> list[str]:
    """A sentence for each library of Debian in the wheel that Debian has replaced, as far as apt knows."""
    try:
        there = system_versions.installed()
        newer = system_versions.updates([name for name in sbom.LICENSES if name in there])
    except FileNotFoundError:
        return []
    return [
        f"the zip carries {name} {there[name].version}, and Debian has {version}: upgrade that package, build again."
        for name, version in newer.items()
    ]


def _blender_tool(tool: Path, *arguments: str) -> None:
    done = subprocess.run([sys.executable, str(tool), *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.stderr.write(done.stdout + done.stderr)
        done.check_returncode()


def main(arguments: list[str] | None = None) -> int:
    """The command. Returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--platform", choices=sorted(PLATFORMS), default="linux-x64")
    parser.add_argument("--lappet-wheel", type=Path, help="Lappet's wheel for the platform, built on it")
    parser.add_argument("--website", type=website_address, help="where documentation and sources are: https://…")
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    given = parser.parse_args(arguments)
    try:
        if given.lappet_wheel is None and given.platform != lappet_wheel.this_platform():
            raise ValueError(
                f"The daemon for {given.platform} is not compiled by this command; make Lappet's wheel with "
                f"packaging/cross/build.sh and packaging/cross_wheel.py, and name it with --lappet-wheel."
            )
        lappet = given.lappet_wheel or lappet_wheel.portable(lappet_wheel.built())
        made = assemble(
            given.platform, lappet, given.output, others=bundled(given.platform, CACHE), website=given.website or ""
        )
    except (ValueError, LookupError, FileNotFoundError) as error:
        print(f"extension: {error}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"extension: {Path(error.cmd[1]).name} failed; its message is above.", file=sys.stderr)
        return 1
    for line in outdated() if given.lappet_wheel is None else ():
        print(f"extension: warning: {line}", file=sys.stderr)
    print(f"{made} ({made.stat().st_size / 1e6:.0f} MB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
