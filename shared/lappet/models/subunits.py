"""Aesthetic subunits of the face as groups of skin faces.

The units are those of Gonzalez-Ulloa (1956), the subunits of the nose those of Burget and Menick (1985). Their borders
lie here halfway between points that are placed in them by hand, not on the creases themselves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.triangles import areas
from lappet.models.body_surface import BodySurface
from lappet.procedure import Point

_SMALLEST = 0.02  # of the model's skin: less of a subunit than this is none of the model's
_MIDLINE: dict[str, tuple[Point, ...]] = {
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
_RIGHT: dict[str, tuple[Point, ...]] = {
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


def subunits(skin: BodySurface) -> dict[str, NDArray[np.int32]]:
    """Find the subunits of the face on the skin of a model.

    Parameters
    ----------
    skin
        The skin.

    Returns
    -------
    dict[str, NDArray[np.int32]]
        Numbers of the skin's triangles by name, such as `subunit_nasal_tip` and `subunit_ala_left`.
    """
    seeds: list[Point] = []
    names: list[str] = []
    for name, points in _MIDLINE.items():
        seeds += points
        names += [name] * len(points)
    for name, points in _RIGHT.items():
        for x, y, z in points:
            seeds += [(x, y, z), (-x, y, z)]
            names += [f"{name}_right", f"{name}_left"]
    middles = skin.neutral[skin.triangles].mean(axis=1)
    nearest = np.argmin([np.linalg.norm(middles - seed, axis=1) for seed in np.array(seeds)], axis=0)
    size = areas(skin.points[skin.triangles])
    found = {}
    for name in dict.fromkeys(names):
        inside = np.isin(nearest, [number for number, each in enumerate(names) if each == name])
        if size[inside].sum() > _SMALLEST * size.sum():
            found[f"subunit_{name}"] = np.flatnonzero(inside).astype(np.int32)
    return found
