"""Make the plates of docs/gallery: `gallery.py [NAME ...]` runs the commands of gallery.toml in build/gallery.

A cache that is there is not solved again; with names only these plates are made. The page docs/gallery/README.md is
written anew: below each plate's commands stands what the solve said of its frames, as docs/gallery/told.json keeps it.
"""

from __future__ import annotations

import json
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
TOLD = GALLERY / "told.json"
PROGRAMS = {"lappet": [sys.executable, "-m", "lappet"], "python": [sys.executable], "cp": ["cp"]}


def arguments(command: str) -> list[str]:
    """The program and arguments of a command of the gallery; files of examples are those of the checkout."""
    program, *rest = shlex.split(command)
    return [*PROGRAMS[program], *(str(ROOT / each) if each.startswith("examples/") else each for each in rest)]


def target_of(command: str) -> str:
    """The file that a command writes."""
    words = shlex.split(command)
    return words[words.index("-o") + 1] if "-o" in words else words[-1]


def cache_of(plate: dict[str, Any]) -> str:
    """The skin cache that a plate is drawn from."""
    return shlex.split(plate["commands"][-1])[2]


def run(plate: dict[str, Any]) -> None:
    """Make a plate; what its commands write and is there already is kept, but for the picture."""
    for command in plate["commands"]:
        target, report = target_of(command), Path(target_of(command)).with_suffix(".json")
        solves = command.startswith("lappet solve ")
        if target != plate["picture"] and (WORK / target).exists() and not (solves and not (WORK / report).exists()):
            continue
        print(f"gallery: {command}", flush=True)
        more = ["--report", str(report)] if solves else []  # for the page; who tries the command needs none
        if subprocess.run([*arguments(command), *more], cwd=WORK).returncode:
            sys.exit(f"gallery: failed: {command}")
    shutil.copyfile(WORK / plate["picture"], GALLERY / plate["picture"])
    cache = cache_of(plate)
    known = json.loads(TOLD.read_text(encoding="utf-8")) if TOLD.exists() else {}
    known[cache] = told(json.loads((WORK / cache).with_suffix(".json").read_text(encoding="utf-8")))
    TOLD.write_text(json.dumps(known, indent=1, sort_keys=True, ensure_ascii=False) + "\n", encoding="utf-8")


def told(report: dict[str, Any]) -> list[str]:
    """What a solve says of its frames, from its report: the estimated error, then its warnings, a line each."""
    errors = [frame["estimated_error_mm"]["max"] for frame in report["frames"] if frame["estimated_error_mm"]]
    lines = []
    if errors and report["frames"][-1]["estimated_error_mm"]:
        lines.append(f"Estimated error: {errors[-1]:.2g} mm at most in the last frame, {max(errors):.2g} mm in all.")
    for each in (note for note in report["notes"] if note["severity"] == "warning"):
        name = each["prim"].removeprefix("/Procedure/Timeline/")
        lines.append(f"{name}: {each['message']}" if name else each["message"])
    return lines


def page(plates: list[dict[str, Any]], said: dict[str, list[str]]) -> str:
    """The page of the gallery. said: what each solve told, by the name of its cache."""
    first: dict[str, str] = {}
    parts = [
        "# Gallery\n\nPlates as [`lappet plate`](../plates.md) draws them, each with the commands that make it, in the "
        "folder of a checkout. `make gallery` makes all of them again and writes this page. `make projects` writes "
        "each as a project for Blender into build/gallery/blends, with its procedure, page, camera, lights and look; "
        "the extension solves it when it is opened. The site of the documents offers these files. Below the commands "
        "stands what `lappet solve` says of the frames: a plate shows them whether they are to be trusted or not.\n"
    ]
    for plate in plates:
        commands = "\n".join(plate["commands"])
        parts.append(f"## {plate['title']}\n\n![{plate['title']}]({plate['picture']})\n\n```\n{commands}\n```\n")
        cache = cache_of(plate)
        if cache in first:
            parts.append(f"From the frames of *{first[cache]}*, with what is said there.\n")
        else:
            first[cache] = plate["title"]
            parts.append("\n".join(f"- {line}" for line in said[cache]) + "\n")
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
    said = json.loads(TOLD.read_text(encoding="utf-8"))
    (GALLERY / "README.md").write_text(page(plates, said), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
