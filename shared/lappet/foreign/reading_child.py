"""The process that reads a file for another: `python -m MODULE READER LIMITS OPTION FILE`, started by `ReadingProcess`.

It limits itself, reads, and writes one block of `lappet.core.value_codec` to its standard output: the value, or a
`ReadRefusal`. What it cannot tell in this way its exit status says.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import signal
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any, Never

from lappet.core.problem import Problem, ProblemsError, file_problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack
from lappet.foreign.limits import ReadLimits

_RESERVED = 2 << 30  # bytes: libraries, and addresses that they set aside and may never use

_SPENT = 0.9  # of the memory: then whatever fails fails for lack of it

FileReader = Callable[[Path, ReadLimits, str], Any]


class Ending(IntEnum):
    """What the exit status of the process says."""

    DONE = 0
    MEMORY = 71
    SIZE = 72


@dataclass(frozen=True)
class ReadRefusal:
    """Why the file is not read.

    Parameters
    ----------
    problems
        Every reason.
    """

    problems: tuple[Problem, ...]


def serve(readers: Mapping[str, FileReader], arguments: list[str]) -> Never:
    """Read the file that the arguments name, hand over what is read, and end the process.

    Parameters
    ----------
    readers
        Functions of the file, the limits and the option, by the name that the arguments have for them.
    arguments
        Arguments of the process.
    """
    name, told, option, file = arguments
    limits = ReadLimits(**json.loads(told))
    handle = os.dup(1)
    os.dup2(2, 1)  # what a library prints is no part of the value
    limit_process(limits)
    os._exit(_hand_over(handle, readers[name], Path(file), limits, option))


def limit_process(limits: ReadLimits) -> None:
    """Limit this process's memory, time and size of files, as far as its system does that.

    Parameters
    ----------
    limits
        The limits.
    """
    if sys.platform == "win32":
        return
    import resource

    for kind, wanted in (
        (resource.RLIMIT_DATA, limits.memory),
        (resource.RLIMIT_AS, limits.memory + limits.size + _RESERVED),
        (resource.RLIMIT_CPU, limits.seconds),
        (resource.RLIMIT_FSIZE, limits.size),
        (resource.RLIMIT_CORE, 0),
    ):
        soft, hard = resource.getrlimit(kind)
        most = min([wanted, *(each for each in (soft, hard) if each != resource.RLIM_INFINITY)])
        with contextlib.suppress(ValueError, OSError):  # macOS does not limit the address space
            resource.setrlimit(kind, (most, hard))  # what reaches a hard limit of time is killed without a reason
    signal.alarm(limits.wall_seconds)  # also where its parent is gone


def _hand_over(handle: int, read: FileReader, file: Path, limits: ReadLimits, option: str) -> Ending:
    try:
        value = _value(read, file, limits, option)
        if isinstance(value, ReadRefusal) and _memory_is_spent(limits):
            return Ending.MEMORY  # a library that gets no memory says that the file is damaged
        data = pack(value)
        if len(data) > limits.size:
            return Ending.SIZE
        with os.fdopen(handle, "wb") as out:
            out.write(data)
    except MemoryError:
        return Ending.MEMORY
    except OSError as error:
        if error.errno == errno.EFBIG:
            return Ending.SIZE
        raise
    return Ending.DONE


def _memory_is_spent(limits: ReadLimits) -> bool:
    try:  # not getrusage: its greatest size is also that of the process which started this one
        said = Path("/proc/self/status").read_text(encoding="utf-8")
    except OSError:  # not Linux
        return False
    kib = sum(int(line.split()[1]) for line in said.splitlines() if line.startswith("VmHWM:"))  # not everywhere
    return kib * 1024 > _SPENT * limits.memory


def _value(read: FileReader, file: Path, limits: ReadLimits, option: str) -> Any:
    try:
        return read(file, limits, option)
    except ProblemsError as error:
        return ReadRefusal(error.problems)
    except MemoryError:
        raise
    except OSError as error:
        return ReadRefusal((file_problem(error, file),))
    except Exception as error:  # to be told by who wanted the file
        return ReadRefusal((problem(ProblemCode.INTERNAL, "", f"{type(error).__name__}: {error}".splitlines()[0]),))
