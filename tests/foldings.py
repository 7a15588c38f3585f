"""Foldings: flaps of any shape are cut and folded at random onto themselves, each other and what lies around them.

`make foldings` plays 500 of them with self-contact and keeps the result (`docs/robustness.md`). `python
tests/foldings.py --seed 1 --count 20` says what a seed did. The IPC Toolkit (Li et al. 2020), which shares nothing with
the daemon, looks at the surface of every frame, of those too in which the solver did not converge: an edge that goes
through a face breaks the promise. One folding in ten is played again without self-contact, to tell how often there is
something to keep apart.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import ProblemsError, RefusedError
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.procedure import Event, Hook, Incision, Material, Point, Procedure, Suture, Undermine
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from self_intersection import passes_through_itself

SIZE = (36.0, 28.0, 3.0)  # mm
MARGIN = 3.0  # mm from a flap to the rim
END = 6  # frames
CONTROLS = 10  # one folding in so many is played without self-contact too


@dataclass(frozen=True)
class Tongue:
    """A flap in the plane of the skin: its base's middle, the way from there to its tip, length and width in mm."""

    base: NDArray[np.float64]
    way: NDArray[np.float64]
    length: float
    width: float

    def __call__(self, along: float, across: float) -> NDArray[np.float64]:
        """A point by shares of length and half of the width, shape (2,)."""
        side = np.array([-self.way[1], self.way[0]])
        return self.base + along * self.length * self.way + 0.5 * across * self.width * side

    def outline(self, beyond: float = 0.0) -> NDArray[np.float64]:
        """From base to base around the tip, so many mm beyond it, shape (4, 2)."""
        more = np.array([[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]])
        side = np.array([-self.way[1], self.way[0]])
        return np.array([self(*at) + beyond * (at[0] * self.way + at[1] * side) for at in more])


def random_tongues(choose: random.Random) -> list[Tongue]:
    """One flap or two that lie apart, inside the patch."""
    wanted, found = choose.choice((1, 1, 2)), list[Tongue]()
    inside = np.array(SIZE[:2]) / 2.0 - MARGIN
    while len(found) < wanted:
        angle = choose.uniform(0.0, math.tau)
        middle = np.array([choose.uniform(-x, x) for x in inside])
        way = np.array([math.cos(angle), math.sin(angle)])
        flap = Tongue(middle, way, choose.uniform(8.0, 15.0), choose.uniform(4.0, 9.0))
        at = flap.outline()
        if np.any(np.abs(at) > inside) or any(_near(at, other.outline()) for other in found):
            continue
        found.append(flap)
    return found


def _near(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether two rectangles are less than a margin apart, by their sides' directions."""
    for corners in (one, other):
        for side in (corners[1] - corners[0], corners[2] - corners[1]):
            axis = side / np.linalg.norm(side)
            a, b = one @ axis, other @ axis
            if a.min() - b.max() > MARGIN or b.min() - a.max() > MARGIN:
                return False
    return True


def folded(choose: random.Random, name: str, flap: Tongue) -> Hook:
    """A hook that takes a place of a flap about an axis across it, and somewhat aside, to the skin or below it."""
    along, across = choose.uniform(0.5, 0.95), choose.uniform(-0.7, 0.7)
    fold = choose.uniform(0.0, along - 0.3)
    start, pivot = flap(along, across), flap(fold, across)
    angle, aside = choose.uniform(0.5, 1.1) * math.pi, [choose.uniform(-3.0, 3.0) for _ in range(2)]
    reach, height = float(np.linalg.norm(start - pivot)), choose.uniform(-2.0, 3.0)
    targets = []
    for frame in range(1, END):
        share = min(1.0, (frame - 1) / (END - 3))
        turned = share * angle
        x, y = pivot + reach * math.cos(turned) * flap.way + share * np.array(aside)
        targets.append((float(frame), (float(x), float(y), SIZE[2] + reach * math.sin(turned) + share**2 * height)))
    return Hook(
        name,
        _on_skin(start),
        tuple(targets),
        1.0,
        float(choose.choice((END - 1, END + 1))),
        choose.choice((30.0, 300.0, 3000.0)),
    )


def _on_skin(at: NDArray[np.float64]) -> Point:
    return (float(at[0]), float(at[1]), SIZE[2])


def random_folding(seed: int) -> Procedure:
    """Cut, undermine and fold one flap or two."""
    choose = random.Random(seed)
    flaps, events = random_tongues(choose), list[Event]()
    for k, flap in enumerate(flaps):
        ring = np.vstack([flap.outline(1.5), flap.outline()[[3, 0]]])
        events.append(Incision(f"cut_{k}", 1.0, tuple(map(_on_skin, flap.outline()))))
        events.append(Undermine(f"freed_{k}", 1.0, tuple(map(_on_skin, ring))))
        events.extend(folded(choose, f"hook_{k}_{h}", flap) for h in range(choose.choice((1, 1, 2))))
    if choose.random() < 0.3:  # two places of the skin are drawn together through what lies between
        ends = (_on_skin(flaps[0](choose.uniform(0.5, 0.9), 0.0)), _on_skin(flaps[-1](choose.uniform(0.0, 0.4), 0.5)))
        events.append(Suture("stitch", ends, float(END - 2), 2.0, choose.choice((30.0, 300.0)), mode="thread"))
    tissue = flat_patch(SIZE, resolution=2.0, spacing=choose.choice((1.5, 2.0)), gravity=0.0)
    return Procedure(tissue=tissue, materials=(Material(),), events=tuple(events), start_time=1.0, end_time=float(END))


@dataclass
class Campaign:
    """What was folded and what passed through itself."""

    seed: int
    foldings: int = 0
    refused: int = 0
    frames: int = 0
    touching: int = 0  # frames in which tissue presses on tissue
    ends: Counter[str] = field(default_factory=Counter)  # of foldings whose last frame did not converge
    unexplained: list[str] = field(default_factory=list)
    controls: int = 0
    controls_through: int = 0
    through: list[str] = field(default_factory=list)


def compiled(procedure: Procedure, self_contact: bool) -> Program:
    settings = SolverSettings(spacing=procedure.tissue.spacing, strain=False, self_contact=self_contact)
    return compile_program(procedure, settings=settings)


def surfaces(program: Program, campaign: Campaign | None = None) -> Iterator[tuple[float, bool]]:
    """Solve; each frame's time and whether it passes through itself, the one that did not converge too."""
    with tempfile.TemporaryDirectory(prefix="folding-") as folder:
        found = solve_program(
            program, FrameStore(Path(folder)), connect_to(None), solver_identity(None), SolveObserver()
        )
    triangles = {epoch.index: epoch.surface.triangles for epoch in program.epochs}
    frames = [*found.frames, *([] if found.failed is None else [found.failed])]
    for frame in frames:
        yield (
            frame.constraints.time,
            passes_through_itself(frame.solved.points, triangles[frame.constraints.epoch]),
        )
    if campaign is None:
        return
    campaign.frames += len(frames)
    campaign.touching += sum(frame.solved.diagnostics.self_contacts > 0 for frame in frames)
    if found.failed is not None:
        campaign.ends[found.failed.solved.diagnostics.reason_code] += 1
    elif found.reason is not None:
        campaign.unexplained.append(str(found.reason))


def play(campaign: Campaign, number: int) -> bool:
    """Play one folding; False where the procedure is refused."""
    try:
        procedure = random_folding(number)
        program = compiled(procedure, True)
    except (RefusedError, ProblemsError):
        campaign.refused += 1
        return False
    campaign.foldings += 1
    for at, through in surfaces(program, campaign):
        if through:
            campaign.through.append(f"folding {number} passes through itself at frame {at:g}")
    if campaign.foldings % CONTROLS == 0:
        campaign.controls += 1
        campaign.controls_through += any(through for _, through in surfaces(compiled(procedure, False)))
    return True


def foldings(seed: int, count: int) -> Campaign:
    """Play so many foldings."""
    campaign, numbers = Campaign(seed), random.Random(seed)
    while campaign.foldings < count:
        play(campaign, numbers.getrandbits(32))
    return campaign


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--result", type=Path, help="write there, as JSON, what was folded and what passed through")
    given = parser.parse_args()
    begun = time.monotonic()
    found = foldings(given.seed, given.count)
    kept = {
        "date": datetime.now(UTC).date().isoformat(),
        "seconds": round(time.monotonic() - begun),
        **{name: value for name, value in vars(found).items() if name != "ends"},
        "ends": dict(sorted(found.ends.items())),
    }
    print(json.dumps(kept, indent=2))
    if given.result is not None:
        given.result.write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")
    return 1 if found.through or found.unexplained else 0


if __name__ == "__main__":
    sys.exit(main())
