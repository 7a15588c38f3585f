"""Where the camera of a panel is, in mm of the tissue, and the view of a viewport as such a camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from lappet.drawing.framing import SurgicalField, field_around, half_angles, viewpoint, viewpoint_along, widened
from lappet.plates.panel_camera import own_direction

from ..model.decimals import decimals
from ..model.plate_values import panel_value
from ..model.scenery_values import scenery_points
from ..model.units import mm_per_unit, to_world
from ..tools.handles import event_points
from ..tools.shown_surface import ShownSurface

FILLS = 0.9  # of a viewport: the frame of a panel
_ASPECT = 0.75  # of a plate's panels
_GUTTER = 4.0  # mm between panels
_WIDE = 120.0  # mm from which a page has three panels in a row


@dataclass(frozen=True, eq=False)
class PanelView:
    """A camera. at: the place that it looks at, mm. axes: to the right, up and backwards. across: tissue there, mm."""

    at: NDArray[np.float64]
    axes: NDArray[np.float64]
    across: float


def panel_size(plate: Any) -> tuple[float, float]:
    """Width and height of a panel of a plate on paper, mm; of one in whose captions nothing is known, roughly."""
    columns = int(plate.columns) or min(max(len(plate.panels), 1), 3 if plate.width >= _WIDE else 2)
    width = max((float(plate.width) - (columns - 1) * _GUTTER) / columns, 10.0)
    return width, _ASPECT * width


def pixels_per_mm(plate: Any, region: tuple[float, float]) -> float:
    """Pixels of a region (its width and height) for a millimeter of paper of a panel that fills it."""
    width, height = panel_size(plate)
    return FILLS * min(region[0] / width, region[1] / height)


def panel_view(scene: bpy.types.Scene, plate: Any, panel: Any, surface: ShownSurface) -> PanelView:
    """The camera of a panel before the surface that is shown."""
    value, tangents = panel_value(panel), half_angles((4.0, 3.0))
    field = _field(scene, surface)
    own = own_direction(value)
    view = viewpoint(field, value.view or str(plate.view), tangents)
    if own is not None:
        view = viewpoint_along(field, *own, tangents)
    if value.at is not None:
        located = surface.rest.locate(np.array([value.at]))
        return PanelView(surface.carry(located)[0] * surface.mm, view.axes, value.across)
    return PanelView(view.position - view.distance * view.axes[2], view.axes, 2.0 * tangents[0] * view.distance)


def take_view(scene: bpy.types.Scene, panel: Any, data: bpy.types.RegionView3D, surface: ShownSurface) -> None:
    """Give a panel the camera of a viewport: its direction, and the place and width that the panel's frame shows."""
    rotation = np.array(data.view_rotation.to_matrix())
    panel.view = "OWN"
    panel.look_from, panel.look_up = decimals(np.round(rotation[:, 2], 5)), decimals(np.round(rotation[:, 1], 5))
    center = np.array(data.view_location)
    back = rotation[:, 2]
    found = surface.ray.first((center + 1e4 * back / surface.mm).tolist(), (-back).tolist())
    if found is not None:  # what is in the middle of the view
        triangle, weights, _ = found
        rest = surface.rest.points[surface.rest.triangles[triangle]]
        panel.cropped, panel.at = True, np.round(np.asarray(weights) @ rest, 3).tolist()
        panel.across = max(2.0, round(width_of(data) * FILLS * mm_per_unit(scene), 1))
    else:
        panel.cropped = False


def look_through(scene: bpy.types.Scene, data: bpy.types.RegionView3D, view: PanelView) -> None:
    """Turn a viewport to a panel's camera, so that the panel's frame fills it."""
    data.view_perspective = "PERSP"
    data.view_rotation = Matrix(view.axes.T.tolist()).to_quaternion()
    data.view_location = to_world(scene, view.at.tolist())
    data.view_distance = max(1e-3, data.view_distance)
    data.view_distance *= view.across / FILLS / mm_per_unit(scene) / max(width_of(data), 1e-9)
    data.update()


def width_of(data: bpy.types.RegionView3D) -> float:
    """How much of the world a viewport shows from its left to its right side, at the place that it turns about."""
    data.update()
    scale = float(data.window_matrix[0][0])
    flat = data.window_matrix[3][3] == 1.0
    return (2.0 if flat else 2.0 * float(data.view_distance)) / max(abs(scale), 1e-9)


def _field(scene: bpy.types.Scene, surface: ShownSurface) -> SurgicalField:
    """The surgical field: where the events are, or all skin where there are none."""
    points = [event_points(event) for event in scene.lappet.events if event.enabled and len(event.points)]
    skin = surface.rest.triangles[surface.rest.skin]
    if not points:
        return field_around(np.zeros((0, 3)), surface.positions * surface.mm, skin)
    located = surface.rest.locate(np.concatenate(points))
    outward = surface.normals(located.triangle).sum(axis=0)
    # Of a closed mesh all faces may be skin, those of the underside too.
    near_side = surface.normals(surface.rest.skin) @ outward > 0.0
    field = field_around(surface.carry(located) * surface.mm, surface.positions * surface.mm, skin[near_side])
    if not scenery_points(scene):
        return field
    return widened(field, surface.rest.points[np.unique(surface.rest.triangles)])  # as the plate itself is drawn
