"""The camera of a panel that is seen otherwise than the plate: from elsewhere, with less of the body, or cropped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import Viewpoint, half_angles, viewpoint, viewpoint_along
from lappet.plates.plate_scene import PlateScene, nearest_zoom
from lappet.plates.skin_anchors import SkinAnchors
from lappet.procedure.plate import PlatePanel

MOST_AROUND = 2.2  # times the operation: more of a body around it makes it too small to see
LEAST_ACROSS = 2.0  # mm: less is smaller than a cell of the lattice


def with_camera(scene: PlateScene, panel: PlatePanel, time: float, size: tuple[float, float]) -> PlateScene:
    """Look at a scene as a panel says.

    A crop is a longer lens and not a nearer camera, so that the camera never enters the tissue.

    Parameters
    ----------
    scene
        The procedure before the plate's camera.
    panel
        The panel.
    time
        Time code of its frame.
    size
        Its width and height in mm on paper.

    Returns
    -------
    PlateScene
        The procedure before the panel's camera.
    """
    view, zoom = scene.view, scene.zoom
    if panel.view:
        view = viewpoint(scene.field, panel.view, half_angles(size))
    own = own_direction(panel)
    if own is not None:
        view = viewpoint_along(scene.field, *own, half_angles(size))
    if panel.at is not None:
        places, _ = SkinAnchors(scene.source).at(np.array([panel.at]), time, last_place=True)
        view = Viewpoint(places[0] + view.distance * view.axes[2], view.axes, view.distance)
        zoom = 2.0 * half_angles(size)[0] * view.distance / panel.across
    if view is scene.view:
        return scene
    right = view.axes[0] - (view.axes[0] @ scene.field.normal) * scene.field.normal
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(scene.field.normal, right), scene.field.normal])
    return replace(scene, view=view, zoom=zoom, axes=axes)


def with_body(scene: PlateScene, opens: bool) -> PlateScene:
    """See more or less of the body around an operation, by another lens.

    Parameters
    ----------
    scene
        The procedure before the plate's camera.
    opens
        Whether the panel opens the plate and tells where on the body that is; the others are nearer.

    Returns
    -------
    PlateScene
        The same through that lens; as it was where no body is shown around it.
    """
    near = nearest_zoom(scene.field)
    far = max(scene.field.context / MOST_AROUND, 1.0)
    return replace(scene, zoom=scene.zoom * (min(far, near) if opens else near))


def own_direction(panel: PlatePanel) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Tell from where a panel with a camera of its own is seen.

    Parameters
    ----------
    panel
        The panel.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]] or None
        Unit vectors from the tissue to the camera and up in the picture, shape (3,) each; None where it has none, or
        where the two are no directions or lie along each other.
    """
    if panel.look_from is None or panel.look_up is None:
        return None
    back, up = np.array(panel.look_from), np.array(panel.look_up)
    lengths = np.linalg.norm(back), np.linalg.norm(up)
    if not all(np.isfinite(each) and each > 1e-9 for each in lengths):
        return None
    back, up = back / lengths[0], up / lengths[1]
    return None if np.linalg.norm(np.cross(back, up)) < 1e-6 else (back, up)
