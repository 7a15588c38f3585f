"""The tissue of a model: a sheet below its skin that is held at its outer border and free at the openings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.flatten import flatten
from lappet.geometry.mesh_faults import EDGES, refuse_faults
from lappet.models.body_surface import BodySurface
from lappet.procedure import Tissue
from lappet.tissue.inner_side import Surroundings
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.open_mesh_tissue import sheet_uv
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.thicken import Sheet, rim_rows, thicken


def model_sheet(skin: BodySurface, around: BodySurface, thickness: float, spacing: float, name: str) -> Tissue:
    """Make the tissue below the skin of a model.

    The subset "fixed" is the rim at the longest border; "rim" is all of it, that of eyes, mouth and nostrils as well,
    which is free. "underside" is all of the underside, "bed" what of it lies on a bed: not what lies on free inner
    skin, such as the back of an ear.

    Parameters
    ----------
    skin
        The skin.
    around
        The skin that it was cut from.
    thickness
        Thickness of the sheet in mm; it is less where there is no room for it.
    spacing
        Edge of the lattice's cells in mm.
    name
        What messages call the model.

    Returns
    -------
    Tissue
        The tissue, made of one material.

    Raises
    ------
    RefusedError
        If there is no room for a sheet; names the place.
    """
    points, triangles = skin.points, skin.triangles
    refuse_faults(name, points, triangles, EDGES)
    uv = flatten(points, triangles)
    rows = rim_rows(points, triangles, thickness)
    sheet = thicken(points, triangles, thickness, rows, name, Surroundings.of(around.points, around.triangles, points))
    refuse_faults(name, sheet.points, sheet.triangles)
    held = _outer_rim(sheet, points, triangles)
    faces = {
        "fixed": held,
        "bed": sheet.underside & ~sheet.lining,
        "rim": sheet.rim,
        "underside": sheet.underside,
    }
    flat = sheet_uv(sheet, Mesh(points, triangles), uv)
    return Tissue(
        points=sheet.points.astype(np.float32).astype(np.float64),
        face_vertex_counts=np.full(len(sheet.triangles), 3, np.int32),
        face_vertex_indices=sheet.triangles.reshape(-1).astype(np.int32),
        uv=(UV_SCALE * flat).reshape(-1, 2).astype(np.float32),
        subsets={subset: np.flatnonzero(mask).astype(np.int32) for subset, mask in faces.items()},
        spacing=spacing,
    )


def _outer_rim(sheet: Sheet, points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which triangles are rim below the longest border."""
    outer = max(border_loops(triangles), key=lambda loop: perimeter(points, loop))
    below = np.zeros(len(points), bool)
    below[outer] = True
    return np.asarray(sheet.rim & below[sheet.top[sheet.triangles]].all(axis=1))
