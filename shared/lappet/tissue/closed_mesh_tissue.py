"""Make tissue of a mesh that is closed, or nearly so: small holes are filled."""

from __future__ import annotations

import numpy as np

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.mesh_faults import SOLID, refuse_faults
from lappet.geometry.surface_check import place, signed_volume
from lappet.procedure import Tissue
from lappet.tissue.chosen_spacing import chosen_spacing
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_repair import fill
from lappet.tissue.mesh_report import Note, repaired, taken

_SMALL_HOLE = 0.15  # of the diagonal: holes shorter than this are filled


def closed_mesh_tissue(mesh: Mesh, spacing: float | None, name: str) -> tuple[Tissue, list[Note]]:
    """Make tissue of a closed mesh, as it is.

    Parameters
    ----------
    mesh
        The mesh, welded and oriented.
    spacing
        Lattice spacing in mm; None for a chosen one.
    name
        What messages call the mesh.

    Returns
    -------
    tuple[Tissue, list[Note]]
        The tissue, and what was repaired and taken.

    Raises
    ------
    RefusedError
        If the mesh has a large hole, or is no closed solid; names the place.
    """
    notes = []
    loops = border_loops(mesh.triangles)
    limit = _SMALL_HOLE * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    large = [loop for loop in loops if len(loop) > 4 and perimeter(mesh.points, loop) > limit]
    if large:
        value, border = f"{perimeter(mesh.points, large[0]):.4g}", mesh.points[large[0]]
        raise refused(ProblemCode.MESH_LARGE_HOLE, name, value, place=Place.at(*border[:100]), where=place(border[0]))
    if loops:
        mesh = fill(mesh, loops)
        notes.append(repaired("small holes", f"{len(loops)} filled"))
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
        spacing=spacing,
    )
    return tissue, notes
