"""Chaos: a procedure is solved again and again while it is killed, stopped, interrupted, filled, cut and pruned.

`make chaos` does so for two minutes and keeps the result (`docs/robustness.md`). `python tests/chaos.py --seed 1
--seconds 120` says what a seed did and which promise was broken. After every disturbed solve no partial file has a
final name, nothing of it runs on and none of its temporary files is left; an undisturbed solve then gives, bit for
bit, the cache of a solve that was never disturbed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from lappet.usd.stage import write_procedure
from small_procedure import small_procedure

MARK = "LAPPET_CHAOS"  # in the environment of everything that a solve starts
LONGEST = 120.0  # s, of a solve on a busy machine
GONE_WITHIN = 20.0  # s, until nothing of a solve runs on
STATUSES = {0, 1, 130, -signal.SIGINT}  # done, refused, interrupted


@dataclass
class Place:
    """A procedure with its store, its output and its temporary files, and the cache that it must give."""

    folder: Path
    mark: str = field(default_factory=lambda: uuid.uuid4().hex)
    expected: bytes = b""

    def __post_init__(self) -> None:
        for name in ("store", "out", "t"):
            (self.folder / name).mkdir(mode=0o700)
        write_procedure(small_procedure(), self.procedure)

    @property
    def procedure(self) -> Path:
        return self.folder / "p.usda"

    @property
    def store(self) -> Path:
        return self.folder / "store"

    @property
    def cache(self) -> Path:
        return self.folder / "out" / "c.usdc"

    @property
    def report(self) -> Path:
        return self.folder / "out" / "r.json"

    @property
    def temporary(self) -> Path:
        return self.folder / "t"

    def start(self) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "lappet", "solve", self.procedure, "-o", self.cache, "--report", self.report]
        return subprocess.Popen(
            [*map(str, command), "--store", str(self.store)],
            env={**os.environ, MARK: self.mark, "TMPDIR": str(self.temporary)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def processes(self) -> dict[int, str]:
        """What runs of a solve: the name of each process by its number."""
        found = {}
        for process in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if f"{MARK}={self.mark}\0".encode() in (process / "environ").read_bytes():
                    found[int(process.name)] = (process / "comm").read_text().strip()
        return found

    def daemons(self) -> list[int]:
        return [number for number, name in self.processes().items() if name.startswith("lappet-solverd")]

    def frames(self) -> list[Path]:
        return sorted(path for path in self.store.rglob("*") if path.is_file())


@dataclass
class Disturbed:
    """A solve that runs and is disturbed."""

    place: Place
    client: subprocess.Popen[str]
    random: random.Random
    put: bytes | None = None  # what lay under the cache's name before

    def wait_a_moment(self, longest: float = 2.0) -> None:
        end = time.monotonic() + self.random.uniform(0.0, longest)
        while time.monotonic() < end and self.client.poll() is None:
            time.sleep(0.01)

    def signal_daemon(self, number: int) -> None:
        """Send a signal to the daemon, once there is one."""
        end = time.monotonic() + 20.0
        while not (found := self.place.daemons()) and self.client.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        self.wait_a_moment(0.6)
        for process in found:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, number)

    def signal_client(self, number: int) -> None:
        if self.client.poll() is None:
            self.client.send_signal(number)


def kill_daemon(run: Disturbed) -> None:
    for _ in range(run.random.randint(1, 2)):
        run.signal_daemon(signal.SIGKILL)


def kill_client(run: Disturbed) -> None:
    run.wait_a_moment()
    run.signal_client(signal.SIGKILL)


def kill_both(run: Disturbed) -> None:
    run.signal_daemon(signal.SIGKILL)
    run.signal_client(signal.SIGKILL)


def stop_daemon(run: Disturbed) -> None:
    run.signal_daemon(signal.SIGSTOP)
    run.wait_a_moment(3.0)
    run.signal_daemon(signal.SIGCONT)


def stop_client(run: Disturbed) -> None:
    run.wait_a_moment()
    run.signal_client(signal.SIGSTOP)
    time.sleep(run.random.uniform(0.0, 2.0))
    run.signal_client(signal.SIGCONT)


def interrupt(run: Disturbed) -> None:
    for _ in range(run.random.randint(1, 3)):
        run.wait_a_moment()
        run.signal_client(signal.SIGINT)


def fill(run: Disturbed) -> None:
    """No file of the solve grows beyond some bytes from a moment on."""
    run.wait_a_moment(1.0)
    most = run.random.choice((0, 100, 2_000, 20_000))
    with contextlib.suppress(ProcessLookupError, PermissionError):
        resource.prlimit(run.client.pid, resource.RLIMIT_FSIZE, (most, resource.RLIM_INFINITY))


def cut(run: Disturbed) -> None:
    """Stored frames, and now and then the store's secret, lose their ends while they are looked up."""
    run.wait_a_moment(1.0)
    for path in run.random.sample(frames := run.place.frames(), min(len(frames), run.random.randint(1, 4))):
        with contextlib.suppress(OSError):
            os.truncate(path, run.random.randint(0, path.stat().st_size))


def prune(run: Disturbed) -> None:
    """Stored frames, or whole folders of them, vanish."""
    for _ in range(run.random.randint(1, 4)):
        run.wait_a_moment(0.5)
        for path in run.random.sample(frames := run.place.frames(), min(len(frames), 3)):
            if run.random.random() < 0.3 and path.parent != run.place.store:
                shutil.rmtree(path.parent, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)


DISTURBANCES: dict[str, Callable[[Disturbed], None]] = {
    each.__name__: each
    for each in (kill_daemon, kill_client, kill_both, stop_daemon, stop_client, interrupt, fill, cut, prune)
}
KILLED = {"kill_client", "kill_both"}  # what the client writes to has another name, and nobody is left to remove it


@dataclass
class Chaos:
    """What was done and what was broken by it."""

    seed: int
    done: Counter[str] = field(default_factory=Counter)
    statuses: Counter[int] = field(default_factory=Counter)
    broken: list[str] = field(default_factory=list)

    def fault(self, kind: str, sentence: str) -> None:
        self.broken.append(f"seed {self.seed}, round {self.done.total()}, {kind}: {sentence}")


def undisturbed(place: Place) -> tuple[int, str]:
    """Solve to the end; the status and what was said."""
    client = place.start()
    _, said = client.communicate(timeout=LONGEST)
    return client.returncode, said


def check_left(place: Place, kind: str, chaos: Chaos, before: bytes | None) -> None:
    """Check what a disturbed solve leaves: no process, no partial file, no temporary file."""
    end = time.monotonic() + GONE_WITHIN
    while (running := place.processes()) and time.monotonic() < end:
        time.sleep(0.05)
    if running:
        chaos.fault(kind, f"{running} run on")
        for process in running:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
    found = place.cache.read_bytes() if place.cache.exists() else None
    if found not in (None, before, place.expected):
        chaos.fault(kind, f"the cache has {len(found or b'')} bytes that are not those of a whole one")
    if place.report.exists():
        try:
            json.loads(place.report.read_text())
        except ValueError as error:
            chaos.fault(kind, f"the report is not whole: {error}")
    others = {path.name for path in place.cache.parent.iterdir()} - {place.cache.name, place.report.name}
    if kind not in KILLED:
        if others:
            chaos.fault(kind, f"beside the cache lie {sorted(others)}")
        if left := sorted(path.name for path in place.temporary.iterdir()):
            chaos.fault(kind, f"among the temporary files lie {left}")
    elif kind == "kill_client" and list(place.temporary.glob("lappet-*/socket")):
        chaos.fault(kind, "a daemon ended and left its socket")
    for path in [*place.temporary.iterdir(), *(place.cache.parent / name for name in others)]:
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def play_round(place: Place, kind: str, chaos: Chaos, choose: random.Random) -> None:
    """Disturb a solve, check what it leaves, and solve to the end."""
    if choose.random() < 0.5:
        shutil.rmtree(place.store)
        place.store.mkdir(mode=0o700)
    place.report.unlink(missing_ok=True)
    before = None
    if choose.random() < 0.5:
        place.cache.unlink(missing_ok=True)
    elif place.cache.exists() and choose.random() < 0.5:  # one that was cut is replaced, or stays as it was
        before = place.expected[: choose.randint(0, len(place.expected))]
        place.cache.write_bytes(before)
    client = place.start()
    DISTURBANCES[kind](Disturbed(place, client, choose))
    try:
        _, said = client.communicate(timeout=LONGEST)
    except subprocess.TimeoutExpired:
        client.kill()
        _, said = client.communicate()
        chaos.fault(kind, f"the solve took longer than {LONGEST:g} s")
    chaos.done[kind] += 1
    chaos.statuses[client.returncode] += 1
    if client.returncode not in STATUSES | ({-signal.SIGKILL} if kind in KILLED else set()) or "Traceback" in said:
        chaos.fault(kind, f"the solve ended with status {client.returncode}: {said[-600:]}")
    check_left(place, kind, chaos, before)
    status, said = undisturbed(place)
    if status != 0:
        chaos.fault(kind, f"the solve after it ended with status {status}: {said[-600:]}")
    elif place.cache.read_bytes() != place.expected:
        chaos.fault(kind, "the solve after it gave another cache")


def kinds(choose: random.Random) -> Iterator[str]:
    """Every disturbance once in an order of the seed's, then any."""
    yield from choose.sample(list(DISTURBANCES), len(DISTURBANCES))
    while True:
        yield choose.choice(list(DISTURBANCES))


def chaos(folder: Path, seed: int, seconds: float) -> Chaos:
    """Disturb solves for so many seconds."""
    result, choose, end = Chaos(seed), random.Random(seed), time.monotonic() + seconds
    place = Place(folder)
    status, said = undisturbed(place)
    assert status == 0, said
    place.expected = place.cache.read_bytes()
    for kind in kinds(choose):
        if time.monotonic() > end:
            break
        play_round(place, kind, result, choose)
    return result


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--result", type=Path, help="write there, as JSON, what was done and what was broken")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="chaos-") as folder:
        found = chaos(Path(folder), given.seed, given.seconds)
    print(f"{found.done.total()} disturbed solves of seed {given.seed}: {dict(found.done)}")
    print(f"their statuses: {dict(found.statuses)}")
    for line in found.broken:
        print(f"  {line}")
    print(f"{len(found.broken)} promises broken")
    if given.result is not None:
        kept = {
            "date": datetime.now(UTC).date().isoformat(),
            "seed": given.seed,
            "seconds": round(given.seconds),
            "solves": found.done.total(),
            "disturbances": dict(sorted(found.done.items())),
            "broken": found.broken,
        }
        given.result.write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")
    return 1 if found.broken else 0


if __name__ == "__main__":
    sys.exit(main())
