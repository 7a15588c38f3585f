"""A fusiform of any ratio, excised from a flat patch and closed directly: what a dog-ear is measured at."""

from __future__ import annotations

from typing import Any

import numpy as np

from lappet.designs import fusiform
from lappet.procedure import Excision, Incision, Material, Procedure, Suture, Undermine
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN

TOP = 4.0
WIDTH = 12.0
KERF = 0.05


def closed_fusiform(ratio: float, *, apart: float = 3.0, skin: Material = SKIN.material, **tissue: Any) -> Procedure:
    """Length over width; 1 is a circle. apart: between the sutures along the axis, mm. Cut at 2, sewn from 2 to 8."""
    length = ratio * WIDTH
    count = max(1, round(length / apart) - 1)
    whole = fusiform((0.0, 0.0, TOP), length, WIDTH, (1.0, 0.0, 0.0), sutures=count)
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    around = [(0.5 * length * np.cos(t) + 16.0 * np.cos(t), (0.5 * WIDTH + 16.0) * np.sin(t), TOP) for t in turn]
    sutures = []
    for row, height in (("skin", TOP), ("deep", 0.4 * TOP)):
        for k, pair in enumerate(whole.pairs):
            late = round(2.0 * abs(2.0 * (k + 1.0) / (count + 1.0) - 1.0))  # the middle first
            first, second = (beside(point, length, height) for point in pair)
            sutures.append(Suture(f"{row}_{k + 1}", (first, second), 2 + late, 4))
    events = (
        Incision("incision", 2, whole.curve, kerf=KERF, closed=True),
        Excision("excision", 2, (whole.seed,)),
        Undermine("undermining", 2, tuple(around)),
        *sutures,
    )
    patch = flat_patch((120.0, 80.0, TOP), resolution=2.0, spacing=2.0, **tissue)
    return Procedure(patch, (skin,), events=events, start_time=1, end_time=8)


def beside(point: tuple[float, float, float], length: float, height: float) -> tuple[float, float, float]:
    """The point 0.3 mm from the wound's edge into the tissue."""
    radius = (length**2 + WIDTH**2) / (4.0 * WIDTH)
    away = np.array([point[0], point[1] + np.sign(point[1]) * (radius - 0.5 * WIDTH)])
    x, y = np.array(point[:2]) + 0.3 * away / np.linalg.norm(away)
    return float(x), float(y), height
