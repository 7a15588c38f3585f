"""Aesthetic subunits of the face and parts of the ear as groups of skin faces.

The units are those of Gonzalez-Ulloa (1956), the subunits of the nose those of Burget and Menick (1985), the parts of
the ear the anatomist's. Their borders lie here halfway between points that are placed in them by hand, not on the
creases themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.triangles import areas
from lappet.models.body_surface import BodySurface
from lappet.procedure import Point

_FACE_MIDLINE: dict[str, tuple[Point, ...]] = {
    "forehead": ((0.0, 134.0, 790.0), (28.0, 130.0, 790.0), (-28.0, 130.0, 790.0), (0.0, 141.0, 770.0)),
    "glabella": ((0.0, 144.0, 750.0),),
    "nasal_dorsum": ((0.0, 142.0, 735.0), (0.0, 146.0, 723.0), (0.0, 152.0, 711.5)),
    "nasal_tip": ((0.0, 159.5, 700.0), (5.5, 157.0, 699.0), (-5.5, 157.0, 699.0)),
    "columella": ((0.0, 152.5, 691.5),),
    "philtrum": ((0.0, 149.5, 684.0), (0.0, 151.0, 680.5)),
    "upper_vermilion": ((0.0, 152.5, 673.5), (11.0, 149.5, 673.0), (-11.0, 149.5, 673.0)),
    "lower_vermilion": ((0.0, 150.0, 663.0), (11.0, 147.5, 664.0), (-11.0, 147.5, 664.0)),
    "lower_lip": ((0.0, 143.0, 653.5), (14.0, 139.0, 653.5), (-14.0, 139.0, 653.5)),
    "chin": ((0.0, 141.5, 640.0), (14.0, 136.0, 638.0), (-14.0, 136.0, 638.0), (0.0, 131.0, 628.0)),
}
_FACE_RIGHT: dict[str, tuple[Point, ...]] = {
    "temple": ((67.0, 96.0, 755.0), (74.0, 70.0, 755.0)),
    "eyebrow": ((22.0, 142.0, 751.0), (38.0, 138.0, 753.0)),
    "upper_lid": ((31.0, 135.0, 742.5), (22.0, 135.0, 741.0), (41.0, 130.0, 741.0)),
    "lower_lid": ((31.0, 132.5, 724.0), (22.0, 131.0, 724.5), (41.0, 127.0, 725.0)),
    "nasal_sidewall": ((10.0, 138.0, 727.0), (11.0, 140.0, 717.0), (12.0, 143.0, 708.0)),
    "ala": ((15.5, 145.0, 698.5), (17.5, 140.0, 697.0)),
    "lateral_upper_lip": ((14.0, 145.0, 682.0), (22.0, 140.5, 677.0)),
    "cheek": (
        (25.0, 135.0, 703.0),
        (27.0, 136.0, 693.0),
        (36.0, 131.0, 706.0),
        (44.0, 126.0, 690.0),
        (58.0, 110.0, 690.0),
        (52.0, 112.0, 664.0),
        (66.0, 95.0, 712.0),
        (68.0, 75.0, 690.0),
        (62.0, 80.0, 660.0),
        (37.0, 131.0, 664.0),
    ),
}
_EAR_RIGHT: dict[str, tuple[Point, ...]] = {
    "helix": (
        (68.1, 47.5, 715.5),  # its crus
        (71.5, 53.5, 719.0),
        (73.9, 53.0, 725.0),
        (76.6, 51.5, 731.0),
        (79.4, 46.0, 735.8),
        (80.8, 40.0, 737.0),
        (82.2, 34.5, 732.0),
        (81.8, 31.2, 724.0),
        (81.1, 30.6, 719.5),
        (80.5, 30.3, 715.0),
        (79.1, 32.3, 708.0),
        (78.7, 37.0, 702.5),
    ),
    "scapha": ((77.1, 43.0, 733.0), (79.0, 37.0, 731.0), (78.8, 34.3, 725.0), (80.0, 32.7, 718.0), (80.0, 33.5, 711.0)),
    "triangular_fossa": ((73.6, 45.5, 728.0), (73.1, 46.0, 724.0)),
    "antihelix": ((77.5, 40.0, 727.0), (79.7, 37.5, 721.0), (80.6, 36.0, 714.5), (79.0, 37.5, 708.5)),
    "concha": (
        (71.8, 45.0, 719.5),
        (72.9, 40.0, 717.0),
        (71.4, 39.0, 712.0),
        (66.8, 44.0, 712.0),
        (65.3, 48.5, 711.0),
        (68.1, 41.0, 709.5),
    ),
    "tragus": ((70.8, 53.0, 711.0), (70.0, 53.0, 706.5)),
    "antitragus": ((65.4, 48.0, 706.0), (67.5, 43.0, 706.5)),
    "lobule": ((71.3, 54.0, 698.0), (74.6, 49.0, 697.0), (77.3, 43.0, 699.0), (75.3, 48.0, 691.5), (72.6, 54.0, 692.5)),
    "back_of_auricle": (
        (73.0, 43.0, 737.2),
        (75.0, 36.1, 734.0),
        (71.0, 37.4, 735.0),
        (76.0, 32.6, 727.0),
        (71.0, 32.1, 727.0),
        (76.0, 30.9, 719.0),
        (70.0, 31.7, 718.0),
        (75.0, 32.3, 711.0),
        (70.0, 33.6, 711.0),
        (74.0, 36.2, 703.5),
        (69.5, 37.4, 703.5),
    ),
    "preauricular": (
        (69.0, 59.0, 700.0),
        (70.0, 58.0, 707.0),
        (69.3, 60.0, 712.0),
        (69.9, 57.5, 715.0),
        (69.8, 58.5, 722.0),
        (70.7, 57.0, 734.0),
    ),
    "retroauricular": (
        (66.0, 10.0, 740.0),
        (72.0, 20.0, 752.0),
        (64.0, 8.0, 720.0),
        (60.0, 12.0, 700.0),
        (60.0, 20.0, 688.0),
        (66.0, 30.0, 690.0),
        (69.2, 26.0, 730.0),
        (67.4, 26.0, 720.0),
        (65.3, 27.0, 712.0),
        (62.8, 29.0, 704.0),
        (60.7, 36.0, 694.0),
        (70.4, 34.0, 741.0),
        (70.2, 46.0, 743.0),
        (58.5, 44.0, 685.0),
    ),
}


@dataclass(frozen=True)
class Units:
    """What a part of the body is divided into.

    Parameters
    ----------
    midline
        Points of the neutral body in each unit in the midline, in mm.
    right
        Points in each paired unit, on the right.
    smallest
        Share of a model's skin: less of a unit than this is none of the model's.
    """

    midline: dict[str, tuple[Point, ...]]
    right: dict[str, tuple[Point, ...]]
    smallest: float


UNITS = {"face": Units(_FACE_MIDLINE, _FACE_RIGHT, 0.02), "ear": Units({}, _EAR_RIGHT, 0.01)}


def subunits(skin: BodySurface, units: Units) -> dict[str, NDArray[np.int32]]:
    """Find the subunits on the skin of a model.

    Parameters
    ----------
    skin
        The skin.
    units
        The subunits.

    Returns
    -------
    dict[str, NDArray[np.int32]]
        Numbers of the skin's triangles by name, such as `subunit_nasal_tip` and `subunit_ala_left`.
    """
    seeds: list[Point] = []
    names: list[str] = []
    for name, points in units.midline.items():
        seeds += points
        names += [name] * len(points)
    for name, points in units.right.items():
        for x, y, z in points:
            seeds += [(x, y, z), (-x, y, z)]
            names += [f"{name}_right", f"{name}_left"]
    middles = skin.neutral[skin.triangles].mean(axis=1)
    nearest = np.argmin([np.linalg.norm(middles - seed, axis=1) for seed in np.array(seeds)], axis=0)
    size = areas(skin.points[skin.triangles])
    found = {}
    for name in dict.fromkeys(names):
        inside = np.isin(nearest, [number for number, each in enumerate(names) if each == name])
        if size[inside].sum() > units.smallest * size.sum():
            found[f"subunit_{name}"] = np.flatnonzero(inside).astype(np.int32)
    return found
