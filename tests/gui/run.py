"""Runs a scenario in a real Blender window without a screen: `run.py [SCENARIO] [--limit SECONDS] [--zip FILE]`.

SCENARIO: a script beside this one (drive.py). Makes the chroot with Blender and the extension's zip where they are
missing. Screenshots, Blender's log and the verdict go to build/gui/results. The exit status is the verdict's.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
RESULTS = ROOT / "build" / "gui" / "results"
CHROOT = ["bash", str(ROOT / "packaging" / "gui_chroot.sh")]
INSIDE = Path("/lappet")  # the checkout, seen from the chroot
SCREEN = "1600x1000"
# Where events can be simulated Blender's loop never rests and takes a whole core: these simulate none, and measure.
WITHOUT_EVENTS = ("live_rate.py",)


def main() -> int:
    """Sets everything up and runs the part that is in the chroot, which ends with everything that it started."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scenario", nargs="?", default="drive.py")
    parser.add_argument("--limit", type=float, default=420.0, help="seconds until the run has failed")
    parser.add_argument("--zip", type=Path, help="the extension to install, a file in this checkout; else it is built")
    given = parser.parse_args()
    if subprocess.run(CHROOT, check=False).returncode:
        return 1
    zip_file = packed() if given.zip is None else given.zip.resolve().relative_to(ROOT)
    if zip_file is None:
        return 1
    shutil.rmtree(RESULTS, ignore_errors=True)
    RESULTS.mkdir(parents=True)
    inside = ["python3", str(INSIDE / "tests/gui/run.py"), "--inside", str(zip_file), given.scenario]
    with (RESULTS / "log.txt").open("w") as log:
        # What is inside ends, with all that it started, once its standard input does: with this process, at the latest.
        process = subprocess.Popen([*CHROOT, "run", *inside], stdin=subprocess.PIPE, stdout=log, stderr=log)
        try:
            process.wait(timeout=given.limit)
        except subprocess.TimeoutExpired:
            print(f"gui: ended after {given.limit:g} s.", file=sys.stderr)
        finally:
            assert process.stdin is not None
            process.stdin.close()
            process.wait(timeout=20)
    return report()


def packed() -> Path | None:
    """Builds the extension's zip; its path in the checkout, or None where that failed."""
    pack = [sys.executable, str(ROOT / "packaging" / "extension.py")]
    made = subprocess.run(pack, check=False, stdout=subprocess.PIPE, text=True)
    if made.returncode:
        return None
    return Path(made.stdout.splitlines()[-1].rpartition(" (")[0]).relative_to(ROOT)  # other tools speak before


def report() -> int:
    """Prints the verdict; returns the exit status."""
    log = RESULTS / "log.txt"
    said = log.read_text(encoding="utf-8", errors="replace")
    try:
        verdict = json.loads((RESULTS / "verdict.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        tail = "\n".join(said.splitlines()[-15:])
        print(f"gui: Blender gave no verdict; the end of {log.relative_to(ROOT)}:\n{tail}", file=sys.stderr)
        return 1
    for each in verdict["expectations"]:
        print(f"{'ok  ' if each['held'] else 'FAIL'} {each['sentence']}")
    if verdict["error"]:
        print(verdict["error"], file=sys.stderr)
    silent = "Traceback (most recent call last)" not in said
    if not silent:
        print(f"FAIL there is a traceback in {log.relative_to(ROOT)}")
    passed = verdict["passed"] and silent
    print(
        f"gui: {'passed' if passed else 'failed'} in {verdict['seconds']} s with Blender "
        f"{verdict['blender']}; pictures in {RESULTS.relative_to(ROOT)}: {', '.join(verdict['screenshots'])}"
    )
    return 0 if passed else 1


def end_with_standard_input() -> None:
    """Ends this process once nobody holds the other end of its standard input."""
    while os.read(0, 4096):  # not through a buffer, whose lock the end of the interpreter would find held
        pass
    os._exit(1)


def inside(zip_file: str, scenario: str) -> int:
    """In the chroot: a screen, and Blender on it. What is started here ends with this, the first of its namespace."""
    threading.Thread(target=end_with_standard_input, daemon=True).start()
    display, number = os.pipe()
    screen = ["Xvfb", "-displayfd", str(number), "-screen", "0", f"{SCREEN}x24", "-nolisten", "tcp"]
    complaints = (INSIDE / "build/gui/results/xvfb.txt").open("w")  # of keys that no keyboard has
    with complaints, subprocess.Popen(screen, pass_fds=[number], stdin=subprocess.DEVNULL, stderr=complaints) as xvfb:
        os.close(number)
        with os.fdopen(display) as pipe:
            name = pipe.readline().strip()
        if not name:
            print("Xvfb gives no display; build/gui/results/xvfb.txt says why.", file=sys.stderr)
            return 1
        home = Path("/root/lappet")
        shutil.rmtree(home, ignore_errors=True)
        width, height = SCREEN.split("x")
        command = ["blender", "--factory-startup", "--python-exit-code", "3"]
        command += [] if Path(scenario).name in WITHOUT_EVENTS else ["--enable-event-simulate"]
        command += ["-p", "0", "0", width, height, "--python", str(INSIDE / "tests/gui" / scenario)]
        environment = {
            **os.environ,
            "DISPLAY": f":{name}",
            "HOME": str(home),
            "BLENDER_USER_RESOURCES": str(home / "blender"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "LAPPET_ZIP": str(INSIDE / zip_file),
            "LAPPET_GUI_RESULTS": str(INSIDE / "build/gui/results"),
        }
        began = time.monotonic()
        status = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, check=False).returncode
        print(f"blender ended with status {status} after {time.monotonic() - began:.1f} s")
        xvfb.terminate()
    return status


if __name__ == "__main__":
    sys.exit(inside(*sys.argv[2:]) if sys.argv[1:2] == ["--inside"] else main())
