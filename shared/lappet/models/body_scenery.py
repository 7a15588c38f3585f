"""What of the body is shown around a model: skin up to its border, the eyes, the teeth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.catmull_clark import catmull_clark
from lappet.models.body_mesh import EYES, TEETH, body_mesh
from lappet.models.body_shape import NEUTRAL, BodyShape, shaped
from lappet.models.body_surface import body_surface
from lappet.models.model import Model
from lappet.procedure import Scenery, SceneryKind
from lappet.tissue.crop_mesh import Level, crop
from lappet.tissue.mesh_file import Mesh

_IRIS, _PUPIL = 26.0, 9.0  # degrees from the front of the eye
_EYE_DIVISIONS = 2


def body_scenery(shape: BodyShape, model: Model) -> tuple[Scenery, ...]:
    """Make the scenery of a model.

    Parameters
    ----------
    shape
        The shape of the body.
    model
        The model.

    Returns
    -------
    tuple[Scenery, ...]
        The skin around the model, cut as the model is, and what of eyes and teeth lies in its surroundings.

    Raises
    ------
    RefusedError
        If the shape is refused, or the package is not there.
    """
    around = body_surface(shape, model.surround, model.subdivision, model.cleft)
    if model.cleft is not None:
        around = replace(around, points=around.cleft(model.cleft))
    rest = around.within(model.surround).outside(model.region)
    found = [_scenery("skin_around", rest.points, rest.triangles, "skin")]
    mesh, neutral, points = body_mesh(), shaped(NEUTRAL), shaped(shape)
    low, high = (np.array(corner) for corner in model.surround)
    for group, side in zip(EYES, ("left", "right"), strict=True):
        quads = mesh.faces_of((group,))
        middle = neutral[np.unique(quads)].mean(axis=0)
        if ((middle > low) & (middle < high)).all():
            found += _eye(points, quads, side)
    quads = mesh.faces_of(TEETH)
    middle = neutral[np.unique(quads)].mean(axis=0)
    if ((middle > low) & (middle < high)).all():
        found.append(_scenery("teeth", *_divided(points, quads, 1), "teeth"))
    return tuple(found)


def _eye(points: NDArray[np.float64], quads: NDArray[np.int64], side: str) -> list[Scenery]:
    """An eye in three parts by the angle to its front."""
    points, quads = _divided(points, quads, _EYE_DIVISIONS)
    ball = Mesh(points, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))
    center = points.mean(axis=0)

    def beyond(degrees: float) -> Level:
        def level(at: NDArray[np.float64]) -> NDArray[np.float64]:
            away = at - center
            return np.asarray(np.arccos(away[:, 1] / np.linalg.norm(away, axis=1)) - np.radians(degrees))

        return level

    def before(degrees: float) -> Level:
        outside = beyond(degrees)
        return lambda at: -outside(at)

    parts: tuple[tuple[SceneryKind, list[Level]], ...] = (
        ("eye", [before(_IRIS)]),
        ("iris", [beyond(_IRIS), before(_PUPIL)]),
        ("pupil", [beyond(_PUPIL)]),
    )
    cut = [(kind, crop(ball, levels)) for kind, levels in parts]
    return [_scenery(f"{kind}_{side}", part.points, part.triangles, kind) for kind, part in cut]


def _divided(
    points: NDArray[np.float64], quads: NDArray[np.int64], times: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    used, compact = np.unique(quads, return_inverse=True)
    points, quads = points[used], compact.reshape(-1, 4).astype(np.int64)
    for _ in range(times):
        points, quads = catmull_clark(points, quads)
    return points, quads


def _scenery(name: str, points: NDArray[np.float64], faces: NDArray[np.int64], kind: SceneryKind) -> Scenery:
    used, compact = np.unique(faces, return_inverse=True)
    return Scenery(
        name,
        np.round(points[used], 2).astype(np.float32).astype(np.float64),
        np.full(len(faces), faces.shape[1], np.int32),
        compact.reshape(-1).astype(np.int32),
        kind,
    )
