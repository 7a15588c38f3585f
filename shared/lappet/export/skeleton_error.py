"""How far vertices that bones move are from where they should be, measured in the file with USD's own skinning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lappet.export.play_times import Shown
from lappet.export.skeleton_stage import BODY, METRES, mesh_path
from lappet.export.skinned_shape import SkinnedShape
from lappet.usd.stage import pxr


@dataclass(frozen=True)
class SkeletonError:
    """The error of all vertices that are shown, over all frames.

    Parameters
    ----------
    greatest
        The greatest, in mm.
    rms
        The root of the mean square, in mm.
    """

    greatest: float
    rms: float


def skeleton_error(path: Path, shapes: Sequence[SkinnedShape], times: Sequence[Shown]) -> SkeletonError:
    """Read a file and compare every frame.

    Parameters
    ----------
    path
        The file.
    shapes
        The shapes in it, as they should be.
    times
        When each frame is shown.

    Returns
    -------
    SkeletonError
        The error.
    """
    usd = pxr()
    stage = usd.Usd.Stage.Open(str(path))
    cache = usd.UsdSkel.Cache()
    cache.Populate(usd.UsdSkel.Root(stage.GetPrimAtPath(BODY)), usd.Usd.PrimDefaultPredicate)
    skeleton = cache.GetSkelQuery(usd.UsdSkel.Skeleton(stage.GetPrimAtPath(f"{BODY}/Skeleton")))
    greatest, total, count = 0.0, 0.0, 0
    for each in times:
        for moment in dict.fromkeys((each.begin, each.end)):
            motion = skeleton.ComputeSkinningTransforms(moment)
            for shape in shapes:
                mesh = stage.GetPrimAtPath(mesh_path(shape.shape.name))
                points = usd.UsdGeom.Mesh(mesh).GetPointsAttr().Get()
                cache.GetSkinningQuery(mesh).ComputeSkinnedPoints(motion, points, moment)
                found = np.asarray(points, np.float64) / METRES
                for own in shape.sets:
                    if each.frame in own.frames:
                        rows = slice(*own.vertices)
                        wanted = shape.shape.positions[shape.shape.frames.index(each.frame), rows]
                        squared = ((found[rows] - wanted) ** 2).sum(axis=1)
                        greatest = max(greatest, float(squared.max()) ** 0.5)
                        total, count = total + float(squared.sum()), count + len(squared)
    return SkeletonError(greatest, (total / max(count, 1)) ** 0.5)
