"""The daemon of this checkout, running for one test, and a raw peer of it; and the schemas, known before any stage."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

# Before numpy is loaded, here and in every process that a test starts: workers and daemons leave no processor to the
# threads of BLAS, which then wait for each other over small matrices, many times as long as these take.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Modules are compiled once, whatever the environment says of keeping them: each process that a test starts would
# compile what it imports of the package again, up to a second of it.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import pytest

from kept_sheets import kept_sheets  # noqa: F401  (a fixture)
from lappet.daemon.client import DaemonMissing
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.usd.stage import pxr
from raw_peer import Raw

sys.dont_write_bytecode = False  # of this process too

# What a shell starts in the background ignores SIGINT, and with it every test of Ctrl-C.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# tests/addon/test_blender.py runs these, in processes without usd-core.
collect_ignore = ["blender"]

# USD reads the schemas once, when the first stage of the process is opened, whichever test does that.
pxr()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that take long, so that at the end no worker is left alone with one.

    `make test` hands whole files to its workers, in this order: first those with slow tests, then those with many.
    """
    files: dict[Path, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)

    def place(file: list[pytest.Item]) -> tuple[bool, int]:
        return not any(item.get_closest_marker("slow") for item in file), -len(file)

    items[:] = [item for file in sorted(files.values(), key=place) for item in file]


@pytest.fixture(scope="module")
def binary() -> Path:
    try:
        return find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))


@pytest.fixture
def daemon(binary: Path) -> Iterator[SolverDaemon]:
    with SolverDaemon(binary, arguments=("--max-message-bytes", "4000000", "--max-clients", "4")) as running:
        yield running
        assert running.alive(), f"the daemon did not live through the test: {running.death()}"


@pytest.fixture
def raw(daemon: SolverDaemon) -> Iterator[Raw]:
    with contextlib.closing(Raw(daemon)) as peer:
        yield peer
