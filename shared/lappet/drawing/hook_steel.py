"""Draw the active hooks of a frame as steel skin hooks that reach in from both sides of the field."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.epoch_searches import EpochSearches
from lappet.drawing.hook_path import hook_directions, hook_path
from lappet.drawing.skin_source import SkinEpoch, SkinSource


class HookSteel:
    """The hooks of a procedure; each keeps one direction for its whole life.

    Parameters
    ----------
    source
        The solved procedure.
    axes
        Unit vectors to the right, up along the skin and along its normal, as the picture is seen, shape (3, 3).
    center
        The middle of the picture in mm, shape (3,).
    scale
        Of all thicknesses.
    searches
        What is known of its epochs; None: nothing.
    """

    def __init__(
        self,
        source: SkinSource,
        axes: NDArray[np.float64],
        center: NDArray[np.float64],
        scale: float,
        searches: EpochSearches | None = None,
    ) -> None:
        self._source, self._normal, self._scale = source, axes[2], scale
        courses = source.hook_courses()
        found = hook_directions(list(courses.values()), center, axes)
        self._directions = dict(zip(courses, found, strict=True))
        self._searches = EpochSearches() if searches is None else searches

    def knows(self, epoch: SkinEpoch) -> bool:
        """Tell whether a hook was drawn in an epoch before.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        bool
            Whether it was.
        """
        return self._searches.knows_skin(epoch)

    def tubes(self, time: float) -> tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]]:
        """Draw the hooks that are active at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]]
            Their courses in mm, each of shape (k, 3), and their radii in mm, each of shape (k,).
        """
        drawn = self.named_tubes(time).values()
        return [line for line, _ in drawn], [radii for _, radii in drawn]

    def named_tubes(self, time: float) -> dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Draw the hooks that are active at a frame, and say which each is.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]
            Course, shape (k, 3), and radii, shape (k,), in mm, by the index of the hook.
        """
        hooks = self._source.hooks(time)
        active = [int(i) for i in np.flatnonzero(hooks.active) if int(i) in self._directions]
        if not active:
            return {}
        epoch = self._source.epoch_at(time)
        points = self._source.positions(epoch, time)
        found = {}
        for index in active:
            anchor = hooks.ends[index, 0].astype(np.float64)
            direction = self._directions[index]
            normal, edge = self._hold(epoch, points, anchor, direction)
            found[index] = hook_path(anchor, direction, normal, edge, self._scale)
        return found

    def _hold(
        self,
        epoch: SkinEpoch,
        points: NDArray[np.float32],
        anchor: NDArray[np.float64],
        direction: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The skin's normal at an anchor and the direction to the nearest edge, both (3,) unit."""
        normals = self._searches.normals(epoch, len(points))
        used, border = self._searches.skin_and_rim(epoch, len(points))
        away = ((points[used] - anchor.astype(np.float32)) ** 2).sum(axis=1)
        nearest = used[np.argpartition(away, min(3, len(away) - 1))[:4]]
        normal = normals.at(points, nearest).sum(axis=0)
        length = float(np.linalg.norm(normal))
        normal = normal / length if length > 1e-6 else self._normal
        rim = points[border]
        near = rim[np.linalg.norm(rim - anchor, axis=1) < 4.0 * self._scale]
        if len(near):
            # The edge that lies most in the direction of the handle, so that the shank does not cross the flap.
            way = near - anchor
            way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
            return normal, way[int((way @ direction).argmax())].astype(np.float64)
        return normal, direction
