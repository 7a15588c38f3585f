"""What all panels of a plate share: the solved procedure, the camera, and the parts that ride on the skin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.framing import SurgicalField, Viewpoint, half_angles, surgical_field, viewpoint, widened
from lappet.drawing.hook_steel import HookSteel
from lappet.drawing.scenery_read import SceneryMesh
from lappet.drawing.skin_marks import SkinMarks
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SkinSource
from lappet.drawing.suture_bites import bites_at, carried
from lappet.drawing.suture_thread import SutureThread, buried_sutures
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.feature_lines import FeatureLine, LineKind
from lappet.plates.letter_anchors import Corner, cut_corners
from lappet.plates.projection import Projection

_FILL = (0.74, 0.84)  # shares of a panel's width and height that the operation takes up
_PLAN_STEP = 0.25  # mm
_ON_SKIN = 0.5  # mm: marks and threads that ride on the skin may lie so far behind it
_CROWDED = 4.5  # mm on paper: of corners that are nearer to each other one has a letter
_NEAR = 2.0 / 3.0  # power of the body around an operation that is left where it is seen from nearer
_BESIDE = (2.5, 4.0, 6.0)  # mm from a corner at which its tissue is looked for: a narrow wound is wider farther out
_TIP = np.radians(175.0)  # a wider sector is no corner of its tissue
_GONE = 1.0  # mm: a place at rest that is farther from all skin has been excised
_LIGHT = (-0.85, 0.55, 1.0)  # right, up, out of the skin: from the upper left, as in Blender's pictures


@dataclass(frozen=True, eq=False)
class PlateScene:
    """A procedure before a camera.

    Parameters
    ----------
    source
        The solved procedure.
    field
        The surgical field.
    view
        The camera.
    scenery
        What is shown around the tissue.
    bed
        The tissue below.
    lines
        The planned cuts at rest in mm, each of shape (k, 3).
    marks, threads, hooks
        What is drawn on the skin.
    whole_skin
        The uncut skin at rest.
    corners
        The corners of what is cut.
    kept
        For each the index of the sector that keeps its letter: a narrow one that is not excised; 0 where all are.
    axes
        Rows right and up along the skin as the picture is seen, and the skin's normal, shape (3, 3).
    zoom
        How many times larger than the whole operation a detail is seen.
    """

    source: SkinCache
    field: SurgicalField
    view: Viewpoint
    scenery: tuple[SceneryMesh, ...]
    bed: DeepBed
    lines: tuple[NDArray[np.float64], ...]
    marks: SkinMarks
    threads: SutureThread
    hooks: HookSteel
    whole_skin: ClosestPoint
    corners: tuple[Corner, ...]
    kept: tuple[int, ...]
    axes: NDArray[np.float64]
    zoom: float = 1.0

    def projection(self, size: tuple[float, float]) -> Projection:
        """Tell how the tissue comes onto a panel.

        Parameters
        ----------
        size
            Width and height of the panel in mm.

        Returns
        -------
        Projection
            The projection.
        """
        return Projection(self.view, size, half_angles(size)[0] / self.zoom)

    @property
    def light(self) -> NDArray[np.float64]:
        """Unit vector towards the light, shape (3,)."""
        way = np.asarray(_LIGHT) @ self.axes
        unit: NDArray[np.float64] = way / np.linalg.norm(way)
        return unit

    @property
    def goes_on(self) -> bool:
        """Whether skin is drawn where a cut-out of skin ends: where nothing else is shown around it."""
        return not self.scenery

    def strands(self, time: float) -> list[FeatureLine]:
        """Find what is drawn on the skin and beside it.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        list[FeatureLine]
            Marks of the pen, threads and hooks.
        """
        whole = self.source.epoch_at(time).name == self.source.epochs[0].name
        kind = LineKind.PLAN if whole else LineKind.UNDERMINED
        lines = [FeatureLine(kind, each, _ON_SKIN) for each in self.marks.tubes(time)[0]]
        lines += [FeatureLine(LineKind.THREAD, each, _ON_SKIN) for each in self.threads.tubes(time)[0]]
        return lines + [FeatureLine(LineKind.INSTRUMENT, each, _ON_SKIN) for each in self.hooks.tubes(time)[0]]

    def on_skin(self, places: NDArray[np.float64], time: float) -> NDArray[np.float64]:
        """Follow places of the skin at rest to a frame.

        Parameters
        ----------
        places
            Places at rest in mm, shape (k, 3); what does not lie on the skin stands for what is closest of it.
        time
            Time code of the frame.

        Returns
        -------
        NDArray[np.float64]
            Where they lie in mm, shape (k, 3); NaN where the tissue is gone.
        """
        return followed(self.source, self.whole_skin.query(places)[1], time)


def followed(source: SkinSource, places: NDArray[np.float64], time: float) -> NDArray[np.float64]:
    """Follow places of the skin at rest to a frame.

    Parameters
    ----------
    source
        The solved procedure.
    places
        Places on the skin at rest in mm, shape (k, 3).
    time
        Time code of the frame.

    Returns
    -------
    NDArray[np.float64]
        Where they lie in mm, shape (k, 3); NaN where the tissue is gone.
    """
    epoch = source.epoch_at(time)
    rest = source.rest(epoch)
    bites = bites_at(rest, epoch.triangles[epoch.origin == FaceOrigin.SKIN], places)
    placed = carried(bites, source.positions(epoch, time))
    placed[np.linalg.norm(carried(bites, rest) - places, axis=1) > _GONE] = np.nan
    return placed


def plate_scene(source: SkinCache, times: Sequence[float], view: str, size: tuple[float, float]) -> PlateScene:
    """Place the camera so that all of an operation is in the picture.

    Parameters
    ----------
    source
        The solved procedure.
    times
        Time codes of the panels.
    view
        One of `lappet.drawing.framing.VIEWS`.
    size
        Width and height of a panel in mm.

    Returns
    -------
    PlateScene
        The scene.
    """
    field = surgical_field(source, tuple(times))
    lines = source.planned_incisions(_PLAN_STEP)
    drawn = [field.points, *lines, *source.undermined_areas(8.0 * _PLAN_STEP)]
    points = np.concatenate(drawn)
    axes = np.stack([field.right, field.up, field.normal])
    local = points @ axes.T
    center = 0.5 * (local.min(axis=0) + local.max(axis=0)) @ axes
    field = replace(field, points=points, center=center, fill=_FILL)
    if source.scenery:
        epoch = source.epochs[0]
        field = widened(field, source.rest(epoch)[np.unique(epoch.triangles)].astype(np.float64))
    camera = viewpoint(field, view, half_angles(size))
    right = camera.axes[0] - (camera.axes[0] @ field.normal) * field.normal
    right /= np.linalg.norm(right)
    seen = np.stack([right, np.cross(field.normal, right), field.normal])
    scale = field.stitch_scale
    scale_on_paper = 0.5 * size[0] / half_angles(size)[0] / camera.distance
    first = source.epochs[0]
    skin = ClosestPoint(source.rest(first), first.triangles[first.origin == FaceOrigin.SKIN])
    corners = tuple(cut_corners(lines, field.normal, _CROWDED / (scale_on_paper * nearest_zoom(field))))
    return PlateScene(
        source,
        field,
        camera,
        source.scenery,
        DeepBed(source),
        tuple(lines),
        SkinMarks(source),
        SutureThread(source, seen[0] + 0.6 * seen[1], scale, buried_sutures(source)),
        HookSteel(source, seen, field.center, scale),
        skin,
        corners,
        tuple(_kept(source, skin, corner) for corner in corners),
        seen,
    )


def nearest_zoom(field: SurgicalField) -> float:
    """Tell how much nearer an operation on a body is seen where the body was recognized before.

    Parameters
    ----------
    field
        The surgical field.

    Returns
    -------
    float
        How many times larger; 1 where no body is shown around it.
    """
    return field.context ** (1.0 - _NEAR)


def at_one_scale(scenes: Sequence[PlateScene]) -> list[PlateScene]:
    """Move cameras back so that all scenes are drawn at the scale of the largest.

    Parameters
    ----------
    scenes
        The scenes.

    Returns
    -------
    list[PlateScene]
        The same, each seen from the greatest distance of all.
    """
    far = max(scene.view.distance for scene in scenes)
    moved = []
    for scene in scenes:
        back = (far - scene.view.distance) * scene.view.axes[2]
        view = replace(scene.view, position=scene.view.position + back, distance=far)
        moved.append(replace(scene, view=view))
    return moved


def _kept(source: SkinSource, skin: ClosestPoint, corner: Corner) -> int:
    """The sector that keeps a corner's letter: of tips that are there at the end, what is carried farthest."""
    count = len(corner.sectors)
    places = skin.query(np.array([corner.inset(far, k) for k in range(count) for far in _BESIDE]))[1]
    ends = followed(source, places, source.frames[-1])
    there = np.isfinite(ends).all(axis=1).reshape(count, -1).all(axis=1)
    if not there.any():
        return 0
    angles = np.array([each.angle for each in corner.sectors])
    tips = there & (angles < _TIP)
    near = tips if tips.any() else there & (angles <= angles[there].min())
    moved = np.linalg.norm(ends - places, axis=1).reshape(count, -1).max(axis=1)
    return int(np.argmax(np.where(near, moved, -1.0)))
