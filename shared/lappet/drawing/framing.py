"""Where the camera stands: the surgical field, its axes and the view that just holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_fields import SKIN, WOUND_WALL
from lappet.drawing.skin_source import SkinSource
from lappet.geometry.triangles import area_normals

LENS, SENSOR = 90.0, 36.0  # focal length and the longer side of the sensor, mm
VIEWS = {"oblique": 50.0, "top": 90.0, "low": 26.0}
TURN = 9.0
STEEPEST = 20.0  # degrees by which an oblique view is made steeper, at most, so that no border of a patch is seen
AROUND_WHOLE = 1.6  # times the tissue, where there is no wound
LEANING = 0.4  # of the angle to the normal: so much of it where a body is shown, which is known from the front
MARGIN = 9.0
# Shares of the picture's width and height that the surgical field may take up; a whole organ takes nearly all.
FIELD_FILL = (0.64, 0.78)
WIDEST = 5.0  # times the field: so much of the body around it counts at most
NEARER = 0.75  # power of that which is shown: less of a body around a small wound
WHOLE_FILL = (0.94, 0.94)
OVERHANG = -0.2  # of a body's skin that faces down more than so (its normal's z), a plate is drawn from above


def half_angles(size: tuple[float, float]) -> tuple[float, float]:
    """Compute the tangents of half the horizontal and vertical field of view of a picture.

    Parameters
    ----------
    size
        Its width and height in pixels.

    Returns
    -------
    tuple[float, float]
        The tangents.
    """
    across = SENSOR / 2 / LENS
    longer = max(size)
    return across * size[0] / longer, across * size[1] / longer


@dataclass(frozen=True, eq=False)
class SurgicalField:
    """What the picture must show.

    Parameters
    ----------
    points
        The places in mm, shape (k, 3).
    center
        Their middle in mm, shape (3,).
    right
        Unit vector to the right of the picture, shape (3,).
    up
        Unit vector up along the skin, shape (3,).
    normal
        Unit vector out of the skin, shape (3,).
    fill
        The shares of the picture's width and height that the points may take up.
    context
        How much larger than the field what is shown around it is.
    """

    points: NDArray[np.float64]
    center: NDArray[np.float64]
    right: NDArray[np.float64]
    up: NDArray[np.float64]
    normal: NDArray[np.float64]
    fill: tuple[float, float]
    context: float = 1.0

    @property
    def extent(self) -> float:
        """Diagonal of the field with a margin around it, mm: what lights and backdrop are measured by."""
        return self.context * float(np.linalg.norm(np.ptp(self.points, axis=0) + 2 * MARGIN))

    @property
    def stitch_scale(self) -> float:
        """How much larger than on a wound of 40 mm thread, bites and hooks are drawn: mildly with the wound."""
        return float(np.clip(np.sqrt(np.linalg.norm(np.ptp(self.points, axis=0)) / 40.0), 0.8, 1.6))


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A camera.

    Parameters
    ----------
    position
        Where it stands in mm, shape (3,).
    axes
        Unit vectors to the right, up and backwards, shape (3, 3).
    distance
        To the field's center in mm.
    """

    position: NDArray[np.float64]
    axes: NDArray[np.float64]
    distance: float


def surgical_field(cache: SkinSource, frames: tuple[float, ...]) -> SurgicalField:
    """Find the field that wound walls, active sutures and hooks cover in some frames, or all skin where there are none.

    Parameters
    ----------
    cache
        The solved procedure.
    frames
        Time codes, at least one.

    Returns
    -------
    SurgicalField
        The field.

    Raises
    ------
    FigureError
        If one of the frames is not there.
    """
    found = []
    everything = []
    for time in frames:
        epoch = cache.epoch_at(time)
        points = cache.positions(epoch, time).astype(np.float64)
        wall = np.unique(epoch.triangles[epoch.origin == WOUND_WALL])
        found.append(points[wall])
        for strands in (cache.sutures(time), cache.hooks(time)):
            found.append(strands.ends[strands.active][:, 0].astype(np.float64))
        everything.append(points[np.unique(epoch.triangles)])
    epoch = cache.epoch_at(frames[0])
    points = cache.positions(epoch, frames[0]).astype(np.float64)
    return field_around(np.concatenate(found), points, epoch.triangles[epoch.origin == SKIN], everything)


def field_on_body(cache: SkinSource, frames: tuple[float, ...], body: bool) -> SurgicalField:
    """Find the field of a picture: the surgical field, and where a body is shown enough of it to know the place.

    Parameters
    ----------
    cache
        The solved procedure.
    frames
        Time codes, at least one.
    body
        Whether a body is shown around the tissue.

    Returns
    -------
    SurgicalField
        The field.

    Raises
    ------
    FigureError
        If one of the frames is not there.
    """
    field = surgical_field(cache, frames)
    if not body:
        return field
    epoch = cache.epochs[0]
    return widened(field, cache.rest(epoch)[np.unique(epoch.triangles)].astype(np.float64))


def widened(field: SurgicalField, tissue: NDArray[np.float64]) -> SurgicalField:
    """Widen a field on a body: as much around it as the tissue reaches, with the body's top up.

    Parameters
    ----------
    field
        The field.
    tissue
        Points of all that is shown in mm, shape (k, 3).

    Returns
    -------
    SurgicalField
        The wider field.
    """
    own = float(np.linalg.norm(np.ptp(field.points, axis=0)))
    least = AROUND_WHOLE if field.fill == WHOLE_FILL else 1.0
    around = float(np.clip(np.linalg.norm(np.ptp(tissue, axis=0)) / max(own, 1.0), 1.0, WIDEST))
    context = max(around**NEARER, least)
    seed = np.array([0.0, 0.0, 1.0]) if abs(field.normal[2]) < 0.8 else np.array([0.0, 1.0, 0.0])
    up = seed - (seed @ field.normal) * field.normal
    up /= np.linalg.norm(up)
    fill = (field.fill[0] / context, field.fill[1] / context)
    return replace(field, up=up, right=np.cross(up, field.normal), fill=fill, context=context)


def field_around(
    found: NDArray[np.float64],
    points: NDArray[np.float64],
    skin: NDArray[np.int32],
    everything: Sequence[NDArray[np.float64]] = (),
) -> SurgicalField:
    """Find the field of some points on a skin, seen along its normal there; where there are none, of all of it.

    Parameters
    ----------
    found
        The points in mm, shape (k, 3).
    points
        Vertices in mm, shape (n, 3).
    skin
        Vertex indices of the skin's triangles, shape (m, 3).
    everything
        Points of all there is in mm, shape (k, 3) each; left out: the skin's vertices.

    Returns
    -------
    SurgicalField
        The field.
    """
    whole = not len(found)
    field = np.concatenate(everything or [points[np.unique(skin)]]) if whole else found
    low, high = field.min(axis=0) - MARGIN, field.max(axis=0) + MARGIN
    corners = points[skin]
    middle = corners.mean(axis=1)
    near = ((middle >= low) & (middle <= high)).all(axis=1)
    face = area_normals(corners)
    normals = face[near].sum(axis=0) if near.any() else face.sum(axis=0)
    length = float(np.linalg.norm(normals))
    normal = normals / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
    seed = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.8 else np.array([0.0, 0.0, 1.0])
    up = seed - (seed @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    axes = np.stack([right, up, normal])
    local = field @ axes.T
    center = (local.min(axis=0) + local.max(axis=0)) / 2 @ axes
    return SurgicalField(field, center, right, up, normal, WHOLE_FILL if whole else FIELD_FILL)


def viewpoint(
    field: SurgicalField, view: str, tangents: tuple[float, float], turned: float = TURN, steeper: float = 0.0
) -> Viewpoint:
    """Place the nearest camera in a view's direction that holds the whole field within its share of the picture.

    Parameters
    ----------
    field
        The field.
    view
        One of `VIEWS`.
    tangents
        Tangents of half the horizontal and vertical field of view (`half_angles`).
    turned
        Degrees to the right, but for a view from above.
    steeper
        Degrees by which the view is nearer to one from above than it is by its name.

    Returns
    -------
    Viewpoint
        The camera.
    """
    own = VIEWS[view] + steeper
    steep = own if field.context == 1.0 else 90.0 - LEANING * (90.0 - own)
    elevation = np.radians(steep)
    # An oblique plate looks from below right of the field, so that both lips of a wound show; of a body's skin that
    # faces down, such as an upper lid's, from above right, or the body would be seen from below.
    turn = 0.0 if view == "top" else np.radians(turned)
    overhang = field.context > 1.0 and field.normal[2] < OVERHANG
    ground = (1.0 if overhang else -1.0) * np.cos(turn) * field.up + np.sin(turn) * field.right
    back = np.sin(elevation) * field.normal + np.cos(elevation) * ground
    flat_up = field.up if view == "top" or overhang else field.normal
    return viewpoint_along(field, back, flat_up, tangents)


def viewpoint_on_skin(
    field: SurgicalField, view: str, tangents: tuple[float, float], skin: NDArray[np.float64]
) -> Viewpoint:
    """Place a camera as `viewpoint` does, but steeper where the picture would show what lies beyond the skin's border.

    Parameters
    ----------
    field
        The field.
    view
        One of `VIEWS`; only an oblique view of tissue without a body around it is changed.
    tangents
        Tangents of half the horizontal and vertical field of view (`half_angles`).
    skin
        Points of the skin in mm, shape (k, 3).

    Returns
    -------
    Viewpoint
        The camera; the usual one where `STEEPEST` degrees are not enough.
    """
    usual = viewpoint(field, view, tangents)
    if view != "oblique" or field.context != 1.0 or field.fill == WHOLE_FILL:
        return usual
    turns = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    ways = np.outer(np.cos(turns), field.right) + np.outer(np.sin(turns), field.up)
    reach = (skin @ ways.T).max(axis=0)  # what is no farther in any direction lies within the skin's hull
    height = float(np.median(skin @ field.normal))
    for steeper in np.arange(0.0, STEEPEST + 1.0, 2.0):
        seen = viewpoint(field, view, tangents, steeper=float(steeper)) if steeper else usual
        rays = np.array([(x * tangents[0], y * tangents[1], -1.0) for x in (-1, 1) for y in (-1, 1)]) @ seen.axes
        far = (height - seen.position @ field.normal) / (rays @ field.normal)
        corners = seen.position + far[:, None] * rays
        if (far > 0.0).all() and (corners @ ways.T <= reach).all():
            return seen
    return usual


def viewpoint_along(
    field: SurgicalField, back: NDArray[np.float64], upward: NDArray[np.float64], tangents: tuple[float, float]
) -> Viewpoint:
    """Place the nearest camera in a direction that holds the whole field within its share of the picture.

    Parameters
    ----------
    field
        The field.
    back
        Unit vector from the tissue to the camera, shape (3,).
    upward
        What is up in the picture, shape (3,), not along `back`.
    tangents
        Tangents of half the horizontal and vertical field of view (`half_angles`).

    Returns
    -------
    Viewpoint
        The camera.
    """
    up = upward - (upward @ back) * back
    up /= np.linalg.norm(up)
    right = np.cross(up, back)
    local = (field.points - field.center) @ np.stack([right, up, back]).T
    room = np.asarray(tangents) * field.fill
    # Shift sideways and up so that the field is centerd as the camera sees it, then stand just far enough.
    shift = np.zeros(2)
    distance = 0.0
    for _ in range(12):
        xy = np.abs(local[:, :2] - shift) / room
        distance = float((xy.max(axis=1) + local[:, 2]).max())
        seen = (local[:, :2] - shift) / (distance - local[:, 2])[:, None]
        shift = shift + 0.5 * (seen.min(axis=0) + seen.max(axis=0)) * distance
    position = field.center + shift[0] * right + shift[1] * up + distance * back
    return Viewpoint(position, np.stack([right, up, back]), distance)
