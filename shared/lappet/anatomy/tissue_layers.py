"""Which layer of the tissue lies where: the stacks of materials below the skin, and the depth of what a cut shows.

A *column* is the stack of layers below a part of the skin in which the same regions lie. A place belongs to the column
below the skin that is nearest to it, and in it to the layer at its distance from the skin, as the daemon has it
(`solverd/src/force/materials/cell_shares.cpp`); of the regions that hold a place the last one counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_kind import KIND_COLORS, KINDS, tissue_kind
from lappet.cutting.epoch import no_entries
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Material, Tissue
from lappet.tissue.surface import tissue_surface


@dataclass(frozen=True, eq=False)
class TissueLayers:
    """The layers of all columns, one after another and downwards in each.

    Parameters
    ----------
    column
        The column of each layer, shape (k,), int32, ascending.
    depth_from
        Where it begins in mm below the skin, shape (k,), float64; 0 for the first of a column.
    kind
        What it is, as an index of `KINDS`, shape (k,), int32.
    materials
        Name of its material.
    """

    column: NDArray[np.int32] = field(default_factory=lambda: no_entries((1,), np.int32))
    depth_from: NDArray[np.float64] = field(default_factory=lambda: no_entries((1,), np.float64))
    kind: NDArray[np.int32] = field(default_factory=lambda: no_entries((1,), np.int32))
    materials: tuple[str, ...] = ("",)

    @property
    def columns(self) -> int:
        """Number of columns."""
        return int(self.column[-1]) + 1

    @property
    def deepest_border(self) -> float:
        """Depth of the deepest border between two layers in mm, 0 where there is none."""
        return float(self.depth_from.max())

    def layers_at(self, column: NDArray[np.integer], depth: NDArray[np.floating]) -> NDArray[np.int64]:
        """Find the layers of places.

        Parameters
        ----------
        column
            The column of each place, shape (n,).
        depth
            Its depth below the skin in mm, shape (n,).

        Returns
        -------
        NDArray[np.int64]
            Indices of the layers, shape (n,).
        """
        found = np.zeros(len(column), np.int64)
        for layer, (own, top) in enumerate(zip(self.column, self.depth_from, strict=True)):
            found[(column == own) & (depth >= top)] = layer
        return found

    def colors_at(self, column: NDArray[np.integer], depth: NDArray[np.floating]) -> NDArray[np.float32]:
        """Find the colors of places.

        Parameters
        ----------
        column
            The column of each place, shape (n,).
        depth
            Its depth below the skin in mm, shape (n,).

        Returns
        -------
        NDArray[np.float32]
            Linear RGB, shape (n, 3).
        """
        palette = np.array([KIND_COLORS[name] for name in KINDS], np.float32)
        return np.asarray(palette[self.kind[self.layers_at(column, depth)]])


@dataclass(frozen=True, eq=False)
class SurfaceLayers:
    """Where the faces of a cut surface lie among the layers.

    Parameters
    ----------
    depth
        Depth of each vertex below the skin before any cut in mm, shape (n,), float32; 0 on the skin, and on the
        underside of tissue of one layer, where nobody asks for it.
    column
        Column of each triangle, shape (m,), int32.
    """

    depth: NDArray[np.float32]
    column: NDArray[np.int32]


class LayerSearch:
    """A search for the layers of a tissue; `layer_search` keeps it.

    Parameters
    ----------
    tissue
        The tissue; a region whose face subset it has not is left out.
    materials
        The procedure's materials.

    Raises
    ------
    RefusedError
        If the tissue makes no closed surface.
    """

    def __init__(self, tissue: Tissue, materials: Sequence[Material]) -> None:
        uncut = tissue_surface(tissue)
        skin = np.flatnonzero(uncut.origin == FaceOrigin.SKIN)
        regions = [region for region in tissue.regions if region.faces in uncut.grips]
        members = np.array([uncut.grips[region.faces][skin] for region in regions], bool).reshape(
            len(regions), len(skin)
        )
        stacks, of_triangle = np.unique(members.T, axis=0, return_inverse=True)
        self._column = of_triangle.reshape(-1).astype(np.int32)
        self._skin = ClosestPoint(uncut.points, uncut.triangles[skin]) if len(skin) else None
        known = {material.name: material for material in materials}
        base = tissue.material
        kinds = {name: tissue_kind(each, "skin" if name == base else "other") for name, each in known.items()}
        rows: list[tuple[int, float, int, str]] = []
        for column, stack in enumerate(stacks if len(stacks) else np.zeros((1, 0), bool)):
            own = [region for region, held in zip(regions, stack, strict=True) if held]
            borders = {0.0, *(region.depth_from for region in own), *(region.depth_to for region in own)}
            before = None
            for top in sorted(border for border in borders if 0.0 <= border < math.inf):
                inside = [region.material for region in own if region.depth_from <= top < region.depth_to]
                name = inside[-1] if inside else base
                if name != before:
                    rows.append((column, top, KINDS.index(kinds.get(name, "other")), name))
                before = name
        self.layers = TissueLayers(
            np.array([row[0] for row in rows], np.int32),
            np.array([row[1] for row in rows], np.float64),
            np.array([row[2] for row in rows], np.int32),
            tuple(row[3] for row in rows),
        )

    def of(self, surface: Surface) -> SurfaceLayers:
        """Find where the faces of a cut surface of the tissue lie.

        Parameters
        ----------
        surface
            The surface at rest.

        Returns
        -------
        SurfaceLayers
            Depths and columns.
        """
        depth = np.zeros(len(surface.points), np.float32)
        column = np.zeros(len(surface.triangles), np.int32)
        one = self.layers.columns == 1 and self.layers.deepest_border == 0.0
        shown = (FaceOrigin.WOUND_WALL, FaceOrigin.RIM, *(() if one else (FaceOrigin.UNDERSIDE,)))
        faces = np.flatnonzero(np.isin(surface.origin, shown))
        if self._skin is None or not len(faces):
            return SurfaceLayers(depth, column)
        inner = np.setdiff1d(surface.triangles[faces], surface.triangles[surface.origin == FaceOrigin.SKIN])
        depth[inner] = self._skin.query(surface.points[inner])[2]
        if self.layers.columns > 1:
            middles = surface.points[surface.triangles].mean(axis=1)
            column[:] = self._column[self._skin.query(middles)[0]]
        return SurfaceLayers(depth, column)


@lru_cache(maxsize=4)
def layer_search(tissue: Tissue, materials: tuple[Material, ...]) -> LayerSearch:
    """Return the search for the layers of a tissue; the last few are kept.

    Parameters
    ----------
    tissue
        The tissue.
    materials
        The procedure's materials.

    Returns
    -------
    LayerSearch
        The search.

    Raises
    ------
    RefusedError
        If the tissue makes no closed surface.
    """
    return LayerSearch(tissue, materials)
