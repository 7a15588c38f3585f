"""A child that reads gives its value, keeps its limits, and never takes its parent along."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from odd_values import Numbers

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.foreign import reading_child
from lappet.foreign.limits import GIB, ReadLimits
from lappet.foreign.reading_process import ReadingProcess

POSIX = pytest.mark.skipif(os.name != "posix", reason="no limits of a process here")
SMALL = ReadLimits(memory=GIB // 2, seconds=2, size=1 << 20)


@pytest.fixture(autouse=True)
def children_find_the_odd_child(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent))


def started(reader: str, limits: ReadLimits = SMALL, option: str = "") -> ReadingProcess:
    return ReadingProcess("odd_child", reader, Path("a file"), limits, option)


def ending(reader: str, limits: ReadLimits = SMALL, option: str = "") -> tuple[ProblemCode, str, str]:
    """Code, place and value of the one reason why there is no value."""
    with started(reader, limits, option) as process, pytest.raises(RefusedError) as error:
        process.result(Numbers)
    (problem,) = error.value.problems
    return problem.code, problem.prim, problem.value


def is_alive(pid: int) -> bool:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, 0)
        return True
    return False


def test_a_value_comes_back_whatever_is_printed_besides() -> None:
    with started("numbers", option="1000") as process:
        read: Numbers = process.result(Numbers)
    assert np.array_equal(read.values, np.arange(1000))
    assert not read.values.flags.writeable


def test_the_problems_of_a_reader_come_back_as_values() -> None:
    assert ending("refuse")[:2] == (ProblemCode.FILE_NO_TRIANGLES, "a file")
    code, _, value = ending("fault")
    assert (code, value) == (ProblemCode.INTERNAL, 'KeyError: "a key of Lappet\'s own"')


def test_what_the_file_system_says_is_said_of_the_file_and_no_fault_of_lappet() -> None:
    code, place, value = ending("lose")
    assert (code, place, value) == (ProblemCode.FILE_ERROR, "a file", os.strerror(errno.ENAMETOOLONG))


def test_a_system_that_does_not_tell_the_memory_of_a_process_hides_no_refusal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: "Name:\tpython\nVmRSS:\t100 kB\n")
    assert not reading_child._memory_is_spent(SMALL)
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: f"VmHWM:\t{GIB >> 10} kB\n")
    assert reading_child._memory_is_spent(SMALL)


def test_what_its_parent_holds_is_not_what_a_reader_takes() -> None:
    held = b"\1" * (600 << 20)  # more than the reader may
    assert ending("refuse")[0] == ProblemCode.FILE_NO_TRIANGLES
    assert held


@POSIX
@pytest.mark.parametrize(
    ("reader", "option", "code"),
    [
        ("memory", "", ProblemCode.READ_MEMORY),
        ("spin", "", ProblemCode.READ_TIME),
        ("sleep", "", ProblemCode.READ_TIME),
        ("hold", "", ProblemCode.READ_TIME),
        ("numbers", str(1 << 20), ProblemCode.READ_RESULT_SIZE),
        ("crash", "", ProblemCode.READ_DIED),
    ],
)
def test_what_takes_too_much_is_ended_and_the_limit_is_named(reader: str, option: str, code: ProblemCode) -> None:
    begun = time.monotonic()
    found, place, value = ending(reader, option=option)
    assert (found, place) == (code, "a file")
    assert value in {"0.5 GiB", "2 s", "1 MiB", "signal 6"}
    assert time.monotonic() - begun < SMALL.wall_seconds + 5.0


def test_what_a_child_says_is_no_value_until_it_is_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, value = ending("no such reader")
    assert (code, value) == (ProblemCode.READ_DIED, "status 1 (KeyError: 'no such reader')")
    assert ending("garbage")[0] is ProblemCode.READ_DIED
    assert ending("other_value")[0] is ProblemCode.READ_DIED
    assert list(tmp_path.iterdir()) == [], "nothing was executed"


def test_a_file_in_the_working_folder_is_not_taken_for_a_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "msgpack.py").write_text("open('imported', 'w')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", ["", ".", *sys.path])
    with started("numbers", option="3") as process:
        assert len(process.result(Numbers).values) == 3
    assert not (tmp_path / "imported").exists()


@pytest.fixture
def waiting() -> Iterator[ReadingProcess]:
    with started("sleep", ReadLimits()) as process:
        yield process


def test_a_child_that_is_no_longer_wanted_is_ended(waiting: ReadingProcess) -> None:
    assert is_alive(waiting.pid)
    waiting.close()
    assert not is_alive(waiting.pid)


INTERRUPTED = """
import pathlib, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from lappet.foreign.reading_process import ReadingProcess
from odd_values import Numbers
with ReadingProcess("odd_child", "sleep", pathlib.Path("a file")) as process:
    print(process.pid, flush=True)
    try:
        process.result(Numbers)
    except KeyboardInterrupt:
        print("interrupted")
"""


@POSIX
def test_ctrl_c_ends_the_child_and_is_not_swallowed() -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])}
    with subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True, env=environment
    ) as reader:
        assert reader.stdout is not None
        child = int(reader.stdout.readline())
        time.sleep(0.3)
        reader.send_signal(signal.SIGINT)
        assert reader.communicate(timeout=20)[0] == "interrupted\n"
    assert not is_alive(child)


@POSIX
def test_a_child_outlives_its_parent_by_no_more_than_its_time() -> None:
    code = INTERRUPTED.replace('"a file"))', '"a file"), ReadLimits(seconds=1))').replace(
        "from odd_values", "from lappet.foreign.limits import ReadLimits\nfrom odd_values"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])}
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=environment) as reader:
        assert reader.stdout is not None
        child = int(reader.stdout.readline())
        time.sleep(1.0)  # it has to set its alarm
        reader.kill()
    end = time.monotonic() + 15.0
    while is_alive(child) and time.monotonic() < end:
        time.sleep(0.1)
    assert not is_alive(child)
