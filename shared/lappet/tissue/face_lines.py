"""Skin lines of a face from a few of its landmarks.

Their course is that of the relaxed skin tension lines as atlases show them (Borges 1984, Plast Reconstr Surg 73:144):
across the forehead, fanning out from the outer corners of the eyes, along the nasolabial fold over the cheek, upright
in the upper lip, across the chin. How far each reaches is chosen. The tensions of lip and cheek are those that Flynn et
al. 2018 measured (`lappet.tissue.presets`), half of them across; elsewhere the prestretch of the tissue's material
holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Point, SkinLine
from lappet.tissue.skin_sheet import SkinSheet

CHEEK_TENSION, LIP_TENSION = (53.0, 26.5), (7.0, 3.5)  # kPa
_PARTS = 8  # of a line, each end of which is placed on the skin

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class FaceLandmarks:
    """Points of a face, near its skin, in mm.

    Parameters
    ----------
    hairline
        Middle of the hairline.
    nasion
        Root of the nose between the eyes.
    subnasale
        Where the nose meets the upper lip.
    chin
        Foremost point of the chin.
    eyes
        Outer corners of the right and the left eye.
    mouth
        Right and left corner of the mouth.
    """

    hairline: Point
    nasion: Point
    subnasale: Point
    chin: Point
    eyes: tuple[Point, Point]
    mouth: tuple[Point, Point]


def face_lines(face: FaceLandmarks, skin: SkinSheet) -> tuple[SkinLine, ...]:
    """Draw the skin lines of a face.

    Parameters
    ----------
    face
        Its landmarks.
    skin
        Its skin, on which the lines are placed.

    Returns
    -------
    tuple[SkinLine, ...]
        The lines.
    """
    hairline, nasion, subnasale, chin = (np.array(p) for p in (face.hairline, face.nasion, face.subnasale, face.chin))
    eyes, mouth = np.array(face.eyes), np.array(face.mouth)
    lines: list[SkinLine] = []

    def draw(name: str, corners: list[Vector], tension: tuple[float, float] | None = None) -> None:
        shares = np.linspace(0.0, len(corners) - 1.0, _PARTS * (len(corners) - 1) + 1)
        path = np.stack([np.interp(shares, range(len(corners)), np.array(corners)[:, k]) for k in range(3)], axis=1)
        placed = skin.place(path).round(4)
        lines.append(SkinLine(name, tuple((float(x), float(y), float(z)) for x, y, z in placed), tension))

    across = 0.5 * (eyes[1] - eyes[0])
    for k, share in enumerate((0.25, 0.5, 0.75)):
        middle = nasion + share * (hairline - nasion)
        draw(f"forehead_{k + 1}", [middle - across, middle, middle + across])
    for k, share in enumerate((0.35, 0.7)):
        middle = 0.5 * mouth.sum(axis=0) + share * (chin - 0.5 * mouth.sum(axis=0))
        half = 0.4 * (mouth[1] - mouth[0])
        draw(f"chin_{k + 1}", [middle - half, middle, middle + half])
    for k, share in enumerate((0.2, 0.5, 0.8)):
        below = mouth[0] + share * (mouth[1] - mouth[0])
        draw(f"lip_{k + 1}", [below + (subnasale - 0.5 * mouth.sum(axis=0)), below], LIP_TENSION)
    down = (chin - nasion) / np.linalg.norm(chin - nasion)
    for side, eye, corner, out in zip(("right", "left"), eyes, mouth, (-across, across), strict=True):
        for k, turn in enumerate((-0.5, 0.0, 0.5)):
            ray = math.cos(turn) * out + math.sin(turn) * np.linalg.norm(out) * down
            draw(f"eye_{side}_{k + 1}", [eye + 0.1 * ray, eye + 0.5 * ray])
        for k, aside in enumerate((0.0, 0.3, 0.6)):
            fold = [subnasale + 0.35 * out, corner + 0.2 * out, chin + 0.5 * out]
            draw(f"cheek_{side}_{k + 1}", [point + aside * out for point in fold], CHEEK_TENSION)
    return tuple(lines)
