"""A band of contracted scar in the skin of a procedure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from lappet.procedure import Landmark, Point, Procedure, Region
from lappet.tissue.presets import PRESETS
from lappet.tissue.presets.layers import FAT_FACES
from lappet.tissue.skin_sheet import SkinSheet
from lappet.tissue.uniaxial import prestretch_for

CONTRACTED = (10.0, 40.0)  # kPa in a scar across the skin lines: of the preset, and along the band; chosen
BAND = "scar_band"


def with_scar_band(procedure: Procedure, at: Point, direction: ArrayLike, length: float, width: float) -> Procedure:
    """Put a band of the preset scar into the skin, contracted along itself, across the skin lines.

    Parameters
    ----------
    procedure
        A procedure whose skin lies on fat, as that of every model of the body does.
    at
        Middle of the band in mm.
    direction
        Direction of the band, shape (3,); across the lines of the skin.
    length
        Length of the band in mm.
    width
        Its width in mm.

    Returns
    -------
    Procedure
        The procedure with the band and a landmark at either end of it.
    """
    tissue, way = procedure.tissue, np.asarray(direction, np.float64)
    skin = SkinSheet.of(tissue)
    middle, normal = (value[0] for value in skin.at(at))
    way = way - (way @ normal) * normal
    way /= np.linalg.norm(way)
    faces = tissue.subsets[FAT_FACES]  # the skin's
    starts = np.concatenate([[0], np.cumsum(tissue.face_vertex_counts)[:-1]])
    offset = tissue.points[tissue.face_vertex_indices[starts[faces][:, None] + np.arange(3)]].mean(axis=1) - middle
    across = np.abs(offset @ np.cross(normal, way))
    band = faces[(np.abs(offset @ way) < 0.5 * length) & (across < 0.5 * width)]
    (below,) = (region for region in tissue.regions if region.faces == FAT_FACES)
    unstretched = PRESETS["scar"].unstretched
    stretch = prestretch_for(unstretched, *CONTRACTED)
    scar = replace(unstretched, prestretch=(round(stretch[0], 4), round(stretch[1], 4)))
    region = Region(BAND, scar.name, depth_to=below.depth_from)
    tissue = replace(tissue, subsets={**tissue.subsets, BAND: band}, regions=(*tissue.regions, region))
    ends = [skin.below(middle + side * 0.5 * length * way, 0.0) for side in (1.0, -1.0)]
    marks = [Landmark(f"scar_end_{k}", (end,), f"scar end {k}") for k, end in enumerate(ends, start=1)]
    return replace(procedure, tissue=tissue, materials=(*procedure.materials, scar)).with_events(*marks)
