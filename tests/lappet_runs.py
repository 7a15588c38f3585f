"""Runs of `lappet solve` as a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, eq=False)
class Run:
    """A finished `lappet solve`: exit status, what it printed, its report and the bytes of its skin cache."""

    status: int
    stdout: str
    stderr: str
    report: dict[str, Any]
    cache: bytes

    def frame(self, time_code: int) -> dict[str, Any]:
        (found,) = (frame for frame in self.report["frames"] if frame["time_code"] == time_code)
        return dict(found)


def solve(folder: Path, *arguments: object) -> Run:
    """`lappet solve p.usda` in a folder, with a store there."""
    cache, report = folder / "c.usdc", folder / "r.json"
    cache.unlink(missing_ok=True)
    report.unlink(missing_ok=True)
    command = [sys.executable, "-m", "lappet", "solve", "p.usda", "-o", cache.name, "--report", report.name]
    done = subprocess.run(
        [*command, "--store", "store", *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        timeout=250,
        check=False,
    )
    assert "Traceback" not in done.stderr
    return Run(
        done.returncode,
        done.stdout,
        done.stderr,
        json.loads(report.read_text()) if report.is_file() else {},
        cache.read_bytes() if cache.is_file() else b"",
    )
