"""A child process whose readers behave as no reader should: `python -m odd_child`."""

from __future__ import annotations

import errno
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from odd_values import Numbers

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits
from lappet.foreign.reading_child import serve


def numbers(file: Path, limits: ReadLimits, option: str) -> Any:
    """Give the numbers up to `option`, and chatter."""
    os.write(1, b"chatter of a library")
    return Numbers(np.arange(int(option), dtype=np.int64))


def garbage(file: Path, limits: ReadLimits, option: str) -> Any:
    """Write what is no value to every open handle, and end well."""
    for handle in range(1, 64):
        try:
            os.write(handle, b"cos\nsystem\n(S'touch pickled'\ntR." * 10)
        except OSError:
            continue
    os._exit(0)


def other_value(file: Path, limits: ReadLimits, option: str) -> Any:
    """Give a value of a class that nobody asked for."""
    return limits


def memory(file: Path, limits: ReadLimits, option: str) -> Any:
    """Take all the memory there is."""
    held = []
    while True:
        held.append(np.ones(1 << 24))


def spin(file: Path, limits: ReadLimits, option: str) -> Any:
    """Take all the time there is."""
    while True:
        pass


def sleep(file: Path, limits: ReadLimits, option: str) -> Any:
    """Wait, without work."""
    time.sleep(600)


def hold(file: Path, limits: ReadLimits, option: str) -> Any:
    """Wait, deaf to the alarm that a process sets itself."""
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    time.sleep(600)


def crash(file: Path, limits: ReadLimits, option: str) -> Any:
    """End as a library does that fails."""
    os.abort()


def fault(file: Path, limits: ReadLimits, option: str) -> Any:
    """Raise what no reader should."""
    raise KeyError("a key of Lappet's own")


def lose(file: Path, limits: ReadLimits, option: str) -> Any:
    """Meet what the file system says."""
    raise OSError(errno.ENAMETOOLONG, os.strerror(errno.ENAMETOOLONG), str(file))


def refuse(file: Path, limits: ReadLimits, option: str) -> Any:
    """Refuse the file."""
    raise refused(ProblemCode.FILE_NO_TRIANGLES, file)


READERS = {each.__name__: each for each in (numbers, garbage, other_value, memory, spin, sleep, hold, crash)}
READERS |= {each.__name__: each for each in (fault, lose, refuse)}

if __name__ == "__main__":
    serve(READERS, sys.argv[1:])
