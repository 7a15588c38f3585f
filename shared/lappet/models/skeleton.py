"""The skeleton of the whole body: rigid groups of bones as sweeps along the rig's joints.

Joints keep a gap of soft tissue between two groups. The rib cage and the skull stand for what they hold as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.models.body_skin import BodySkin
from lappet.procedure import Point

COVER = 3.0  # mm of soft tissue over a bone, where its joints have that much
_LEAST_RADIUS = 1.0  # mm
_SLIVER = 0.1  # mm: what is thinner where two sweeps meet is left out, as single precision could not hold it
_SEGMENTS = 16  # around a sweep


@dataclass(frozen=True)
class Sweep:
    """A bone: spheres along joints, and what lies between each two of them.

    Parameters
    ----------
    joints
        Names of the joints that it follows; `*` stands for the side, r or l.
    radii
        Radius at each in mm.
    start
        Share of the first stretch that it leaves out.
    end
        Share of the last stretch after which it ends.
    shift
        From the joints in mm: sideways away from the middle, to the front, up.
    """

    joints: tuple[str, ...]
    radii: tuple[float, ...]
    start: float = 0.0
    end: float = 1.0
    shift: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Ellipsoid:
    """A bone that is an ellipsoid between two joints.

    Parameters
    ----------
    joints
        The two joints.
    share
        Share of the way from the first to the second at which its middle is.
    shift
        From there in mm: sideways, to the front, up.
    radii
        Radii in mm along x, y and z.
    """

    joints: tuple[str, str]
    share: float
    shift: Point
    radii: Point


# By group; with a `*` in its name once for each side. Radii are chosen, to lie within the body.
BONES: dict[str, tuple[Sweep | Ellipsoid, ...]] = {
    "trunk": (
        Sweep(
            ("pelvis", "spine-4", "spine-3", "spine-2", "spine-1", "neck", "head"), (22, 20, 18, 18, 16, 13, 12), 0, 0.5
        ),
        Sweep(("r-upper-leg", "l-upper-leg"), (30, 30), 0.2, 0.8, (0, 0, 28)),
        Ellipsoid(("head", "head-2"), 0.48, (0, -8, 0), (54, 56, 50)),
        Ellipsoid(("spine-2", "spine-1"), 0.55, (0, 36, 0), (104, 66, 138)),
        Sweep(("r-clavicle", "r-scapula"), (8, 8), 0.1),
        Sweep(("l-clavicle", "l-scapula"), (8, 8), 0.1),
    ),
    "humerus_*": (Sweep(("*-shoulder", "*-elbow"), (15, 13), 0.02, 0.87),),
    "forearm_*": (
        Sweep(("*-elbow", "*-hand"), (14, 11), 0.13),
        *(
            Sweep(("*-hand", f"*-finger-{k}-1", f"*-finger-{k}-2", f"*-finger-{k}-3"), (7, 5, 4, 3))
            for k in (2, 3, 4, 5)
        ),
        Sweep(("*-hand", "*-finger-1-2", "*-finger-1-3"), (7, 5, 4)),
    ),
    "femur_*": (Sweep(("*-upper-leg", "*-knee"), (20, 17), 0.1, 0.93),),
    "shank_*": (
        Sweep(("*-knee", "*-ankle"), (17, 13), 0.07),
        Sweep(("*-ankle", "*-foot-1"), (14, 9), 0, 0.9, (0, 0, 6)),
    ),
}


def skeleton(joints: Mapping[str, NDArray[np.float64]], skin: BodySkin) -> dict[str, manifold3d.Manifold]:
    """Make the groups of bones of a body.

    Parameters
    ----------
    joints
        Its joints, as `lappet.models.joints.joints` finds them.
    skin
        Its skin, which covers sweeps by `COVER`.

    Returns
    -------
    dict[str, manifold3d.Manifold]
        A solid for each rigid group of bones, by its name; those of a side end in `_r` or `_l`.
    """
    solids = {}
    for name, parts in BONES.items():
        for side in ("r", "l") if "*" in name else ("",):
            made = [_solid(part, joints, side, skin) for part in parts]
            whole = manifold3d.Manifold.batch_boolean(made, manifold3d.OpType.Add)
            solids[name.replace("*", side)] = whole.simplify(_SLIVER)
    return solids


def _solid(
    part: Sweep | Ellipsoid, joints: Mapping[str, NDArray[np.float64]], side: str, skin: BodySkin
) -> manifold3d.Manifold:
    places = [joints[name.replace("*", side)] for name in part.joints]
    shift = np.array(part.shift) * (1.0 if side != "l" else -1.0, 1.0, 1.0)
    if isinstance(part, Ellipsoid):
        middle = (1.0 - part.share) * places[0] + part.share * places[1] + shift
        return manifold3d.Manifold.sphere(1.0, 2 * _SEGMENTS).scale(part.radii).translate(tuple(middle))
    return _swept(places, part, shift, skin)


def _swept(
    places: Sequence[NDArray[np.float64]], part: Sweep, shift: NDArray[np.float64], skin: BodySkin
) -> manifold3d.Manifold:
    course = [place + shift for place in places]
    course[0], course[-1] = (
        course[0] + part.start * (course[1] - course[0]),
        course[-2] + part.end * (course[-1] - course[-2]),
    )
    if len(places) == 2:  # both ends are shares of the same stretch
        first, last = places[0] + shift, places[1] + shift
        course = [first + part.start * (last - first), first + part.end * (last - first)]
    most = np.maximum(skin.depth(np.array(course))[0] - COVER, _LEAST_RADIUS)
    balls = [
        manifold3d.Manifold.sphere(min(radius, room), _SEGMENTS).translate(tuple(place))
        for place, radius, room in zip(course, part.radii, most.tolist(), strict=True)
    ]
    pieces = [manifold3d.Manifold.batch_hull(list(pair)) for pair in pairwise(balls)]
    return manifold3d.Manifold.batch_boolean(pieces, manifold3d.OpType.Add)
