"""Make the manifest of a program: what an owner needs of it to show its frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import LayerSearch, TissueLayers
from lappet.background.manifest import EpochShape, ListedFrame, Manifest
from lappet.background.tissue_face import TissueFaces
from lappet.core.digest import digest
from lappet.core.problem import Problem
from lappet.cutting.epoch import Epoch
from lappet.geometry.labeled_surface import LINING, FaceOrigin, Surface
from lappet.geometry.skin_shape import uv_scale
from lappet.procedure import Tissue
from lappet.program.program import Program


def make_manifest(
    key: str,
    program: Program,
    frames: Sequence[str],
    shapes: Sequence[EpochShape],
    layers: TissueLayers,
    notes: Sequence[Problem] = (),
) -> Manifest:
    """Make the manifest of a program.

    Parameters
    ----------
    key
        Key of the manifest.
    program
        The program.
    frames
        Keys of its frames.
    shapes
        Shapes of its epochs.
    layers
        The layers of its tissue.
    notes
        Warnings and notes besides the program's own.

    Returns
    -------
    Manifest
        The manifest.
    """
    position = {epoch.index: i for i, epoch in enumerate(program.epochs)}
    return Manifest(
        key=key,
        epochs=tuple(shapes),
        frames=tuple(
            ListedFrame(
                round(frame.time),
                position[frame.epoch],
                frames[i],
                tuple(int(hook) for hook in frame.hook_index),
                tuple(int(suture) for suture in frame.suture_index),
            )
            for i, frame in enumerate(program.frames)
        ),
        hooks=program.hooks,
        sutures=program.sutures,
        landmarks=program.landmarks,
        landmarks_at=tuple(tuple(int(mark) for mark in marks.index) for marks in program.landmarks_at),
        notes=(*notes, *program.notes),
        layers=layers,
        vessels=program.vessels,
        vessels_at=program.vessels_at,
    )


def epoch_shapes(epochs: Sequence[Epoch], tissue: Tissue, layers: LayerSearch) -> tuple[EpochShape, ...]:
    """Make what is shown of the epochs of a tissue.

    Parameters
    ----------
    epochs
        The epochs.
    tissue
        The tissue.
    layers
        Its layers.

    Returns
    -------
    tuple[EpochShape, ...]
        A shape for each; the grid of all of them has the millimetres of the first one's skin.
    """
    if not epochs:
        return ()
    first = epochs[0].surface
    skin = first.origin == FaceOrigin.SKIN
    scale = uv_scale(first.points, first.triangles[skin], first.uv[skin])
    faces = TissueFaces(tissue)
    return tuple(_shape(epoch.surface, epoch.start_time, scale, faces, layers) for epoch in epochs)


def _shape(
    surface: Surface, start: float, scale: NDArray[np.float64], faces: TissueFaces, layers: LayerSearch
) -> EpochShape:
    found = layers.of(surface)
    rest = np.ascontiguousarray(surface.points, np.float32)
    triangles = np.ascontiguousarray(surface.triangles, np.int32)
    arrays: dict[str, NDArray[Any]] = {
        "rest": rest,
        "triangles": triangles,
        "origin": np.ascontiguousarray(surface.origin, np.uint8),
        "grid": (surface.uv * scale).astype(np.float32),
        "depth": found.depth,
        "face": faces.of(surface),
        "column": found.column,
    }
    if LINING in surface.grips:
        arrays["lining"] = surface.grips[LINING].astype(np.uint8)
    return EpochShape(digest("epoch shape", arrays).hex(), float(start), **arrays)
