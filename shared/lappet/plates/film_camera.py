"""The camera of a film: it stands, or turns slowly about the operation between the steps."""

from __future__ import annotations

from dataclasses import replace

from lappet.drawing.framing import TURN, Viewpoint, half_angles, viewpoint
from lappet.plates.plate_scene import PlateScene

MOST_TURN = 120.0  # degrees: farther, the field is seen from behind


def camera_way(scene: PlateScene, view: str, size: tuple[float, float], degrees: float, count: int) -> list[PlateScene]:
    """Turn the camera about the field's normal, evenly from picture to picture, at one distance.

    Parameters
    ----------
    scene
        The procedure before the camera from which the way is measured: its middle.
    view
        One of `lappet.drawing.framing.VIEWS`.
    size
        Width and height of the picture in mm.
    degrees
        How far it turns from the first picture to the last, to the right; 0: it stands.
    count
        Number of pictures.

    Returns
    -------
    list[PlateScene]
        The procedure before the camera of each picture. The light stays where it is.
    """
    if degrees == 0.0 or count < 2:
        return [scene] * count
    tangents = half_angles(size)
    shares = [k / (count - 1) for k in range(count)]
    views = [viewpoint(scene.field, view, tangents, TURN + degrees * (_eased(share) - 0.5)) for share in shares]
    far = max(each.distance for each in views)
    return [replace(scene, view=_moved_back(each, far)) for each in views]


def _eased(share: float) -> float:
    """A way that begins and ends slowly."""
    return share * share * (3.0 - 2.0 * share)


def _moved_back(view: Viewpoint, distance: float) -> Viewpoint:
    return replace(view, position=view.position + (distance - view.distance) * view.axes[2], distance=distance)
