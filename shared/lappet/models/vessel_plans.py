"""Vessels and nerves that run in the tissue of the head's models, drawn by hand after what anatomists describe.

Each course is a polyline beside the neutral body, x to the patient's right, y to the front, z up, mm, on the patient's
left; it is laid on the closest skin, lowered into the tissue, and mirrored. Only what lies above the plane in which
flaps are raised is here: where a model ends there, deeper vessels are not in its tissue and cannot be cut. So the
facial artery is missing, which runs 9 mm below the skin beside the ala and 22 mm beside the mouth (Gelezhe 2021), with
its labial and angular branches, and so are the branches of the facial nerve, which lie below SMAS and platysma.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.models.body_surface import BodySurface
from lappet.models.region import Ellipsoid
from lappet.procedure import Tissue, Vessel, VesselKind
from lappet.tissue.skin_sheet import SkinSheet

_OFF_SKIN = 8.0  # mm: what of a course is farther from the model's skin is not on it
_CLEAR = 1.5  # mm from the model's border
_STEP = 2.0  # mm between the points of a course
_SHORTEST = 8.0  # mm
_DECIMALS = 3  # of points in mm
SIDES = (("left", 1.0), ("right", -1.0))  # and the sign of x


FACIAL_ARTERY = "Gelezhe 2021"  # in `SOURCES`, of how deep it lies


@dataclass(frozen=True)
class Course:
    """A typical course.

    Parameters
    ----------
    name
        What it is called.
    kind
        A vessel's kind.
    radius
        Outer radius in mm.
    way
        Where it runs: points beside the skin in mm and, for each, how deep it lies in what is below the skin, as a
        share: 0 right below the skin, 1 in the plane in which flaps are raised.
    source
        A key of `SOURCES`.
    how
        How the course follows from the source.
    """

    name: str
    kind: VesselKind
    radius: float
    way: tuple[tuple[float, float, float, float], ...]
    source: str
    how: str


COURSES = (
    Course(
        "supratrochlear artery",
        "artery",
        0.45,
        (
            (-19.0, 138.0, 747.0, 0.92),
            (-18.5, 141.0, 760.0, 0.85),
            (-18.0, 139.0, 772.0, 0.7),
            (-17.0, 134.0, 785.0, 0.55),
            (-16.0, 127.0, 797.0, 0.4),
            (-15.5, 118.0, 808.0, 0.35),
        ),
        "Onerci Altunay 2024",
        "out of the orbit at the vertical through the inner canthus or lateral of it, then up to the hairline; through "
        "the muscle into the fat some 15 mm above the orbit's rim, below that in the deepest of the tissue",
    ),
    Course(
        "supratrochlear nerve",
        "nerve",
        0.3,
        (
            (-16.0, 140.0, 748.0, 0.92),
            (-15.0, 142.5, 760.0, 0.85),
            (-13.5, 140.5, 772.0, 0.7),
            (-12.0, 136.0, 785.0, 0.55),
        ),
        "chosen",
        "medial of its artery",
    ),
    Course(
        "supraorbital artery",
        "artery",
        0.45,
        (
            (-27.5, 139.0, 750.0, 0.92),
            (-28.5, 139.0, 765.0, 0.85),
            (-30.0, 134.0, 780.0, 0.7),
            (-31.5, 126.0, 793.0, 0.5),
        ),
        "chosen",
        "out of its notch above the middle of the orbit's inner half, up into the fat of the upper forehead",
    ),
    Course(
        "supraorbital nerve",
        "nerve",
        0.4,
        (
            (-26.0, 139.5, 750.0, 0.92),
            (-26.5, 140.0, 765.0, 0.8),
            (-27.0, 136.0, 780.0, 0.65),
            (-28.0, 129.0, 793.0, 0.5),
            (-29.0, 119.0, 805.0, 0.45),
        ),
        "chosen",
        "its superficial division, medial of the artery, to the hairline",
    ),
    Course(
        "superficial temporal artery",
        "artery",
        0.9,
        (
            (-70.0, 56.5, 716.0, 0.9),
            (-73.5, 55.0, 729.5, 0.9),
            (-69.5, 58.0, 745.0, 0.9),
            (-66.7, 68.0, 757.0, 0.9),
            (-62.3, 85.3, 765.6, 0.85),
            (-57.0, 100.7, 774.0, 0.8),
            (-48.6, 113.7, 783.0, 0.75),
        ),
        "chosen",
        "before the tragus and over the zygoma; above it the frontal branch, in the superficial temporal fascia, which "
        "is the deepest of the tissue",
    ),
    Course(
        "parietal branch of the superficial temporal artery",
        "artery",
        0.7,
        ((-69.5, 58.0, 745.5, 0.9), (-69.4, 54.0, 759.5, 0.9), (-68.3, 47.5, 777.0, 0.9), (-65.2, 42.0, 794.0, 0.9)),
        "chosen",
        "from where the trunk divides, up and back",
    ),
    Course(
        "lateral nasal artery",
        "artery",
        0.37,
        (
            (-18.0, 140.0, 701.5, 0.9),
            (-16.0, 145.0, 703.0, 0.85),
            (-12.5, 150.5, 704.5, 0.8),
            (-8.0, 155.0, 705.0, 0.75),
            (-3.0, 158.5, 704.5, 0.7),
        ),
        "PMC 11548982",
        "from the side of the nose 2 to 3 mm above the ala's groove towards the tip; the source has its diameter, 0.74 "
        "mm; the course is chosen",
    ),
    Course(
        "dorsal nasal artery",
        "artery",
        0.35,
        (
            (-12.0, 130.0, 734.0, 0.9),
            (-7.5, 138.0, 731.0, 0.85),
            (-5.0, 143.0, 724.0, 0.8),
            (-4.0, 149.0, 715.0, 0.75),
            (-3.0, 154.0, 707.5, 0.7),
        ),
        "chosen",
        "over the tendon of the inner canthus to the back of the nose and down to the tip",
    ),
)


def courses_in(region: Ellipsoid) -> list[Course]:
    """List the courses of which a part lies in a region, on either side.

    Parameters
    ----------
    region
        The region, on the neutral body.

    Returns
    -------
    list[Course]
        The courses.
    """
    found = []
    for course in COURSES:
        sides = [_dense(np.array(course.way) * (sign, 1.0, 1.0, 1.0))[:, :3] for _, sign in SIDES]
        if any(np.count_nonzero(region.level(way) < -_CLEAR) * _STEP >= _SHORTEST for way in sides):
            found.append(course)
    return found


def vessels_on(skin: BodySurface, region: Ellipsoid, tissue: Tissue, depths: tuple[float, float]) -> tuple[Vessel, ...]:
    """Lay vessels and nerves into the tissue of a model.

    Parameters
    ----------
    skin
        The skin of the model.
    region
        The region that it was cut out with.
    tissue
        Its tissue.
    depths
        Thickness of the skin and of what is below it in mm.

    Returns
    -------
    tuple[Vessel, ...]
        What of the courses lies in the tissue, flagged as typical courses.
    """
    triangles = tissue.face_vertex_indices.reshape(-1, 3)[tissue.subsets["underside"]]
    sides = [
        (course, side, _dense(np.array(course.way) * (sign, 1.0, 1.0, 1.0)))
        for course in COURSES
        for side, sign in SIDES
    ]
    ends = np.cumsum([len(way) for _, _, way in sides])
    places, away = skin.carried(np.concatenate([way[:, :3] for _, _, way in sides]))
    tops = SkinSheet.of(tissue).place(places)
    bottoms = ClosestPoint(tissue.points, triangles).query(tops)[1]
    found = []
    for (course, side, way), top, bottom, off in zip(
        sides, *(np.split(values, ends[:-1]) for values in (tops, bottoms, away)), strict=True
    ):
        share = (depths[0] + way[:, 3:] * depths[1]) / sum(depths)  # of a sheet that may be thinner here
        at = np.round(top + share * (bottom - top), _DECIMALS)
        for number, part in enumerate(_parts(at, (region.level(way[:, :3]) < -_CLEAR) & (off < _OFF_SKIN))):
            points = tuple((float(x), float(y), float(z)) for x, y, z in part)
            name = f"{course.name.replace(' ', '_')}_{side}" + (f"_{number + 1}" if number else "")
            label = f"{course.name} {side}"
            found.append(Vessel(name, points, course.kind, course.radius, label, typical_course=True))
    return tuple(found)


def _dense(way: NDArray[np.float64]) -> NDArray[np.float64]:
    """A course with a point every few mm."""
    reach = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way[:, :3], axis=0), axis=1))])
    at = np.linspace(0.0, reach[-1], round(float(reach[-1]) / _STEP) + 1)
    return np.stack([np.interp(at, reach, way[:, k]) for k in range(4)], axis=1)


def _parts(points: NDArray[np.float64], on: NDArray[np.bool_]) -> list[NDArray[np.float64]]:
    """The parts of a course that are in a model and not too short."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    parts = [points[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [part for part in parts if float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum()) >= _SHORTEST]
