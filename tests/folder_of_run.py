"""What is made once for all tests of a run, whichever of its workers needs it first."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


def folder_of_run(tmp_path_factory: pytest.TempPathFactory, name: str) -> Path:
    """A folder that all workers of this run know."""
    own = tmp_path_factory.getbasetemp()  # with several workers a folder in that of the run
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / name
    folder.mkdir(exist_ok=True)
    return folder


@contextmanager
def alone(lock: Path) -> Iterator[None]:
    """While this lasts no other worker has the lock."""
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
