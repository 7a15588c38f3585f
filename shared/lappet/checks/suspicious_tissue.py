"""What is suspicious about a tissue: a size that no skin has, parts that nothing joins, regions that overlap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.mesh_faults import MOST_PLACES
from lappet.geometry.surface_check import place, signed_volume
from lappet.procedure import Region, Tissue
from lappet.procedure.prim_paths import TISSUE
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.surface import LABELS

# mm; chosen: a patch of skin is longer than the one and shorter than the other, while metres or inches taken for
# millimetres are outside by far.
LEAST_LENGTH, MOST_LENGTH = 2.0, 1000.0


def size_problems(points: NDArray[np.float64]) -> list[Problem]:
    """Find whether the tissue is as large or as small as no skin is.

    Parameters
    ----------
    points
        Vertices of the tissue in mm, shape (n, 3).

    Returns
    -------
    list[Problem]
        The warning, if any.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    length, ends = float((high - low).max()), Place.at(low, high)
    if length > MOST_LENGTH:
        return [problem(ProblemCode.TISSUE_LARGE, TISSUE, f"{length:.6g}", place=ends, most=MOST_LENGTH)]
    if 0.0 < length < LEAST_LENGTH:
        return [problem(ProblemCode.TISSUE_SMALL, TISSUE, f"{length:.3g}", place=ends, least=LEAST_LENGTH)]
    return []


def separate_parts(tissue: Tissue) -> list[Problem]:
    """Find whether the closed surface of a tissue has several parts; cavities are none.

    Parameters
    ----------
    tissue
        The tissue; its mesh is closed and oriented alike.

    Returns
    -------
    list[Problem]
        The warning, if any, with faces and a point of each part but the largest.
    """
    triangles, faces = fan_triangles(tissue)
    of_triangle = parts_of(triangles.astype(np.int64), len(tissue.points))
    outwards = 1.0 if signed_volume(tissue.points, triangles) >= 0.0 else -1.0
    volumes = {int(k): outwards * signed_volume(tissue.points, triangles[of_triangle == k]) for k in set(of_triangle)}
    parts = sorted((k for k in volumes if volumes[k] > 0.0), key=lambda k: -volumes[k])
    if len(parts) < 2:
        return []
    middles = [tissue.points[triangles[of_triangle == k]].mean(axis=(0, 1)) for k in parts[1 : 1 + MOST_PLACES]]
    smaller = np.unique(faces[np.isin(of_triangle, parts[1:])])[:MOST_PLACES]
    where = Place(tuple(smaller.tolist()), Place.at(*middles).points)
    near = " and ".join(place(np.round(middle, 3)) for middle in middles[:3])
    return [
        problem(
            ProblemCode.TISSUE_SEPARATE, TISSUE, len(parts), place=where, largest=volumes[parts[0]], where=f"{near} mm"
        )
    ]


def overlapping_regions(tissue: Tissue, skin: NDArray[np.bool_]) -> list[Problem]:
    """Find regions of different material that share faces and depths, where their order decides: the last one counts.

    A region that lies within one before it, and leaves some of that, is meant: cartilage in the fat of an ear.

    Parameters
    ----------
    tissue
        The tissue; its subsets name faces that it has.
    skin
        Which faces are skin, shape (m,).

    Returns
    -------
    list[Problem]
        A note for each pair.
    """
    regions = [each for each in tissue.regions if each.faces in tissue.subsets and each.faces not in LABELS]
    found = []
    for i, first in enumerate(regions):
        for second in regions[i + 1 :]:
            top = max(first.depth_from, second.depth_from)
            bottom = min(first.depth_to, second.depth_to)
            both = np.intersect1d(tissue.subsets[first.faces], tissue.subsets[second.faces])
            both = both[skin[both]]
            if first.material == second.material or not top < bottom or not len(both):
                continue
            if _lies_within(tissue, second, first, skin):
                continue
            found.append(
                problem(
                    ProblemCode.REGIONS_OVERLAP,
                    f"{TISSUE}/{second.faces}",
                    first.faces,
                    place=Place(faces=tuple(both[:MOST_PLACES].tolist())),
                    other=second.faces,
                    faces=len(both),
                    top=top,
                    bottom=bottom,
                    material=second.material,
                )
            )
    return found


def _lies_within(tissue: Tissue, inner: Region, outer: Region, skin: NDArray[np.bool_]) -> bool:
    """Whether a region is a part, not all, of another."""
    inside, around = (np.unique(tissue.subsets[each.faces]) for each in (inner, outer))
    inside, around = inside[skin[inside]], around[skin[around]]
    depths = (inner.depth_from, inner.depth_to), (outer.depth_from, outer.depth_to)
    nested = depths[0][0] >= depths[1][0] and depths[0][1] <= depths[1][1] and bool(np.isin(inside, around).all())
    return nested and (depths[0] != depths[1] or len(inside) < len(around))
