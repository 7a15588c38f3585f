"""Make the plates of docs/gallery: `gallery.py [NAME ...]` runs the commands of gallery.toml in build/gallery.

A cache that is there is not solved again; with names only these plates are made. The page docs/gallery/README.md is
written anew.
"""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
GALLERY = ROOT / "docs/gallery"
WORK = ROOT / "build/gallery"
PROGRAMS = {"lappet": [sys.executable, "-m", "lappet"], "python": [sys.executable], "cp": ["cp"]}


def arguments(command: str) -> list[str]:
    """The program and arguments of a command of the gallery; files of examples are those of the checkout."""
    program, *rest = shlex.split(command)
    return [*PROGRAMS[program], *(str(ROOT / each) if each.startswith("examples/") else each for each in rest)]


def run(plate: dict[str, Any]) -> None:
    """Make a plate; what its commands write and is there already is kept, but for the picture."""
    for command in plate["commands"]:
        words = shlex.split(command)
        target = words[words.index("-o") + 1] if "-o" in words else words[-1]
        if target != plate["picture"] and (WORK / target).exists():
            continue
        print(f"gallery: {command}", flush=True)
        if subprocess.run(arguments(command), cwd=WORK).returncode:
            sys.exit(f"gallery: failed: {command}")
    shutil.copyfile(WORK / plate["picture"], GALLERY / plate["picture"])


def page(plates: list[dict[str, Any]]) -> str:
    """The page of the gallery."""
    parts = [
        "# Gallery\n\nPlates as [`lappet plate`](../plates.md) draws them, each with the commands that make it, in the "
        "folder of a checkout. `make gallery` makes all of them again and writes this page. `make projects` writes "
        "each as a project for Blender into build/gallery/blends, with its procedure, page, camera, lights and look; "
        "the extension solves it when it is opened. The site of the documents offers these files.\n"
    ]
    for plate in plates:
        commands = "\n".join(plate["commands"])
        parts.append(f"## {plate['title']}\n\n![{plate['title']}]({plate['picture']})\n\n```\n{commands}\n```\n")
    return "\n".join(parts)


def main() -> int:
    """Make all plates, or those that are named."""
    plates = tomllib.loads((GALLERY / "gallery.toml").read_text(encoding="utf-8"))["plate"]
    names = {plate["name"] for plate in plates}
    if unknown := [name for name in sys.argv[1:] if name not in names]:
        print(f"gallery: there is no {unknown[0]!r}; there are {', '.join(sorted(names))}.", file=sys.stderr)
        return 2
    WORK.mkdir(parents=True, exist_ok=True)
    for plate in plates:
        if not sys.argv[1:] or plate["name"] in sys.argv[1:]:
            run(plate)
    (GALLERY / "README.md").write_text(page(plates), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
