"""Several clients in one daemon: does each get every bit that a lone client gets?

`python tests/several_clients.py --clients 8 --frames 10000` runs for as long as it takes and says how many differed.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from dataclasses import dataclass, field

import numpy as np

from box_scene import box, pull
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import SolverClient
from lappet.daemon.process import SolverDaemon
from lappet.daemon.solver_state import SolverState
from lappet.program.program import FrameConstraints
from lappet.program.settings import SolverSettings

SIZE = (14.0, 14.0, 4.0)  # mm; its coarse matrix has supernodes of more than a hundred columns
STEPS = 5  # frames until a client starts over


@dataclass
class Comparison:
    """How many frames were solved, and which were not what a lone client got."""

    solved: int = 0
    differing: list[str] = field(default_factory=list)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def add(self, name: str, difference: str | None) -> None:
        with self.lock:
            self.solved += 1
            if difference is not None:
                self.differing.append(f"{name}: {difference}")


def frame(step: int) -> FrameConstraints:
    """The hook of the box, moved to the middle of this one's top and farther with each step."""
    hook = pull(1.0 + step)
    anchor = np.array([[SIZE[0] / 2, SIZE[1] / 4, SIZE[2]]])
    target = anchor + np.array([0.3 * step, 0.1 * step, 0.5 + 0.4 * step])
    return FrameConstraints(
        hook.time,
        0,
        hook_index=hook.hook_index,
        hook_anchors=anchor,
        hook_triangles=hook.hook_triangles,
        hook_targets=target,
        hook_stiffness=np.array([200.0]),
    )


def begun(client: SolverClient) -> SolverState:
    """A session with its epoch, and the state that every run of frames begins with."""
    client.open(SolverSettings(spacing=1.0, threads=1, memory_budget=1 << 28))
    client.set_epoch(Epoch(0, 1.0, box(SIZE), 1))
    state = client.solve(FrameConstraints(0.5, 0)).state
    assert state is not None
    return state


def run_of_frames(client: SolverClient, start: SolverState) -> list[dict[str, bytes]]:
    """Every array of each frame of a run, as bytes."""
    client.set_state(start)
    found = []
    for step in range(STEPS):
        solved = client.solve(frame(step))
        assert solved.converged, solved.diagnostics
        found.append({name: array.tobytes() for name, array in solved.arrays().items()})
    return found


def compare(daemon: SolverDaemon, clients: int, frames: int) -> Comparison:
    """Solve `frames` frames with so many clients at once, each against what a lone client got before."""
    with SolverClient(daemon=daemon) as alone:
        expected = run_of_frames(alone, begun(alone))
    comparison = Comparison()
    failures: list[BaseException] = []

    def solve_often(name: str) -> None:
        try:
            with SolverClient(daemon.address, daemon.token) as client:
                start = begun(client)
                for _ in range(frames // (clients * STEPS) + 1):
                    for step, (found, wanted) in enumerate(zip(run_of_frames(client, start), expected, strict=True)):
                        wrong = [array for array in wanted if found[array] != wanted[array]]
                        comparison.add(name, f"step {step}: {', '.join(wrong)}" if wrong else None)
        except BaseException as error:  # a thread's failure is the test's
            failures.append(error)

    threads = [threading.Thread(target=solve_often, args=(f"client {k}",)) for k in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]
    return comparison


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--clients", type=int, default=8)
    parser.add_argument("--frames", type=int, default=10_000)
    given = parser.parse_args()
    start = time.monotonic()
    with SolverDaemon(arguments=("--max-clients", str(given.clients + 1))) as daemon:
        found = compare(daemon, given.clients, given.frames)
    seconds = time.monotonic() - start
    print(f"{found.solved} frames, {given.clients} clients, {seconds:.1f} s: {len(found.differing)} differ")
    for line in found.differing[:20]:
        print(f"  {line}")
    return 1 if found.differing else 0


if __name__ == "__main__":
    sys.exit(main())
