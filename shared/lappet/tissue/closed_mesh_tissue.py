"""Make tissue of a mesh that is closed, or nearly so: small holes are filled."""

from __future__ import annotations

import numpy as np

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.mesh_faults import SOLID, refuse_faults
from lappet.geometry.surface_check import directed_edges, place, signed_volume, unique_edges
from lappet.geometry.triangles import areas
from lappet.procedure import Tissue
from lappet.tissue.chosen_spacing import chosen_spacing
from lappet.tissue.crop_solid import crop_solid
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_repair import fill
from lappet.tissue.mesh_report import Note, repaired, taken
from lappet.tissue.surgical_field import Box, Sphere

_SMALL_HOLE = 0.15  # of the diagonal: holes shorter than this are filled
_OPEN_SHARE = 0.1  # of the area of closed parts: open parts that are no larger are left out


def closed_mesh_tissue(
    mesh: Mesh, spacing: float | None, name: str, region: Sphere | Box | None = None
) -> tuple[Tissue, list[Note]]:
    """Make tissue of a closed mesh, as it is, or of what of it lies inside a region.

    Parts that are open are left out where they are small beside those that are closed. Where a region cuts the tissue
    off it is held: the subset "fixed".

    Parameters
    ----------
    mesh
        The mesh, welded and oriented.
    spacing
        Lattice spacing in mm; None for a chosen one.
    name
        What messages call the mesh.
    region
        A region to crop the solid to, None for all of it.

    Returns
    -------
    tuple[Tissue, list[Note]]
        The tissue, and what was repaired and taken.

    Raises
    ------
    RefusedError
        If the mesh has a large hole, or is no closed solid; names the place.
    """
    mesh, notes = _without_open_parts(mesh)
    loops = border_loops(mesh.triangles)
    limit = _SMALL_HOLE * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    large = [loop for loop in loops if len(loop) > 4 and perimeter(mesh.points, loop) > limit]
    if large:
        value, border = f"{perimeter(mesh.points, large[0]):.4g}", mesh.points[large[0]]
        raise refused(ProblemCode.MESH_LARGE_HOLE, name, value, place=Place.at(*border[:100]), where=place(border[0]))
    if loops:
        mesh = fill(mesh, loops)
        notes.append(repaired("small holes", f"{len(loops)} filled"))
    subsets = {}
    if region is not None:
        refuse_faults(name, mesh.points, mesh.triangles)
        mesh, cut_off, cropped = crop_solid(mesh, region, name)
        notes += cropped
        subsets["fixed"] = np.flatnonzero(cut_off).astype(np.int32)
    refuse_faults(name, mesh.points, mesh.triangles, SOLID)
    volume = signed_volume(mesh.points, mesh.triangles)
    if spacing is None:
        spacing = chosen_spacing(volume)
    part = parts_of(mesh.triangles, len(mesh.points))
    cavities = sum(signed_volume(mesh.points, mesh.triangles[part == each]) < 0.0 for each in np.unique(part))
    hollow = f" with {cavities} cavit{'ies' if cavities > 1 else 'y'}" if cavities else ""
    notes += [
        taken("tissue", f"closed{hollow}, {len(mesh.triangles)} triangles, {volume:.4g} mm³"),
        taken("lattice spacing", f"{spacing:g} mm"),
    ]
    tissue = Tissue(
        points=mesh.points.astype(np.float32).astype(np.float64),
        face_vertex_counts=np.full(len(mesh.triangles), 3, np.int32),
        face_vertex_indices=mesh.triangles.reshape(-1).astype(np.int32),
        uv=None if mesh.uv is None else mesh.uv.reshape(-1, 2).astype(np.float32),
        subsets=subsets,
        spacing=spacing,
    )
    return tissue, notes


def _without_open_parts(mesh: Mesh) -> tuple[Mesh, list[Note]]:
    part = parts_of(mesh.triangles, len(mesh.points))
    size = np.bincount(part, areas(mesh.points[mesh.triangles]))
    closed = np.ones(len(size), bool)
    _, inverse, uses = unique_edges(directed_edges(mesh.triangles))
    closed[np.tile(part, 3)[uses[inverse] == 1]] = False
    if closed.all() or size[~closed].sum() > _OPEN_SHARE * size[closed].sum():
        return mesh, []
    value = f"{int((~closed).sum())} with {size[~closed].sum():.3g} mm², left out"
    return mesh.part(closed[part]), [repaired("open parts", value)]
