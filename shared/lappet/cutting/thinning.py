"""Thinning: takes the deep tissue of an area away, so that a stated thickness is left below its skin.

The skin inside the area's outline is offset along its normals: from the thickness that is to be left down to past the
underside. The solid between is subtracted from the tissue. Its upper side is the new underside; it hangs on no bed,
as tissue must be raised to be thinned, but comes to rest on the ground as undermined tissue does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.area_parts import LINE_KERF, AreaParts
from lappet.cutting.epoch import Removed
from lappet.cutting.incision import tidy
from lappet.cutting.ribbon import skin_ribbons
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.solid import Label, LabeledSolid, solid_surface
from lappet.geometry.surface_check import open_edges
from lappet.geometry.triangles import areas
from lappet.procedure import Thin
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.rest_skin import RestSkin

TIDIED = 0.02  # of the lattice spacing: shorter edges and flatter triangles are removed
_PAST = 0.5  # of the lattice spacing: how far below the underside the solid reaches
_UNDER = Label(FaceOrigin.UNDERSIDE)


def thin(
    tissue: LabeledSolid, rest: LabeledSolid, skin: RestSkin, event: Thin, spacing: float, timeline: str
) -> tuple[LabeledSolid, Removed]:
    """Take the deep tissue of an area away.

    Parameters
    ----------
    tissue
        The tissue as it is cut now.
    rest
        The uncut tissue.
    skin
        The uncut skin.
    event
        The event with the outline and the thickness to be left.
    spacing
        Lattice spacing in mm.
    timeline
        Path of the prims' parent, for messages.

    Returns
    -------
    tuple[LabeledSolid, Removed]
        The tissue that is left, and what was taken away.

    Raises
    ------
    RefusedError
        If the outline cannot be followed or surrounds no tissue or does not part it, or nothing is
        thicker than is to be left.
    """
    prim = f"{timeline}/{event.name}"
    if not (np.isfinite(event.thickness) and event.thickness > 0.0):
        raise refused(ProblemCode.THIN_THICKNESS, prim, f"{event.thickness:g}")
    kerf = LINE_KERF * min(spacing, 1.0)
    ribbons = skin_ribbons(skin, event.points, prim=prim, basis=event.basis, closed=True, kerf=kerf, spacing=spacing)
    parts = AreaParts(rest, ribbons, kerf, spacing)
    if not parts.is_parted:
        raise refused(ProblemCode.AREA_NOT_PARTED, prim, place=Place.at(*event.points))
    if not parts.within:
        raise refused(ProblemCode.THIN_NO_AREA, prim)
    label = manifold3d.Manifold.reserve_ids(1)
    solids, thickest = [], 0.0
    for part in parts.within:
        sheet = _Sheet.of(part, skin)
        if sheet is None:
            continue
        thickest = max(thickest, float(sheet.thickness.max(initial=0.0)))
        solids.append(sheet.below(event.thickness, _PAST * spacing, label))
    deep = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add) if solids else manifold3d.Manifold()
    removed = tissue.solid ^ deep
    if thickest <= event.thickness or removed.is_empty() or removed.volume() <= 0.0:
        at = Place.at(*event.points)
        raise refused(ProblemCode.THIN_NOTHING, prim, f"{event.thickness:g}", place=at, thickest=thickest)
    left = tidy(tissue.with_solid(tissue.solid - deep, {label: _UNDER}), spacing, TIDIED * spacing)
    surface = left.surface()
    inside = surface.origin == FaceOrigin.SKIN
    inside[inside] = parts.contain(surface.points[surface.triangles[inside]].mean(axis=1))
    area = float(areas(surface.points[surface.triangles[inside]]).sum())
    if event.dressing:
        left = LabeledSolid.from_surface(replace(surface, grips={**surface.grips, event.pressed: inside}))
    return left, Removed(event.name, area, float(removed.volume()), *solid_surface(removed))


@dataclass(frozen=True, eq=False)
class _Sheet:
    """The skin of an area, with its normals and the thickness below."""

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    normals: NDArray[np.float64]
    thickness: NDArray[np.float64]

    @classmethod
    def of(cls, part: Surface, skin: RestSkin) -> _Sheet | None:
        """The skin of a part of the tissue; None for a part without any."""
        used, triangles = np.unique(part.triangles[part.origin == FaceOrigin.SKIN], return_inverse=True)
        if not len(used):
            return None
        points = part.points[used]
        normals = skin.locate(points).normals
        return cls(points, triangles.reshape(-1, 3).astype(np.int64), normals, skin.thickness(points, normals))

    def below(self, depth: float, past: float, label: int) -> manifold3d.Manifold:
        """The solid from a depth below the skin to past the underside, all in mm; its faces carry the run id."""
        count = len(self.points)
        # At the tissue's border rays may miss the underside: there it is taken as deep as anywhere in the area.
        bottom = np.where(self.thickness > 0.0, self.thickness, self.thickness.max(initial=0.0))
        bottom = np.maximum(bottom, depth) + past
        rows = np.concatenate([self.points - depth * self.normals, self.points - bottom[:, None] * self.normals])
        edges = open_edges(self.triangles)
        walls = np.concatenate(
            [
                np.stack([edges[:, 1], edges[:, 0], edges[:, 0] + count], axis=1),
                np.stack([edges[:, 1], edges[:, 0] + count, edges[:, 1] + count], axis=1),
            ]
        )
        triangles = np.concatenate([self.triangles, self.triangles[:, ::-1] + count, walls])
        properties = np.concatenate([rows, UV_SCALE * self._flat(rows)], axis=1)
        mesh = manifold3d.Mesh64(
            vert_properties=np.ascontiguousarray(properties),
            tri_verts=triangles.astype(np.uint64),
            run_index=np.array([0, 3 * len(triangles)], np.uint64),
            run_original_id=np.array([label], np.uint32),
            face_id=np.arange(len(triangles), dtype=np.uint64),
        )
        return manifold3d.Manifold(mesh)

    def _flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points in the plane across the mean normal, mm, shape (k, 2)."""
        axis = self.normals.mean(axis=0)
        first = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
        first /= max(float(np.linalg.norm(first)), 1e-300)
        second = np.cross(axis / max(float(np.linalg.norm(axis)), 1e-300), first)
        return points @ np.stack([first, second], axis=1)
