"""Relaxed skin tension lines of the body, drawn by hand after Borges' descriptions, in families.

Each line is a polyline beside the neutral body, x to the patient's right, y to the front, z up, mm; it is laid on the
closest skin. Lines of the left are mirrored to the right. Where skin ends at lids and lips its tension across the
border vanishes; lines that end or run there are marked as slack and carry none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.models.body_surface import BodySurface
from lappet.models.region import Ellipsoid
from lappet.procedure import SkinLine

Line = NDArray[np.float64]
_OFF_SKIN = 45.0  # mm: what of a line is farther from the model's skin is not on it
_STEP = 3.0  # mm between the points of a line
_SHORTEST = 6.0  # mm


@dataclass(frozen=True, eq=False)
class Plan:
    """A family of lines.

    Parameters
    ----------
    lines
        Polylines, shape (k, 3) each, in mm.
    mirrored
        Whether each has a mirror image on the right.
    slack
        Whether they carry no tension.
    """

    lines: tuple[Line, ...]
    mirrored: bool
    slack: bool = False


def _arc(x: NDArray[np.float64], y: float, z: float, back: float, rise: float = 0.0) -> Line:
    """A transverse line that runs back, and up or down, with the square of x over 100 mm."""
    square = (x / 100.0) ** 2
    return np.stack([x, y - back * square, z + rise * square], axis=1)


def _through(*points: tuple[float, float, float]) -> Line:
    return np.array(points)


def _forehead() -> list[Plan]:
    x = np.linspace(72.0, -72.0, 25)
    return [Plan(tuple(_arc(x, 142.0, z, 95.0, 12.0) for z in np.arange(760.0, 826.0, 8.0)), False)]


def _glabella() -> list[Plan]:
    lines = [_through((x, 144.0, 740.0), (x * 1.1, 145.0, 748.0), (x * 1.3, 145.0, 755.0)) for x in (-8.0, 0.0, 8.0)]
    return [Plan(tuple(lines), False)]


def _eyes() -> list[Plan]:
    turn = np.linspace(0.0, 2.0 * np.pi, 41)
    rings = []
    for across, high in ((14.0, 7.5), (19.0, 12.0), (25.0, 17.0)):
        x, z = -30.5 + across * np.cos(turn), 733.5 + high * np.sin(turn)
        rings.append(np.stack([x, np.full_like(x, 131.0) - 0.011 * (x + 24.0) ** 2, z], axis=1))
    feet = [
        _through((-58.0, 113.0, 739.0), (-66.0, 103.0, 744.0), (-73.0, 90.0, 747.0)),
        _through((-58.0, 112.0, 732.0), (-66.0, 102.0, 731.0), (-74.0, 88.0, 729.0)),
        _through((-57.0, 113.0, 726.0), (-65.0, 104.0, 720.0), (-72.0, 92.0, 714.0)),
    ]
    return [Plan(tuple(rings[:1]), True, slack=True), Plan((*rings[1:], *feet), True)]


def _temple() -> list[Plan]:
    lines = (
        ((-63.0, 112.0, 758.0), (-72.0, 92.0, 766.0), (-78.0, 62.0, 774.0)),
        ((-72.0, 90.0, 751.0), (-77.0, 68.0, 756.0), (-79.0, 46.0, 760.0)),
        ((-74.0, 86.0, 735.0), (-77.0, 64.0, 737.0), (-78.0, 48.0, 740.0)),
    )
    return [Plan(tuple(_through(*line) for line in lines), True)]


def _nose() -> list[Plan]:
    x = np.linspace(13.0, -13.0, 13)
    lines = [_arc(x, y, z, 500.0, -60.0) for y, z in ((145.0, 728.0), (148.0, 720.0), (151.0, 713.0), (157.0, 706.0))]
    return [Plan((*lines, _arc(x, 160.0, 700.0, 500.0)), False)]


def _cheeks() -> list[Plan]:
    folds = (
        (
            (-19.0, 138.0, 704.0),
            (-29.0, 137.0, 688.0),
            (-36.0, 131.0, 672.0),
            (-37.0, 129.0, 656.0),
            (-32.0, 128.0, 642.0),
        ),
        (
            (-27.0, 134.0, 718.0),
            (-40.0, 129.0, 700.0),
            (-48.0, 122.0, 680.0),
            (-49.0, 118.0, 660.0),
            (-43.0, 117.0, 642.0),
        ),
        (
            (-42.0, 126.0, 719.0),
            (-54.0, 117.0, 700.0),
            (-60.0, 108.0, 680.0),
            (-59.0, 102.0, 660.0),
            (-52.0, 102.0, 642.0),
        ),
        (
            (-56.0, 114.0, 716.0),
            (-65.0, 102.0, 698.0),
            (-68.0, 92.0, 678.0),
            (-65.0, 86.0, 660.0),
            (-58.0, 85.0, 644.0),
        ),
        ((-69.0, 95.0, 714.0), (-73.0, 84.0, 696.0), (-72.0, 74.0, 676.0), (-67.0, 68.0, 658.0)),
        ((-75.0, 70.0, 720.0), (-75.0, 62.0, 700.0), (-72.0, 58.0, 680.0), (-66.0, 54.0, 660.0)),
    )
    return [Plan(tuple(_through(*fold) for fold in folds), True)]


def _lips() -> list[Plan]:
    upper = [
        _through((-2.5, 151.0, 685.0), (-3.5, 152.5, 677.0), (-4.0, 148.0, 670.0)),
        _through((-9.0, 147.0, 686.0), (-10.0, 150.0, 677.0), (-11.0, 147.0, 670.0)),
        _through((-17.0, 142.0, 685.0), (-17.0, 145.0, 676.0), (-17.0, 143.0, 669.5)),
    ]
    lower = [
        _through((-3.0, 148.0, 666.0), (-3.0, 149.5, 659.0), (-3.0, 144.0, 652.0)),
        _through((-11.0, 147.0, 666.5), (-11.0, 148.0, 659.0), (-10.5, 142.0, 652.0)),
        _through((-18.0, 141.0, 667.0), (-19.0, 142.0, 660.0), (-19.0, 137.0, 652.0)),
    ]
    return [Plan((*upper, *lower), True, slack=True)]


def _chin() -> list[Plan]:
    x = np.linspace(24.0, -24.0, 13)
    return [
        Plan(
            (
                *(
                    _arc(x, y, z, 180.0, rise)
                    for y, z, rise in ((142.0, 650.0, -60.0), (142.5, 642.0, 60.0), (138.0, 633.0, 120.0))
                ),
            ),
            False,
        )
    ]


def _neck() -> list[Plan]:
    x = np.linspace(60.0, -60.0, 25)
    return [
        Plan(
            tuple(
                _arc(x, y, z, 170.0, 30.0)
                for y, z in ((98.0, 620.0), (80.0, 608.0), (74.0, 596.0), (70.0, 584.0), (68.0, 572.0), (68.0, 560.0))
            ),
            False,
        )
    ]


def _scalp() -> list[Plan]:
    turn = np.linspace(1.2, -1.2, 25)
    return [
        Plan(
            tuple(
                np.stack([74.0 * np.sin(turn), np.full_like(turn, y), 770.0 + 72.0 * np.cos(turn)], axis=1)
                for y in np.arange(-24.0, 113.0, 14.0)
            ),
            False,
        )
    ]


def _hand() -> list[Plan]:
    along, across = np.array([-44.0, 77.0, -51.0]) / 102.0, np.array([-25.0, -55.0, -27.0]) / 66.0
    middle = np.array([-484.0, 221.0, 179.0])
    t = np.linspace(28.0, -28.0, 11)[:, None]
    return [Plan(tuple(middle + s * along + t * across for s in np.arange(-32.0, 33.0, 9.0)), False)]


def _web() -> list[Plan]:
    """Across the web's edge, from the back of the hand to the palm, as its creases run when the thumb is drawn in."""
    edge, over = np.array([-97.0, -10.0, 5.0]) / 97.6, np.array([0.0, 55.0, 84.0]) / 100.4
    middle = np.array([-447.0, 260.0, 167.0])
    t = np.linspace(24.0, -24.0, 17)[:, None]
    return [Plan(tuple(middle + s * edge + t * over for s in np.arange(-20.0, 21.0, 5.0)), False)]


def _breast() -> list[Plan]:
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    rings = [
        np.stack([-99.0 + r * np.cos(turn), np.full_like(turn, 150.0 - 0.5 * r), 391.0 + r * np.sin(turn)], axis=1)
        for r in np.arange(14.0, 76.0, 12.0)
    ]
    return [Plan(tuple(rings), False)]


def _abdomen() -> list[Plan]:
    x = np.linspace(90.0, -90.0, 31)
    return [Plan(tuple(_arc(x, 136.0, z, 50.0, -18.0) for z in np.arange(150.0, 321.0, 15.0)), False)]


def _thigh() -> list[Plan]:
    x, middle = np.linspace(-50.0, 50.0, 21), np.array([-124.0, 95.0, 0.0])
    return [Plan(tuple(middle + _arc(x, 0.0, z, 160.0) for z in np.arange(-210.0, -49.0, 15.0)), False)]


def _ear() -> list[Plan]:
    turn = np.linspace(-0.35 * np.pi, 1.25 * np.pi, 41)
    rings = [
        np.stack([np.full_like(turn, -70.0), 28.0 - r * np.sin(turn), 712.0 + 1.2 * r * np.cos(turn)], axis=1)
        for r in (25.0, 32.0)
    ]
    return [Plan(tuple(rings), True)]


FAMILIES: dict[str, Callable[[], list[Plan]]] = {
    "forehead": _forehead,
    "glabella": _glabella,
    "eyes": _eyes,
    "temple": _temple,
    "nose": _nose,
    "cheeks": _cheeks,
    "lips": _lips,
    "chin": _chin,
    "ear": _ear,
    "neck": _neck,
    "scalp": _scalp,
    "hand": _hand,
    "web": _web,
    "breast": _breast,
    "abdomen": _abdomen,
    "thigh": _thigh,
}


def lines_on(skin: BodySurface, region: Ellipsoid, families: tuple[str, ...]) -> tuple[SkinLine, ...]:
    """Lay families of lines on the skin of a model.

    Parameters
    ----------
    skin
        The skin.
    region
        The region that it was cut out with.
    families
        Keys of `FAMILIES`.

    Returns
    -------
    tuple[SkinLine, ...]
        What of the lines lies on the skin; those without tension say so, all others leave it to the material.
    """
    found = []
    for family in families:
        number = 0
        for plan in FAMILIES[family]():
            mirrored = [line * (-1.0, 1.0, 1.0) for line in plan.lines] if plan.mirrored else []
            for line in (*plan.lines, *mirrored):
                for part in _on_skin(skin, region, _dense(line)):
                    number += 1
                    points = tuple((float(x), float(y), float(z)) for x, y, z in np.round(part, 3))
                    tension = (0.0, 0.0) if plan.slack else None
                    found.append(SkinLine(f"{family}_{number}", points, tension, "linear"))
    return tuple(found)


def _dense(line: Line) -> Line:
    """A polyline with a point every few mm."""
    reach = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, reach[-1], max(2, round(float(reach[-1]) / _STEP) + 1))
    return np.stack([np.interp(at, reach, line[:, k]) for k in range(3)], axis=1)


def _on_skin(skin: BodySurface, region: Ellipsoid, line: Line) -> list[Line]:
    """The parts of a line that lie on a model's skin, as they lie on the shaped body."""
    points, away = skin.carried(line)
    on = (region.level(line) < 0.0) & (away < _OFF_SKIN)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    parts = [points[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True)]
    kept = []
    for part in parts:
        moved = np.linalg.norm(np.diff(part, axis=0), axis=1)
        part = part[np.concatenate([[True], moved > 0.05])]
        if len(part) > 1 and float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum()) >= _SHORTEST:
            kept.append(part)
    return kept
