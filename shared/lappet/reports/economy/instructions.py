"""Instructions of the daemon's hot loops, counted by callgrind while it solves one frame.

The daemon runs under valgrind on one thread; collection is on inside `Session::solve` alone, so that neither its start
nor its sockets count. Valgrind knows no AVX-512: where the processor would choose it, AVX2 is counted.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from lappet.core.problem import Problem, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import SolverClient
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.program.program import Program

FRAME, SEARCH = "lappet::Session::solve(", "lappet::find_equilibrium<"
KERNELS = {"evaluate": "evaluate_groups<", "linearize": "linearize_groups<", "product": "multiply_groups<"}
_PATIENCE = 300.0  # seconds that valgrind may take to bring the daemon up
_COST = re.compile(r"^[+\-*]?\d* ?(\d+)$")


class NoCounterError(RefusedError):
    """Instructions cannot be counted here; the sentence says why."""


@dataclass(frozen=True)
class Instructions:
    """What one frame took.

    Parameters
    ----------
    frame
        Instructions of all of it.
    search
        Of these inside the search for the equilibrium, the hot loops.
    kernels
        Of these in the fused passes themselves, by the names of `KERNELS`.
    work
        The header's counts.
    """

    frame: int
    search: int
    kernels: Mapping[str, int]
    work: Mapping[str, float]


def why_not() -> Problem | None:
    """Say why instructions cannot be counted on this machine.

    Returns
    -------
    Problem | None
        A sentence, or None where they can.
    """
    if shutil.which("valgrind") is None:
        return problem(ProblemCode.COUNTER_NO_VALGRIND)
    if sys.platform != "linux":
        return problem(ProblemCode.COUNTER_NOT_LINUX, "", sys.platform)
    return None


def count_instructions(program: Program, binary: Path | None = None) -> Instructions:
    """Solve a program's first frame under callgrind, on one thread.

    Parameters
    ----------
    program
        The program.
    binary
        The daemon; found when None.

    Returns
    -------
    Instructions
        The counts.

    Raises
    ------
    NoCounterError
        If valgrind is not there or the daemon has no symbols.
    RefusedError
        If the frame does not converge.
    """
    reason = why_not()
    if reason is not None:
        raise NoCounterError([reason])
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "callgrind.out"
        wrapper = _wrapper(Path(name), find_daemon() if binary is None else binary, out)
        daemon = SolverDaemon(wrapper, start_timeout=_PATIENCE)
        try:
            daemon.start()
            with SolverClient(daemon.address, daemon.token, silence=_PATIENCE) as client:
                client.open(replace(program.settings, threads=1), program.bones)
                client.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
                frame = client.solve(program.frames[0])
        finally:
            daemon.stop(_PATIENCE)  # callgrind writes as the daemon ends
        if not frame.diagnostics.converged:
            raise refused(ProblemCode.REPORT_NOT_CONVERGED, "callgrind", frame.reason)
        if not out.is_file():
            raise NoCounterError.of(ProblemCode.COUNTER_NO_COUNTS)
        return _totals(out.read_text(encoding="utf-8", errors="replace"), asdict(frame.diagnostics.work))


def isa_to_count() -> str | None:
    """Choose the instruction set to ask for under valgrind.

    Returns
    -------
    str | None
        `LAPPET_ISA` where it is set, avx2 where AVX-512 would be chosen, else None.
    """
    named = os.environ.get("LAPPET_ISA")
    if named and named != "avx512":
        return named
    try:
        flags = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    return "avx2" if " avx2 " in flags else None


def _wrapper(folder: Path, binary: Path, out: Path) -> Path:
    """A program that runs the daemon under callgrind."""
    isa = isa_to_count()
    command = [
        "valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--collect-atstart=no",
        f"--toggle-collect={FRAME}*", str(binary.resolve()),
    ]  # fmt: skip
    setting = f"export LAPPET_ISA={isa}\n" if isa else ""
    path = folder / "daemon_under_callgrind"
    path.write_text(f'#!/bin/sh\n{setting}exec {shlex.join(command)} "$@"\n', encoding="utf-8")
    path.chmod(0o700)
    return path


def _totals(text: str, work: Mapping[str, float]) -> Instructions:
    own, inside = callgrind_costs(text)
    frame = sum(own.values())
    search = sum(cost for name, cost in inside.items() if SEARCH in name)
    if not frame or not search:
        raise NoCounterError.of(ProblemCode.COUNTER_NO_SYMBOLS)
    kernels = {
        kernel: sum(cost for name, cost in own.items() if f"lappet::{mark}" in name) for kernel, mark in KERNELS.items()
    }
    return Instructions(frame, search, kernels, dict(work))


def callgrind_costs(text: str) -> tuple[dict[str, int], dict[str, int]]:
    """Read a file that callgrind wrote.

    Parameters
    ----------
    text
        Its content.

    Returns
    -------
    tuple[dict[str, int], dict[str, int]]
        Instructions of each function itself, and those inside calls of it.
    """
    names: dict[str, str] = {}
    own: dict[str, int] = {}
    inside: dict[str, int] = {}
    function = callee = ""
    called = False

    def named(value: str) -> str:
        number, _, name = value.partition(" ")
        if name:
            names[number] = name
        return names.get(number, number)

    for line in text.splitlines():
        if line.startswith("fn="):
            function = named(line[3:])
        elif line.startswith("cfn="):
            callee = named(line[4:])
        elif line.startswith("calls="):
            called = True
        elif (found := _COST.match(line)) is not None:
            into, name = (inside, callee) if called else (own, function)
            into[name] = into.get(name, 0) + int(found[1])
            called = False
    return own, inside


def valgrind_version() -> str | None:
    """Ask valgrind for its version.

    Returns
    -------
    str | None
        What `valgrind --version` says, or None where there is none.
    """
    if shutil.which("valgrind") is None:
        return None
    return subprocess.run(["valgrind", "--version"], capture_output=True, text=True, check=False).stdout.strip() or None
