"""The hold-out set: scenes that no constant of the estimate was fitted on.

They are small, so that references at a quarter of a millimeter take seconds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.designs import Row, Schedule, Technique, flap_operation, fusiform, limberg
from lappet.procedure import Event, Excision, Hook, Incision, Material, Point, Procedure, Suture, Undermine
from lappet.procedure.stitches import Station, running
from lappet.program.program import Bones
from lappet.program.settings import MaterialParameters
from lappet.reports.box_scenes import BoxScene, grid_box, stretched
from lappet.reports.error_estimate.scene import SKIN, EstimateScene, box, layers_of, operation
from lappet.tissue.dome import dome_bone, dome_scalp, draped
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import skin_over_fat
from lappet.tissue.skin_sheet import SkinSheet

TOP = 3.0  # thickness of the patches in mm
BESIDE = 0.1  # mm from a cut to an anchor
# Operations of many frames, whose reference at 0.25 mm would take minutes.
OPERATED_AT, OPERATED_REFERENCE = (2.0, 1.75, 1.5), (1.5, 0.75, 0.375)


def _ring(radius: float, count: int = 24, center: tuple[float, float] = (0.0, 0.0)) -> tuple[Point, ...]:
    turn = 2.0 * np.pi * np.arange(count) / count
    return tuple((center[0] + radius * math.cos(t), center[1] + radius * math.sin(t), TOP) for t in turn)


def _polar(radius: float, degrees: float, center: tuple[float, float]) -> Point:
    turn = math.radians(degrees)
    return (center[0] + radius * math.cos(turn), center[1] + radius * math.sin(turn), TOP)


def _hanging_flap() -> EstimateScene:
    flap = ((8.0, -4.0, TOP), (-6.0, -4.0, TOP), (-6.0, 4.0, TOP), (8.0, 4.0, TOP))
    events = (Incision("flap", 2.0, flap), Undermine("freed", 2.0, flap))
    soft = (replace(SKIN, youngs_modulus=30.0),)
    return EstimateScene(
        "hanging-flap",
        "a flap of 14 x 8 mm is freed and hangs from its base, the patient prone",
        operation(flat_patch((28.0, 20.0, TOP)), *events, end=2.0, materials=soft),
        gravity=(0.0, 0.0, 9.81),
    )


def _released_hook() -> EstimateScene:
    flap = ((7.0, -4.0, TOP), (-7.0, -4.0, TOP), (-7.0, 4.0, TOP), (7.0, 4.0, TOP))
    anchor = (-5.5, 0.0, TOP)
    targets = ((2.0, anchor), (4.0, (-2.0, 0.0, TOP + 6.0)))
    events = (
        Incision("flap", 2.0, flap),
        Undermine("freed", 2.0, flap),
        Hook("hook", anchor, targets, 2.0, 5.0, 100.0),
    )
    taut = (replace(SKIN, prestretch=(1.12, 1.06)),)
    return EstimateScene(
        "released-hook",
        "a taut flap is lifted by a hook, which lets go",
        operation(flat_patch((28.0, 20.0, TOP)), *events, end=5.0, materials=taut),
    )


def _rotation_flap() -> EstimateScene:
    pivot, radius, wedge = (0.0, -6.0), 13.0, 20.0
    edge = [_polar(r, 90.0, pivot) for r in (3.0, radius)]
    far = [_polar(r, 90.0 + wedge, pivot) for r in (radius, 3.0)]
    arc = tuple(_polar(radius, 90.0 - turn, pivot) for turn in np.linspace(0.0, 75.0, 11))
    events: list[Event] = [
        Incision("defect", 2.0, (*edge, *far), closed=True),
        Incision("arc", 2.0, arc),
        Excision("excised", 2.0, (_polar(9.0, 90.0 + wedge / 2.0, pivot),)),
        Undermine("freed", 2.0, _ring(11.0, center=(2.0, 1.0))),
    ]
    for k, r in enumerate((5.0, 8.0, 10.5, 12.5)):
        turn = math.degrees(BESIDE / r)
        ends = (_polar(r, 90.0 - turn, pivot), _polar(r, 90.0 + wedge + turn, pivot))
        events.append(Suture(f"stitch_{k}", ends, 3.0, 3.0))
    return EstimateScene(
        "rotation-flap",
        "a rotation flap closes a wedge of 20° with four sutures",
        operation(flat_patch((36.0, 32.0, TOP)), *events, end=6.0),
        spacings=OPERATED_AT,
        reference=OPERATED_REFERENCE,
    )


def _v_y() -> EstimateScene:
    apex, arms = (-7.0, 0.0), (4.0, 5.0)
    v = ((arms[0], arms[1], TOP), (*apex, TOP), (arms[0], -arms[1], TOP))
    anchor = (3.0, 0.0, TOP)
    events: list[Event] = [
        Incision("v", 2.0, v),
        Undermine("freed", 2.0, _ring(10.0)),
        Hook("hook", anchor, ((2.0, anchor), (4.0, (6.0, 0.0, TOP))), 2.0, 9.0, 300.0),
    ]
    slope = arms[1] / (arms[0] - apex[0])
    for k, x in enumerate((-6.2, -4.6)):
        y = slope * (x - apex[0]) + BESIDE
        events.append(Suture(f"stem_{k}", ((x, y, TOP), (x, -y, TOP)), 4.0, 3.0))
    return EstimateScene(
        "v-y",
        "a V is advanced by 3 mm and sutured to a Y",
        operation(flat_patch((32.0, 26.0, TOP)), *events, end=7.0),
        spacings=OPERATED_AT,
        reference=OPERATED_REFERENCE,
    )


def _dome_flap() -> EstimateScene:
    radius = 40.0
    tissue = dome_scalp(radius, 20.0, TOP, resolution=2.0, spacing=1.0)
    design = limberg((0.0, 0.0, radius), (1.0, 0.0, 0.0), 6.0, project=draped(radius))
    when = Schedule(
        incise=2, excise=2, undermine=2, lift=2, carried=7, donor_from=7, donor_to=9, suture_from=8, suture_to=10,
        let_go=10, end=10,
    )  # fmt: skip
    how = Technique(beyond=5.0, apart=2.5, margin=1.5, rows=(Row("skin", 0.0),), height=4.0, inside=1.5)
    return EstimateScene(
        "dome-flap",
        "Limberg's flap with sides of 6 mm on a domed scalp over bone",
        operation(
            tissue, *flap_operation(design, SkinSheet.of(tissue), when, how), end=10.0, bones=(dome_bone(36.9, 24.0),)
        ),
        spacings=OPERATED_AT,
        reference=OPERATED_REFERENCE,
    )


def _fusiform_closure(name: str, what: str, *, threaded: bool) -> EstimateScene:
    """A fusiform of 20 x 5 mm, closed exactly beside its edges, or by one thread through bites 3 mm from them."""
    whole = fusiform((1.0, 0.0, TOP), 20.0, 5.0, (1.0, 0.0, 0.0), sutures=6)
    events: list[Event] = [
        Incision("around", 2.0, whole.curve, closed=True),
        Excision("excised", 2.0, (whole.seed,)),
        Undermine("freed", 2.0, tuple((1.0 + 1.4 * x, y, z) for x, y, z in _ring(9.0))),
    ]
    pairs = [((x, y), (u, v)) for (x, y, _), (u, v, _) in whole.pairs]
    if threaded:
        stations = [
            Station(((x + u) / 2.0, (y + v) / 2.0, TOP), (u - x, v - y, 0.0), gap=math.dist((x, y), (u, v)))
            for (x, y), (u, v) in pairs
        ]
        events.append(running(stations, 3.0).suture("thread", 3.0, 0.9, duration=3.0, thread="nylon 5-0"))
    else:
        for k, ends in enumerate(pairs):
            one, other = ((x, y + math.copysign(BESIDE, y), TOP) for x, y in ends)
            events.append(Suture(f"stitch_{k}", (one, other), 3.0, 3.0))
    return EstimateScene(name, what, operation(flat_patch((42.0, 30.0, TOP)), *events, end=6.0))


def _held_flap() -> EstimateScene:
    flap = ((8.0, -5.0, TOP), (-6.0, -4.0, TOP), (-6.0, 4.0, TOP), (8.0, 5.0, TOP))
    tip = [(-4.5, y, TOP) for y in (-2.5, 2.5)]
    events: list[Event] = [Incision("flap", 2.0, flap), Undermine("freed", 2.0, flap)]
    for k, (x, y, z) in enumerate(tip):
        events.append(Hook(f"hook_{k}", (x, y, z), ((2.0, (x, y, z)), (5.0, (x - 4.0, y, z + 2.0))), 2.0, 9.0, 300.0))
    return EstimateScene(
        "held-flap",
        "two hooks draw a flap of 14 x 8 mm forward by 4 mm",
        operation(flat_patch((34.0, 24.0, TOP)), *events, end=5.0),
    )


def _layered_closure() -> EstimateScene:
    whole = fusiform((0.0, 0.0, 4.0), 14.0, 4.0, (1.0, 0.0, 0.0), sutures=5)
    area = tuple((11.0 * x / 11.0, 7.0 * y / 11.0, 4.0) for x, y, _ in _ring(11.0))
    events: list[Event] = [
        Incision("around", 2.0, whole.curve, closed=True),
        Excision("excised", 2.0, (whole.seed,)),
        Undermine("freed", 2.0, area),
    ]
    for k, (one, other) in enumerate(whole.pairs):
        ends = tuple((x, y + math.copysign(BESIDE, y), z) for x, y, z in (one, other))
        events.append(Suture(f"stitch_{k}", (ends[0], ends[1]), 3.0, 3.0))
    tissue = flat_patch((30.0, 22.0, 4.0))
    layered = skin_over_fat(
        Procedure(tissue=tissue, materials=(SKIN,)),
        1.4,
        replace(SKIN, youngs_modulus=150.0),
        Material("fat", model="neoHookean", youngs_modulus=8.0, poissons_ratio=0.45),
    )
    return EstimateScene(
        "layered-closure",
        "a fusiform is excised from 1.4 mm of skin on fat, and closed",
        operation(layered.tissue, *events, end=6.0, materials=layered.materials),
        spacings=OPERATED_AT,
        reference=OPERATED_REFERENCE,
    )


def _taut_excision() -> EstimateScene:
    ring = _ring(3.5, 20, (1.0, 0.5))
    events = (
        Incision("around", 2.0, ring, closed=True),
        Excision("excised", 2.0, ((1.0, 0.5, TOP),)),
        Undermine("freed", 2.0, _ring(8.0)),
    )
    taut = (replace(SKIN, prestretch=(1.25, 1.1), fiber_direction=(0.8, 0.6, 0.0)),)
    return EstimateScene(
        "taut-excision",
        "a disk is excised from taut skin, and the wound gapes",
        operation(flat_patch((26.0, 22.0, TOP)), *events, end=2.0, materials=taut),
    )


SIZE, DIVISIONS = (32.0, 8.0, 8.0), (16, 4, 4)
FIBERS = MaterialParameters(youngs_modulus=50.0, poissons_ratio=0.45, fiber_k1=100.0, fiber_k2=1.0)


def _lifted(x: float, z: float) -> NDArray[np.float64]:
    motion = stretched(x)
    motion[2, 3] = z
    return motion


def _bar(name: str, what: str, material: MaterialParameters, x: float, z: float) -> BoxScene:
    return BoxScene(name, what, SIZE, DIVISIONS, (0,), gripped=(1,), motion=_lifted(x, z), material=material)


def _fiber_bar(name: str, what: str, **changes: Any) -> EstimateScene:
    return EstimateScene(name, what, box(_bar(name, what, replace(FIBERS, **changes), 4.0, 3.0)))


def _muscle_bar() -> EstimateScene:
    what = "a bar with one end held, its muscle along it fully active"
    muscle = MaterialParameters(youngs_modulus=30.0, poissons_ratio=0.45, muscle_stress=60.0)
    scene = BoxScene("muscle-bar", what, SIZE, DIVISIONS, (0,), material=muscle)
    return EstimateScene("muscle-bar", what, box(scene, activation=1.0))


def _muscle_plate() -> EstimateScene:
    what = "a plate of 27 x 9.5 x 7 mm with one end held, its oblique muscle partly active"
    direction = (0.8, 0.36, 0.48)
    muscle = MaterialParameters(youngs_modulus=25.0, muscle_stress=40.0, fiber_direction=direction)
    scene = BoxScene("muscle-plate", what, (27.0, 9.5, 7.0), (14, 5, 4), (0,), material=muscle)
    return EstimateScene("muscle-plate", what, box(scene, activation=0.7))


def _strip_over_bone() -> EstimateScene:
    what = "a strip 3.3 mm thick is drawn down on both sides of a ridge of bone"
    size = (32.0, 10.0, 3.3)
    scene = BoxScene(
        "strip-over-bone",
        what,
        size,
        (16, 5, 2),
        (),
        gripped=(0, 1),
        motion=_lifted(0.0, -3.5),
        material=MaterialParameters(),
    )
    ridge, _ = grid_box((10.0, 30.0, 4.0), (1, 1, 1))
    bone = ridge.points + np.array([11.0, -10.0, -4.15])
    # The upper edges of the ridge are beveled.
    bevel = np.where(bone[:, 2] > -2.0, 2.0 * np.sign(16.0 - bone[:, 0]), 0.0)
    bone[:, 0] += bevel
    return EstimateScene("strip-over-bone", what, box(scene, bones=Bones(bone, ridge.triangles)))


def _punch() -> EstimateScene:
    what = "a disk of 5 mm is pressed 1 mm into 0.8 mm of stiff skin over soft fat"
    size, divisions = (20.0, 20.0, 5.0), (20, 20, 5)
    skin = MaterialParameters(youngs_modulus=500.0, poissons_ratio=0.45)
    fat = MaterialParameters(youngs_modulus=10.0, poissons_ratio=0.45)
    scene = BoxScene("punch", what, size, divisions, (4,), gripped=(5,), motion=_lifted(0.0, -1.0), material=skin)

    def disk(center: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.hypot(center[:, 0] - 10.0, center[:, 1] - 10.0) < 2.5

    return EstimateScene(
        "punch", what, box(scene, layers=layers_of(size, divisions, 0.8), materials=(skin, fat), grip=disk)
    )


def hold_out_scenes() -> tuple[EstimateScene, ...]:
    """List the scenes.

    Returns
    -------
    tuple[EstimateScene, ...]
        The scenes, operations first.
    """
    return (
        _hanging_flap(),
        _rotation_flap(),
        _v_y(),
        _dome_flap(),
        _layered_closure(),
        _fusiform_closure(
            "fusiform-closure", "a fusiform of 20 x 5 mm is closed exactly at six places", threaded=False
        ),
        _fusiform_closure("running-closure", "the fusiform is closed by a running suture", threaded=True),
        _held_flap(),
        _released_hook(),
        _taut_excision(),
        _fiber_bar("stiff-fibers", "a bar with fibers of 100 kPa along it, drawn by 4 mm and lifted by 3 mm"),
        _fiber_bar("soft-fibers", "the bar with fibers of 10 kPa that stiffen", fiber_k1=10.0, fiber_k2=5.0),
        _muscle_bar(),
        _muscle_plate(),
        _strip_over_bone(),
        _punch(),
    )
