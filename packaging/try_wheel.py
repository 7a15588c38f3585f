"""Install a wheel of Lappet where nothing else is, and solve the demo with its daemon.

    python packaging/try_wheel.py WHEEL    or the folder in which it is the only one for this system

Its dependencies come from PyPI. Needs nothing but Python with venv; on every system.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any

# A coarse lattice and the frames in which the wound is cut, the flaps are undermined and the hooks begin to pull.
SETTINGS = ("--spacing", "4", "--frames", "1:12", "--no-error-estimate")
_ASK = "from lappet.demo import z_plasty; print(z_plasty())"


def wheel_at(place: Path) -> Path:
    """The wheel that is named, or the only one in a folder. Raises FileNotFoundError where there is not one."""
    if place.is_file():
        return place
    found = sorted(place.glob("lappet-*.whl"))
    if len(found) != 1:
        raise FileNotFoundError(f"{place} has {len(found)} wheels of Lappet; name the one to try.")
    return found[0]


def try_wheel(wheel: Path, folder: Path) -> dict[str, Any]:
    """Install the wheel into an environment in `folder`, solve the demo and return the report of it.

    Raises CalledProcessError where a step fails; it has printed why.
    """
    environment = folder / "environment"
    venv.create(environment, with_pip=True)
    python = environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    # Isolated, and with no variables of a checkout: nothing but the wheel brings Lappet and its daemon.
    variables = {name: value for name, value in os.environ.items() if not name.startswith(("LAPPET_", "PYTHON"))}

    def run(*arguments: str) -> str:
        done = subprocess.run(
            [str(python), "-I", *arguments], cwd=folder, env=variables, check=True, stdout=subprocess.PIPE, text=True
        )
        return done.stdout

    run("-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(wheel.resolve()))
    report = folder / "report.json"
    demo = run("-c", _ASK).strip()
    output = ("-o", str(folder / "demo.usdc"), "--report", str(report), "--store", str(folder / "store"))
    run("-m", "lappet", "solve", demo, *SETTINGS, *output)
    told: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    return told


def main(arguments: list[str]) -> int:
    """The command. Returns the exit status."""
    if len(arguments) != 1:
        print("usage: try_wheel.py WHEEL, or the folder that it is in", file=sys.stderr)
        return 2
    try:
        wheel = wheel_at(Path(arguments[0]))
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            report = try_wheel(wheel, Path(folder))
    except FileNotFoundError as error:
        print(f"try_wheel: {error}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"try_wheel: {' '.join(error.cmd[2:5])} failed; its message is above.", file=sys.stderr)
        return 1
    machine = report["machine"]
    print(
        f"{wheel.name}: the demo is solved on {machine['system']}, Python {machine['python']}: "
        f"{report['frames_solved']} frames in {report['wall_seconds']:.1f} s, complete: {report['complete']}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
