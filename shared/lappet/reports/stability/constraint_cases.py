"""Cases of what acts on the tissue: stiff and soft hooks and sutures, demands that fight each other, bone."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Incision, Retractor, Suture
from lappet.program.program import Program
from lappet.reports.stability.case import Case, Check, Scene, Solved
from lappet.reports.stability.scenes import (
    ABOVE,
    BELOW,
    LEFT,
    RIGHT,
    Pull,
    Vector,
    block,
    box_bone,
    compiled,
    moved,
    patch,
    procedure,
    stretched,
)

BLOCK: Vector = (12.0, 12.0, 6.0)
MIDDLE: Vector = (6.0, 6.0, 6.0)
GAP_LEFT = 1.5e-3  # mm that may be left open: the gap tolerance at a spacing of 1 mm, and what anchors spread
GAP, OUT_OF_REACH = ProblemCode.FRAME_GAP, ProblemCode.FRAME_UNREACHABLE
ENCLOSES_BONE, IN_BONE = ProblemCode.SOLVER_INVALID_INPUT, ProblemCode.FRAME_IN_BONE


def constraint_cases() -> Iterator[Case]:
    """List the groups stiffness, fights and bone.

    Yields
    ------
    Case
        The cases.
    """
    yield from _stiffness()
    yield from _fights()
    yield from _bone()


def _pulled(stiffness: float, lift: float = 2.0, **more: Any) -> Program:
    hook = (MIDDLE, (6.0, 6.0, 6.0 + lift), stiffness)
    return block(BLOCK, 1.5, fixed=(BELOW,), hooks=(hook,), **more)


def _hook_holds(stiffness: float) -> Check:
    """A check: the force is the spring's, to the gap tolerance where it is stiff, and the tissue gives way to it."""

    def check(solved: Solved) -> str:
        frame = solved.frames[-1]
        left = float(6.0 + 2.0 - frame.hook_points[0, 2])
        force = float(frame.hook_forces[0, 2])
        gap = 1e-3 * solved.program.settings.spacing if stiffness > 1e4 else 1e-6
        if not -gap <= left <= 2.0 + 1e-6:
            return f"The hook pulls its anchor to {2.0 - left:.3g} mm, not between 0 and 2 mm."
        return "" if math.isclose(force, stiffness * left, rel_tol=1e-3, abs_tol=gap * stiffness) else (
            f"A hook of {stiffness:g} mN/mm pulls with {force:.4g} mN over {left:.4g} mm."
        )  # fmt: skip

    return check


def _ends_meet(solved: Solved) -> str:
    """Check that both ends of each suture are at one place, and that this takes a force."""
    frame = solved.frames[-1]
    apart = float(np.linalg.norm(frame.suture_points[:, 1] - frame.suture_points[:, 0], axis=1).max())
    if apart > 0.1:
        return f"The ends of a suture that is closed are {apart:.2g} mm apart."
    return "" if frame.suture_forces.min() > 1.0 else f"A suture pulls with {frame.suture_forces.min():.2g} mN only."


def _thread_pulls(stiffness: float) -> Check:
    """A check: threads drawn to no length pull with stiffness times length, and bring their points nearer."""

    def check(solved: Solved) -> str:
        frame = solved.frames[-1]
        length = np.linalg.norm(frame.suture_points[:, 1] - frame.suture_points[:, 0], axis=1)
        off = float(np.abs(frame.suture_forces - stiffness * length).max())
        most = 0.02 * float(frame.suture_forces.max()) + stiffness * GAP_LEFT
        if off > most:
            pull = frame.suture_forces.max()
            return f"Threads of {stiffness:g} mN/mm and {length.max():.3g} mm pull with {pull:.3g} mN."
        return "" if length.max() < 3.2 else f"A thread has not drawn its points together: {length.max():.3g} mm."

    return check


def _slit(*events: Hook | Suture, gape: float = 3.0, end: float = 3.0, **suture: Any) -> Program:
    slit = Incision("slit", 1.0, ((-6.0, 0.0, 2.0), (6.0, 0.0, 2.0)), kerf=0.1)
    stitches = [
        Suture(f"stitch_{k}", ((x, -gape / 2, 2.0), (x, gape / 2, 2.0)), 2.0, 1.0, **suture)
        for k, x in enumerate((-3.0, 3.0))
    ]
    return compiled(procedure(patch(), slit, *stitches, *events, end=end))


def _stiffness() -> Iterator[Case]:
    for power in (-2, 0, 2, 4, 6, 8):
        stiffness = 10.0**power
        yield Case(
            f"hook of 10^{power} mN/mm", "stiffness", lambda k=stiffness: Scene(_pulled(k), check=_hook_holds(k))
        )
    for power in (-2, 0, 1, 2, 4, 6):
        yield Case(
            f"threads of 10^{power} mN/mm",
            "stiffness",
            lambda k=10.0**power: Scene(_slit(mode="thread", stiffness=k), check=_thread_pulls(k)),
        )
    for gape in (1.5, 3.0, 5.0, 7.0):
        yield Case(f"sutures across {gape:g} mm", "stiffness", lambda g=gape: Scene(_slit(gape=g), check=_ends_meet))
    yield Case(
        "hook of 10^8 mN/mm, double",
        "stiffness",
        lambda: Scene(_pulled(1e8, precision="double"), check=_hook_holds(1e8)),
    )
    yield Case("hook of 10^8 mN/mm beside one of 10^-2", "stiffness", lambda: _two_hooks(1e8, 1e-2))
    yield Case(
        "bed of 10^8 kPa/mm",
        "stiffness",
        lambda: compiled(procedure(patch(bed_stiffness=1e8, bed_shear=1e8), _lift(50.0))),
    )
    yield Case(
        "bed of 10^-8 kPa/mm",
        "stiffness",
        lambda: compiled(procedure(patch(bed_stiffness=1e-8, bed_shear=1e-8), _lift(50.0))),
    )


def _lift(stiffness: float, by: float = 2.0) -> Hook:
    return Hook("lift", (0.0, 4.0, 2.0), ((1.0, (0.0, 4.0, 2.0)), (3.0, (0.0, 4.0, 2.0 + by))), 1.0, 9.0, stiffness)


def _two_hooks(first: float, second: float) -> Program:
    hooks = (((3.0, 6.0, 6.0), (3.0, 6.0, 7.0), first), ((9.0, 6.0, 6.0), (9.0, 6.0, 7.0), second))
    return block(BLOCK, 1.5, fixed=(BELOW,), hooks=hooks)


def _fights() -> Iterator[Case]:
    yield Case("hooks fight 3 mm apart", "fights", lambda: _opposed(3.0, 2.0, 200.0))
    yield Case("hooks fight on one point", "fights", lambda: Scene(_opposed(0.0, 4.0, 200.0), check=_stays))
    yield Case("hooks of 10^6 mN/mm fight 3 mm apart", "fights", lambda: _opposed(3.0, 5.0, 1e6))
    yield Case("hooks cross over", "fights", lambda: _opposed(6.0, -6.0, 200.0))
    across = (((3.0, 6.0, 6.0), (9.0, 6.0, 6.0), 1000.0),)
    yield Case("suture over whole skin", "fights", lambda: block(BLOCK, 1.5, fixed=(BELOW,), sutures=across))
    held = (((0.0, 3.0, 3.0), (12.0, 3.0, 3.0), 1000.0),)
    yield Case(
        "suture between two held sides",
        "fights",
        lambda: block(BLOCK, 1.5, fixed=(LEFT, RIGHT), sutures=held),
        demands=GAP,
    )
    yield Case(
        "suture between what retractors pull apart",
        "fights",
        lambda: stretched(1.5, size=BLOCK, spacing=1.5, sutures=held),
        demands=GAP,
    )
    fan = (((6.0, 6.0, 6.0), (8.0, 6.0, 6.0), 1e3), ((6.0, 6.0, 6.0), (4.0, 6.0, 6.0), 1e3))
    yield Case("one point is sewn to two", "fights", lambda: block(BLOCK, 1.5, fixed=(BELOW,), sutures=fan))
    onto = (((6.0, 6.0, 6.0), (6.0, 6.0, 6.0), 1e3),)
    yield Case("a suture of a point to itself", "fights", lambda: block(BLOCK, 1.5, fixed=(BELOW,), sutures=onto))
    yield Case("sutures cross", "fights", _crossed)
    yield Case("hooks pull sutured edges apart", "fights", lambda: _pulled_apart(200.0))
    yield Case("hooks of 10^6 mN/mm pull sutured edges apart", "fights", lambda: _pulled_apart(1e6))
    fixed_hook = (((6.0, 6.0, 0.0), (6.0, 6.0, -4.0), 500.0),)
    yield Case("hook on a fixed face", "fights", lambda: block(BLOCK, 1.5, fixed=(BELOW,), hooks=fixed_hook))
    far = (((6.0, 6.0, 6.0), (6.0, 6.0, 1e6), 1e6),)
    yield Case(
        "hook with a target 1 km away",
        "fights",
        lambda: block(BLOCK, 1.5, fixed=(BELOW,), hooks=far),
        demands=OUT_OF_REACH,
    )
    yield Case("retractor turns its faces by 180° in 4", "fights", _turned)


def _opposed(apart: float, by: float, stiffness: float) -> Program:
    left, right = 6.0 - apart / 2, 6.0 + apart / 2
    hooks: tuple[Pull, ...] = (
        ((left, 6.0, 6.0), (left - by, 6.0, 6.0), stiffness),
        ((right, 6.0, 6.0), (right + by, 6.0, 6.0), stiffness),
    )
    return block(BLOCK, 1.5, fixed=(BELOW,), hooks=hooks)


def _crossed() -> Program:
    ends = ((-1.0, 1.0), (1.0, -1.0))
    pairs = [Suture(f"x_{k}", ((a, -1.5, 2.0), (b, 1.5, 2.0)), 2.0, 1.0) for k, (a, b) in enumerate(ends)]
    return _slit(*pairs)


def _pulled_apart(stiffness: float) -> Program:
    hooks = [
        Hook(f"pull_{k}", (0.0, y, 2.0), ((2.0, (0.0, y, 2.0)), (4.0, (0.0, 4.0 * y, 2.0))), 2.0, 9.0, stiffness)
        for k, y in enumerate((-1.0, 1.0))
    ]
    return _slit(*hooks, end=4.0)


def _stays(solved: Solved) -> str:
    off = float(abs(solved.frames[-1].hook_points[0] - MIDDLE).max())
    return "" if off < 0.02 else f"Equal hooks on one point move it by {off:.3g} mm."


def _turned() -> Program:
    tissue = patch()
    held = tissue.subsets["fixed"]
    subsets = {"fixed": held[6:], "bed": tissue.subsets["bed"], "jaw": held[:6]}
    samples = []
    for time, degrees in ((1.0, 0.0), (5.0, 180.0)):
        matrix = moved(turn=degrees, center=(0.0, 0.0, 1.0)).T
        samples.append((time, tuple(matrix.reshape(-1))))
    made = procedure(replace(tissue, subsets=subsets), Retractor("jaw", "jaw", tuple(samples), 1.0, 9.0), end=5.0)
    return compiled(made)


def _bone() -> Iterator[Case]:
    def above(top: float, **more: Any) -> Program:
        bone = box_bone((-4.0, -4.0, -4.0), (16.0, 16.0, top))
        return block(BLOCK, 1.5, bones=bone, **more)

    yield Case("bone 0.5 mm into tissue of 1.5 mm cells", "bone", lambda: above(0.5, fixed=(ABOVE,)))
    yield Case("bone 2 mm into tissue", "bone", lambda: above(2.0, fixed=(ABOVE,)), demands=ENCLOSES_BONE)
    yield Case(
        "bone through the whole tissue",
        "bone",
        lambda: above(20.0, fixed=(ABOVE,)),
        demands=ENCLOSES_BONE,
    )
    yield Case(
        "bone that the tissue encloses",
        "bone",
        lambda: block(BLOCK, 1.5, fixed=(BELOW,), bones=box_bone((4.0, 4.0, 1.0), (8.0, 8.0, 4.0))),
        demands=ENCLOSES_BONE,
    )

    def pressed(by: float) -> Program:
        motion = [[moved((0.0, 0.0, -by))]]
        return above(0.0, gripped=(ABOVE,), motions=motion)

    yield Case("tissue pressed by 20 % onto bone", "bone", lambda: pressed(1.2))
    yield Case("tissue pressed by 50 % onto bone", "bone", lambda: pressed(3.0))
    yield Case(
        "a face held by a retractor is carried into bone",
        "bone",
        lambda: block(
            BLOCK,
            1.5,
            fixed=(ABOVE,),
            gripped=(BELOW,),
            motions=[[moved((0.0, 0.0, -3.0))]],
            bones=box_bone((-4.0, -4.0, -6.0), (16.0, 16.0, -1.0)),
        ),
        demands=IN_BONE,
    )
    hook = ((6.0, 6.0, 0.0), (6.0, 6.0, -5.0), 500.0)
    yield Case("hook pulls into bone", "bone", lambda: above(-0.5, fixed=(ABOVE,), hooks=(hook,)))
