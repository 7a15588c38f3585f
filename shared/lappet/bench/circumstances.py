"""What numbers were taken on: machine, compiler, instruction set, threads, revision."""

from __future__ import annotations

import os
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lappet.core.machine import machine
from lappet.core.version import version


def circumstances(context: dict[str, str], threads: int) -> dict[str, Any]:
    """Gather the keys that each file of results starts with.

    Parameters
    ----------
    context
        What solverd_benchmarks says of itself (`lappet.bench.kernels.context`).
    threads
        Number of threads of the measurement.

    Returns
    -------
    dict[str, Any]
        Values that JSON can hold.
    """
    return {
        "machine": machine(),
        "compiler": context.get("compiler"),
        "isa": context.get("isa"),
        "threads": threads,
        "environment": environment(),
        "lappet": version(),
        "revision": revision(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def environment() -> dict[str, str]:
    """List the variables that libraries take their threads, and the kernels their instruction set, from.

    Returns
    -------
    dict[str, str]
        The variables that are set.
    """
    prefixes = ("OMP_", "GOMP_", "OPENBLAS_", "LAPPET_ISA")
    return {name: value for name, value in sorted(os.environ.items()) if name.startswith(prefixes)}


def cores() -> int:
    """Count the processors that this process may use.

    Returns
    -------
    int
        Their number.
    """
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def revision() -> str | None:
    """Find the git revision of the checkout that this file lies in.

    Returns
    -------
    str | None
        The revision, with `+` where files were changed; None outside a checkout.
    """
    folder = Path(__file__).resolve().parent
    try:
        head = subprocess.run(
            ["git", "rev-parse", "--short=12", "HEAD"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=True,
            timeout=30,
        ).stdout.strip()
        dirty = subprocess.run(["git", "diff", "--quiet", "HEAD"], cwd=folder, check=False, timeout=30).returncode
    except (OSError, subprocess.SubprocessError):
        return None
    return head + ("+" if dirty else "")
