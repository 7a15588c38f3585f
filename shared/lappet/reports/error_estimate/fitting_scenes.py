"""The scenes that the estimate's constants were fitted on; none of them is in the hold-out set."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lappet.designs import Row, Schedule, Technique, flap_operation, limberg
from lappet.procedure import Event, Excision, Hook, Incision, Material, Point, Procedure, Suture, Tissue, Undermine
from lappet.procedure.stitches import Station, running
from lappet.program.program import Bones
from lappet.program.settings import MaterialParameters
from lappet.reports.box_scenes import BOXES, BoxScene, grid_box, stretched
from lappet.reports.error_estimate.scene import SKIN, EstimateScene, box, layers_of, operation
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import skin_over_fat
from lappet.tissue.skin_sheet import SkinSheet

SIZE, DIVISIONS = (24.0, 8.0, 8.0), (12, 4, 4)
TOP = 4.0


def _oval(x: float, y: float, top: float = TOP, count: int = 24) -> tuple[Point, ...]:
    turn = 2.0 * np.pi * np.arange(count) / count
    return tuple((x * math.cos(t), y * math.sin(t), top) for t in turn)


def _fibers() -> list[EstimateScene]:
    found = []
    for k1, k2, direction in (
        (40.0, 1.0, (1.0, 0.0, 0.0)),
        (250.0, 1.0, (0.6, 0.0, 0.8)),
        (15.0, 2.0, (0.8, 0.6, 0.0)),
    ):
        material = MaterialParameters(fiber_k1=k1, fiber_k2=k2, fiber_direction=direction)
        name = f"fiber-cantilever-{k1:g}"
        scene = BoxScene(name, name, SIZE, DIVISIONS, (0,), gravity=9.81, material=material)
        found.append(EstimateScene(name, name, box(scene), gravity=(0.0, 0.0, -9.81)))
        name = f"fiber-block-{k1:g}"
        motion = stretched(1.5)
        motion[2, 3] = 2.0
        block = BoxScene(
            name, name, (12.0, 12.0, 12.0), (6, 6, 6), (4,), gripped=(5,), motion=motion, material=material
        )
        found.append(EstimateScene(name, name, box(block)))
    return found


def _stretched() -> list[EstimateScene]:
    found = []
    bars: tuple[tuple[str, dict[str, Any], float], ...] = (
        ("plain-bar", {}, 4.0),
        ("fiber-bar-30", {"fiber_k1": 30.0, "fiber_k2": 1.0}, 4.0),
        ("fiber-bar-200", {"fiber_k1": 200.0, "fiber_k2": 1.0}, 2.0),
        ("fiber-bar-5", {"fiber_k1": 5.0, "fiber_k2": 8.0}, 6.0),
    )
    for name, changes, by in bars:
        material = MaterialParameters(**changes)
        scene = BoxScene(
            name, name, (20.0, 10.0, 6.0), (10, 5, 3), (0,), gripped=(1,), motion=stretched(by), material=material
        )
        found.append(EstimateScene(name, name, box(scene)))
    return found


def _muscles() -> list[EstimateScene]:
    found = []
    for stress, active, direction in ((30.0, 0.6, (1.0, 0.0, 0.0)), (80.0, 0.5, (0.8, 0.0, 0.6))):
        material = MaterialParameters(youngs_modulus=40.0, muscle_stress=stress, fiber_direction=direction)
        name = f"muscle-block-{stress:g}"
        scene = BoxScene(name, name, (16.0, 12.0, 6.0), (8, 6, 3), (0,), material=material)
        found.append(EstimateScene(name, name, box(scene, activation=active)))
    return found


def _layered() -> list[EstimateScene]:
    found = []
    for depth, stiff, soft in ((1.3, 200.0, 20.0), (0.6, 400.0, 8.0)):
        materials = (MaterialParameters(youngs_modulus=stiff), MaterialParameters(youngs_modulus=soft))
        name = f"layered-cantilever-{depth:g}"
        size, divisions = (20.0, 8.0, 4.0), (20, 8, 4)
        scene = BoxScene(name, name, size, divisions, (0,), material=materials[0])
        layers = layers_of(size, divisions, depth)
        found.append(
            EstimateScene(name, name, box(scene, layers=layers, materials=materials), gravity=(0.0, 0.0, -2.0))
        )
        name = f"layered-shear-{depth:g}"
        motion = stretched(1.5)
        scene = BoxScene(name, name, size, divisions, (4,), gripped=(5,), motion=motion, material=materials[0])
        found.append(
            EstimateScene(
                name,
                name,
                box(scene, layers=layers, materials=materials, grip=lambda at: (at[:, 0] > 6.0) & (at[:, 0] < 11.0)),
            )
        )
    return found


def _over_bone() -> list[EstimateScene]:
    name = "plate-on-bone"
    scene = BoxScene(
        name, name, (20.0, 12.0, 2.7), (10, 6, 2), (0,), gripped=(1,), motion=_down(-3.0), material=MaterialParameters()
    )
    ball, _ = grid_box((6.0, 40.0, 5.0), (1, 1, 1))
    points = ball.points + np.array([5.3, -14.0, -5.2])
    return [EstimateScene(name, name, box(scene, bones=Bones(points, ball.triangles)))]


def _down(z: float) -> np.ndarray:
    motion = stretched(0.0)
    motion[2, 3] = z
    return motion


def _operations() -> list[EstimateScene]:
    patch = flat_patch((28.0, 22.0, TOP))
    slit = Incision("slit", 2.0, ((-5.0, 0.5, TOP), (5.0, -0.5, TOP)))
    pull = Hook("hook", (0.0, 1.5, TOP), ((2.0, (0.0, 1.5, TOP)), (4.0, (0.5, 4.0, TOP + 2.0))), 2.0, 9.0, 100.0)
    oval = Incision("oval", 2.0, _oval(6.0, 2.2), closed=True)
    out = Excision("out", 2.0, ((0.0, 0.0, TOP),))
    freed = Undermine("freed", 2.0, _oval(10.0, 7.0))
    shut = _stitches(6.0, 2.2, (-4.0, -2.0, 0.0, 2.0, 4.0))
    base = [(-5.0, -4.0, TOP), (5.0, -4.0, TOP), (5.0, 4.0, TOP), (-5.0, 4.0, TOP)]
    flap = (Incision("flap", 2.0, tuple(base)), Undermine("under", 2.0, tuple(base)))
    advanced = Hook("tip", (3.5, 0.0, TOP), ((2.0, (3.5, 0.0, TOP)), (4.0, (7.0, 0.0, TOP + 1.0))), 2.0, 9.0, 200.0)
    taut = replace(SKIN, prestretch=(1.15, 1.15))
    layered = skin_over_fat(
        Procedure(tissue=patch, materials=(SKIN,)),
        1.0,
        replace(SKIN, youngs_modulus=300.0),
        Material("fat", model="neoHookean", youngs_modulus=10.0, poissons_ratio=0.45),
    )
    sewn, threaded, wide = _sewn_ovals()
    small = Technique(beyond=5.0, apart=2.5, margin=1.5, rows=(Row("skin", 0.0),), height=4.0, inside=1.5)
    when = Schedule(2, 2, 2, 2, 7, 7, 9, 8, 10, 10, 10)
    design = limberg((0.0, 0.0, TOP), (1.0, 0.0, 0.0), 6.0)
    limb = flat_patch((36.0, 32.0, TOP))
    dome = dome_scalp(30.0, 15.0, 4.0, resolution=2.0, spacing=1.0)
    return [
        EstimateScene("hooked-slit", "a slit drawn open", operation(patch, slit, pull, end=4.0)),
        EstimateScene("oval-closure", "an oval closed", operation(patch, oval, out, freed, *shut, end=6.0)),
        EstimateScene("sewn-oval", "a wide oval sewn with bites of 2 mm", operation(wide, *sewn, end=6.0)),
        EstimateScene("threaded-oval", "the same with a running thread", operation(wide, *threaded, end=6.0)),
        EstimateScene("advanced-flap", "a flap drawn on", operation(patch, *flap, advanced, end=4.0)),
        EstimateScene("taut-slit", "a slit in taut skin", operation(patch, slit, freed, end=2.0, materials=(taut,))),
        EstimateScene(
            "sagging-flap",
            "a short flap under gravity",
            operation(patch, *flap, end=2.0, materials=(replace(SKIN, youngs_modulus=15.0),)),
            gravity=(0.0, 0.0, 9.81),
        ),
        EstimateScene(
            "layered-slit",
            "a slit in layered skin drawn open",
            operation(layered.tissue, slit, pull, end=4.0, materials=layered.materials),
        ),
        EstimateScene(
            "limberg",
            "Limberg's flap on a patch",
            operation(limb, *flap_operation(design, SkinSheet.of(limb), when, small), end=10.0),
            spacings=(2.0, 1.75, 1.5),
            reference=(1.5, 0.75, 0.375),
        ),
        EstimateScene(
            "hooked-dome",
            "a dome pulled by a hook",
            operation(
                dome,
                Hook("hook", (0.0, 0.0, 30.0), ((1.0, (0.0, 0.0, 30.0)), (2.0, (2.0, 0.0, 33.0))), 1.0, 9.0, 50.0),
                end=2.0,
            ),
        ),
    ]


def _sewn_ovals() -> tuple[list[Event], list[Event], Tissue]:
    """An oval of 18 x 5 mm closed exactly at six places, and by one thread through bites there; and the tissue."""
    cut: list[Event] = [
        Incision("oval", 2.0, _oval(9.0, 2.5, count=32), closed=True),
        Excision("out", 2.0, ((0.0, 0.0, TOP),)),
        Undermine("freed", 2.0, _oval(15.0, 10.0)),
    ]
    bite, places = 2.0, (-6.5, -4.0, -1.5, 1.5, 4.0, 6.5)
    widths = [2.5 * math.sqrt(1.0 - (x / 9.0) ** 2) for x in places]
    sewn = [
        Suture(f"stitch_{k}", ((x, y + bite, TOP), (x, -y - bite, TOP)), 3.0, 3.0, mode="thread", length=2.0 * bite)
        for k, (x, y) in enumerate(zip(places, widths, strict=True))
    ]
    stations = [Station((x, 0.0, TOP), (0.0, 1.0, 0.0), gap=2.0 * y) for x, y in zip(places, widths, strict=True)]
    thread = running(stations, bite).suture("thread", 3.0, 0.95, duration=3.0)
    return [*cut, *sewn], [*cut, thread], flat_patch((42.0, 32.0, TOP))


def _stitches(x: float, y: float, at: Sequence[float]) -> list[Event]:
    found: list[Event] = []
    for k, along in enumerate(at):
        aside = y * math.sqrt(1.0 - (along / x) ** 2) + 0.1
        found.append(Suture(f"stitch_{k}", ((along, aside, TOP), (along, -aside, TOP)), 3.0, 3.0))
    return found


def fitting_scenes() -> tuple[EstimateScene, ...]:
    """List the scenes.

    Returns
    -------
    tuple[EstimateScene, ...]
        The scenes.
    """
    boxes = [
        EstimateScene(each.name, each.what, box(each), each.spacings, each.reference, (0.0, 0.0, -each.gravity))
        for each in BOXES
    ]
    return (*boxes, *_fibers(), *_stretched(), *_muscles(), *_layered(), *_over_bone(), *_operations())
