"""A picture of a mesh in which the part that became tissue is marked: `lappet new --picture`.

Two views beside each other: the whole mesh, and its surroundings of the field from the side. What was taken is colored,
blue where the sheet is much thinner than elsewhere; all else is gray.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import LINING
from lappet.geometry.normals import vertex_normals
from lappet.geometry.triangles import areas, directions
from lappet.output.raster import Raster, rasterize
from lappet.procedure import Tissue
from lappet.tissue.mesh_file import Mesh

_VIEW = (640, 640)  # pixels of one view
_FINER = 2  # rows and columns that are averaged to one
_PAPER = np.array([1.0, 1.0, 1.0])
_MESH, _TAKEN, _THIN, _LINE = (
    np.array(color) for color in ((0.80, 0.79, 0.77), (0.95, 0.55, 0.38), (0.25, 0.42, 0.85), (0.25, 0.08, 0.05))
)
_SMALL = 128  # pixels of the side of a view that is only measured
_CLOSER = 3.0  # of the field's radius: what the second view shows around its middle
_TURNED = np.radians(35.0)  # of the second view about the vertical
_THINNER, _THINNEST = 0.75, 0.25  # of the largest thickness: from the one to the other the color turns to blue
_FORWARD = 0.015  # of the mesh's extent by which what was taken is drawn before the mesh
_AMBIENT = 0.35


@dataclass(frozen=True, eq=False)
class _Skin:
    """Triangles to draw: points (n, 3), indices (m, 3), normals (n, 3) and colors (n, 3)."""

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    normals: NDArray[np.float64]
    colors: NDArray[np.float64]


def mesh_picture(mesh: Mesh, tissue: Tissue) -> NDArray[np.uint8]:
    """Draw a mesh with the part of it that became tissue.

    Parameters
    ----------
    mesh
        The mesh, in mm.
    tissue
        Tissue of triangles that was made of it.

    Returns
    -------
    NDArray[np.uint8]
        Red, green and blue of each pixel from the top left on, shape (height, width, 3).
    """
    taken = _taken(tissue)
    corners = taken.points[taken.triangles]
    size = areas(corners)
    middle = (corners.mean(axis=1) * size[:, None]).sum(axis=0) / size.sum()
    radius = float(np.linalg.norm(corners.reshape(-1, 3) - middle, axis=1).max())
    used = mesh.points[np.unique(mesh.triangles)]
    whole_middle = 0.5 * (used.min(axis=0) + used.max(axis=0))
    whole_radius = 0.5 * float(np.linalg.norm(np.ptp(used, axis=0)))
    gray = _Skin(
        mesh.points, mesh.triangles, vertex_normals(mesh.points, mesh.triangles), np.tile(_MESH, (len(mesh.points), 1))
    )
    skins = [gray, taken]
    ahead = _best_direction(skins, middle, radius)
    views = [
        _view(skins, ahead, whole_middle, whole_radius),
        _view(skins, _about_vertical(ahead, _TURNED), middle, min(_CLOSER * radius, whole_radius)),
    ]
    return np.concatenate(views, axis=1)


def _taken(tissue: Tissue) -> _Skin:
    """The tissue's skin, colored by its thickness where it is a sheet."""
    triangles = tissue.face_vertex_indices.reshape(-1, 3).astype(np.int64)
    below = [faces for name, faces in tissue.subsets.items() if name in ("fixed", "bed", LINING)]
    skin = np.ones(len(triangles), bool)
    skin[np.concatenate([np.zeros(0, np.int32), *below])] = False
    top = triangles[skin]
    color = np.tile(_TAKEN, (len(tissue.points), 1))
    count = int(top.max()) + 1
    sheet = len(top) + sum(len(tissue.subsets.get(name, ())) for name in ("bed", LINING)) == 2 * len(top)
    if sheet and len(tissue.points) >= 2 * count:  # the underside's vertices follow the skin's in the same order
        thickness = np.linalg.norm(tissue.points[:count] - tissue.points[count : 2 * count], axis=1)
        share = thickness / max(float(thickness.max()), 1e-300)
        share = np.clip((share - _THINNEST) / (_THINNER - _THINNEST), 0.0, 1.0)[:, None]
        color[:count] = share * _TAKEN + (1.0 - share) * _THIN
    return _Skin(tissue.points, top, vertex_normals(tissue.points, top), color)


def _about_vertical(direction: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ direction


@dataclass(frozen=True, eq=False)
class _Drawn:
    """Skins as one view shows them: the raster, all triangles (m, 3), where the last skin's begin, and the axes."""

    raster: Raster
    triangles: NDArray[np.int64]
    last: int
    frame: NDArray[np.float64]


def _best_direction(skins: list[_Skin], middle: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """The direction from the field to the eye from which most of it is seen."""
    turns = np.radians(np.arange(0.0, 360.0, 30.0))
    level = [np.stack([np.sin(turns), -np.cos(turns), np.full(len(turns), z)], axis=1) for z in (-0.5, 0.0, 0.7)]
    candidates = directions(np.concatenate([*level, [[0.0, -1e-3, 1.0]]]))
    seen = []
    for ahead in candidates:
        drawn = _drawn(skins, ahead, middle, radius, (_SMALL, _SMALL))
        seen.append(int((drawn.raster.triangle >= drawn.last).sum()))
    return np.asarray(candidates[int(np.argmax(seen))])


def _drawn(
    skins: list[_Skin],
    ahead: NDArray[np.float64],
    middle: NDArray[np.float64],
    radius: float,
    size: tuple[int, int],
) -> _Drawn:
    """What is seen against `ahead` within a radius of a point; the last skin is drawn before the others."""
    up = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    right = directions(np.cross(up, ahead)[None])[0]
    frame = np.stack([right, np.cross(right, ahead), -ahead])  # to the right, downwards, away
    scale = 0.5 * min(size) / radius
    places, triangles, count = [], [], 0
    for skin in skins:
        place = (skin.points - middle) @ frame.T
        place[:, 2] -= _FORWARD * radius * (skin is skins[-1])
        places.append(place * scale + [0.5 * size[0], 0.5 * size[1], 0.0])
        triangles.append(skin.triangles + count)
        count += len(skin.points)
    faces = np.concatenate(triangles)
    raster = rasterize(np.concatenate(places)[faces], size)
    return _Drawn(raster, faces, len(faces) - len(skins[-1].triangles), frame)


def _view(
    skins: list[_Skin], ahead: NDArray[np.float64], middle: NDArray[np.float64], radius: float
) -> NDArray[np.uint8]:
    """The picture of one view; the last skin is outlined."""
    width, height = (_FINER * side for side in _VIEW)
    drawn = _drawn(skins, ahead, middle, radius, (width, height))
    shown = drawn.raster.triangle
    hit = shown >= 0
    corner = drawn.triangles[shown[hit]]
    weights = drawn.raster.weights[hit][:, :, None]
    normals = np.concatenate([skin.normals for skin in skins]) @ drawn.frame.T
    normal = directions((normals[corner] * weights).sum(axis=1))
    # From the eye and from the upper left; what faces away is lit as its other side.
    light = directions(np.array([[-0.45, -0.55, -0.7]]))[0]
    facing = np.where(normal[:, 2:] > 0.0, -1.0, 1.0)
    shade = _AMBIENT + (1.0 - _AMBIENT) * np.clip((facing * normal) @ light, 0.0, 1.0)
    colors = np.concatenate([skin.colors for skin in skins])
    picture = np.tile(_PAPER, (height, width, 1))
    picture[hit] = (colors[corner] * weights).sum(axis=1) * shade[:, None]
    picture[_outline(shown >= drawn.last)] = _LINE
    mean = picture.reshape(_VIEW[1], _FINER, _VIEW[0], _FINER, 3).mean(axis=(1, 3))
    return np.round(255.0 * np.clip(mean, 0.0, 1.0)).astype(np.uint8)


def _outline(marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pixels on either side of the border of what is marked, two wide."""
    border = np.zeros_like(marked)
    for axis in (0, 1):
        for shift in (1, 2):
            border |= marked != np.roll(marked, shift, axis)
    return border
