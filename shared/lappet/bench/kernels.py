"""The kernel suite: solverd_benchmarks is run, and its times are held against what the machine can do.

The roofline of a kernel is the least time that its memory traffic or its arithmetic take (Williams, Waterman, Patterson
2009):

    bound = max(bytes per cell / copy bandwidth, operations per cell / multiply-add rate)
    roofline_fraction = bound / time

Bytes are what a cell must bring in and out once, what is added to counting twice. Copy bandwidth is that of memory
where a kernel streams, and of the first cache where it works in cache; it counts what is read and what is written, as
STREAM does. A kernel that reads more than it writes may be a little faster than a copy: streaming fractions can pass 1.
What other guests of a machine leave of its memory changes within a second, so copies and the products that stream are
measured a second time in turns, and the best of each is held against the best of the other.
Operations are counted by running the kernel on numbers that count (solverd/benchmarks/counted_number.h); the rate is
that of independent fused multiply-adds, two operations each, of the same instruction set and precision.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.process import find_daemon

BINARY = "solverd_benchmarks"
REPETITIONS, SECONDS = 9, 0.02  # of each measurement; at least so long in cache
PARALLEL = "product_50000"
TURNS = "^(copy/bytes/any|product/float/[a-z0-9]+)/stream"
TURNS_REPETITIONS = 40


@dataclass(frozen=True)
class KernelMeasure:
    """A kernel on one instruction set and one thread, best of all repetitions of thread CPU time.

    Parameters
    ----------
    kernel
        Name of the kernel.
    precision
        Precision of the arithmetic.
    isa
        Instruction set.
    mode
        "cache" or "stream".
    ns_per_cell
        Nanoseconds per cell.
    bytes_per_cell
        Bytes that it moves per cell.
    operations_per_cell
        Floating-point operations per cell.
    roofline_fraction
        Share of the time that the machine's limits account for.
    set_bytes
        Bytes that it walks through.
    """

    kernel: str
    precision: str
    isa: str
    mode: str
    ns_per_cell: float
    bytes_per_cell: float
    operations_per_cell: float
    roofline_fraction: float
    set_bytes: float


@dataclass(frozen=True)
class ParallelMeasure:
    """The product of 50 000 cells on several threads, wall time.

    Parameters
    ----------
    kernel
        Name of the kernel.
    isa
        Instruction set.
    cells
        Number of cells.
    threads
        Number of threads.
    ms
        Milliseconds of one product.
    speedup
        Speedup over one thread.
    """

    kernel: str
    isa: str
    cells: int
    threads: int
    ms: float
    speedup: float


@dataclass(frozen=True)
class Limits:
    """What one thread can do.

    Parameters
    ----------
    copy
        Bytes per second by mode.
    multiply_add
        Operations per second by (precision, isa).
    """

    copy: Mapping[str, float]
    multiply_add: Mapping[tuple[str, str], float]

    def roofline_fraction(
        self, seconds: float, bytes_moved: float, operations: float, mode: str, precision: str, isa: str
    ) -> float:
        """Compute the share of a time that the machine's limits account for.

        Parameters
        ----------
        seconds
            The time in seconds.
        bytes_moved
            Bytes that were moved.
        operations
            Operations that were done.
        mode
            "cache" or "stream".
        precision
            Precision of the arithmetic.
        isa
            Instruction set.

        Returns
        -------
        float
            The share, at most about 1.
        """
        return max(bytes_moved / self.copy[mode], operations / self.multiply_add[precision, isa]) / seconds

    def as_dict(self) -> dict[str, Any]:
        """List the limits for JSON.

        Returns
        -------
        dict[str, Any]
            Bytes per second and operations per second of one thread.
        """
        return {
            "copy_bytes_per_s": dict(self.copy),
            "multiply_add_operations_per_s": {f"{p} {isa}": rate for (p, isa), rate in self.multiply_add.items()},
        }


@dataclass(frozen=True)
class Suite:
    """All that one run of solverd_benchmarks gave.

    Parameters
    ----------
    context
        What it says of itself.
    limits
        Limits of one thread.
    rows
        Kernels on one thread.
    parallel
        The product on several threads.
    """

    context: dict[str, str]
    limits: Limits
    rows: tuple[KernelMeasure, ...]
    parallel: tuple[ParallelMeasure, ...]


def find_benchmarks() -> Path:
    """Find solverd_benchmarks: `LAPPET_BENCHMARKS`, or beside the daemon.

    Returns
    -------
    Path
        The program.

    Raises
    ------
    RefusedError
        If there is none.
    """
    named = os.environ.get("LAPPET_BENCHMARKS")
    path = Path(named) if named else find_daemon().with_name(BINARY)
    if not path.is_file():
        raise refused(ProblemCode.BENCH_MISSING, path)
    return path


def run_suite(
    program: Path,
    repetitions: int = REPETITIONS,
    seconds: float = SECONDS,
    stream_bytes: int | None = None,
    only: str | None = None,
) -> dict[str, Any]:
    """Run the kernel suite.

    Parameters
    ----------
    program
        The program solverd_benchmarks.
    repetitions
        Number of repetitions of each measurement.
    seconds
        Least time of each in seconds.
    stream_bytes
        Bytes that a streaming kernel walks through; the program's choice when None.
    only
        A regular expression on kernel/precision/isa/mode; by default all, and then copies and products in turns.

    Returns
    -------
    dict[str, Any]
        What the program printed as JSON.

    Raises
    ------
    RefusedError
        If it fails; the message has its last words.
    """
    values = _run(program, repetitions, seconds, stream_bytes, [] if only is None else [f"--benchmark_filter={only}"])
    if only is None:
        in_turns = ["--benchmark_enable_random_interleaving=true", f"--benchmark_filter={TURNS}"]
        turns = TURNS_REPETITIONS if repetitions == REPETITIONS else repetitions
        values["benchmarks"] += _run(program, turns, seconds, stream_bytes, in_turns)["benchmarks"]
    return values


def _run(
    program: Path, repetitions: int, seconds: float, stream_bytes: int | None, arguments: list[str]
) -> dict[str, Any]:
    command = [
        str(program),
        f"--benchmark_repetitions={repetitions}",
        f"--benchmark_min_time={seconds}",
        "--benchmark_format=json",
        *arguments,
    ]
    if stream_bytes is not None:
        command.append(f"--stream-bytes={stream_bytes}")
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise refused(ProblemCode.BENCH_FAILED, program.name, done.returncode, words=done.stderr.strip()[-500:])
    values: dict[str, Any] = json.loads(done.stdout)
    return values


def read_suite(values: Mapping[str, Any]) -> Suite:
    """Read the rows of what solverd_benchmarks printed.

    Parameters
    ----------
    values
        The printed values.

    Returns
    -------
    Suite
        The rows.

    Raises
    ------
    RefusedError
        If the machine's limits are not in it.
    """
    best = _best(values["benchmarks"])
    copy = {mode: 2.0 * e["cells"] / e["s"] for (kernel, _, _, mode), e in best.items() if kernel == "copy"}
    rates = {(p, isa): e["operations"] / e["s"] for (kernel, p, isa, _), e in best.items() if kernel == "multiply_add"}
    if not rates or set(copy) != {"cache", "stream"}:
        raise refused(ProblemCode.BENCH_NO_LIMITS)
    limits = Limits(copy, rates)
    rows = []
    for (kernel, precision, isa, mode), entry in best.items():
        if kernel in ("copy", "multiply_add") or kernel == PARALLEL:
            continue
        each = entry["s"] / entry["cells"]
        moved, operations = entry["bytes_per_cell"], entry["operations_per_cell"]
        fraction = limits.roofline_fraction(each, moved, operations, mode, precision, isa)
        rows.append(
            KernelMeasure(
                kernel, precision, isa, mode, 1e9 * each, moved, operations, fraction, float(entry["set_bytes"])
            )
        )
    return Suite(context(values), limits, tuple(rows), tuple(_parallel(values["benchmarks"])))


def context(values: Mapping[str, Any]) -> dict[str, str]:
    """Read what solverd_benchmarks says of itself.

    Parameters
    ----------
    values
        The printed values.

    Returns
    -------
    dict[str, str]
        `compiler`, `isa`, `instruction_sets` (comma-separated) and `stream_bytes`.
    """
    names = ("compiler", "isa", "instruction_sets", "stream_bytes")
    return {name: str(values["context"][name]) for name in names if name in values["context"]}


def _best(entries: Iterable[Mapping[str, Any]]) -> dict[tuple[str, str, str, str], dict[str, Any]]:
    """Of each measurement the repetition with the least CPU time, in seconds under `s`."""
    best: dict[tuple[str, str, str, str], dict[str, Any]] = {}
    for entry in entries:
        if entry.get("run_type") != "iteration":
            continue
        kernel, precision, isa, mode = str(entry["name"]).split("/")[:4]
        seconds = float(entry["cpu_time"]) * _UNITS[entry["time_unit"]]
        key = (kernel, precision, isa, mode)
        if key not in best or seconds < best[key]["s"]:
            best[key] = {**entry, "s": seconds}
    return best


def _parallel(entries: Iterable[Mapping[str, Any]]) -> list[ParallelMeasure]:
    seconds: dict[int, float] = defaultdict(lambda: float("inf"))
    isa, cells = "", 0
    for entry in entries:
        if entry.get("run_type") != "iteration" or not str(entry["name"]).startswith(PARALLEL):
            continue
        threads = int(entry["threads_used"])
        seconds[threads] = min(seconds[threads], float(entry["real_time"]) * _UNITS[entry["time_unit"]])
        isa, cells = str(entry["name"]).split("/")[2], int(entry["cells"])
    return [
        ParallelMeasure("product", isa, cells, threads, 1e3 * time, seconds.get(1, float("nan")) / time)
        for threads, time in sorted(seconds.items())
    ]


_UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
