"""Make tissue from a mesh: `lappet new`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.surface_check import open_edges
from lappet.procedure import Tissue
from lappet.tissue.closed_mesh_tissue import closed_mesh_tissue
from lappet.tissue.inner_side import Surroundings
from lappet.tissue.mesh_file import Mesh, read_mesh
from lappet.tissue.mesh_repair import orient, separate, weld
from lappet.tissue.mesh_report import MeshReport, Note, found
from lappet.tissue.open_mesh_tissue import Thickness, open_mesh_tissue
from lappet.tissue.surgical_field import Box, Disc, Outline, Region, Sphere, surgical_field

Texture = Literal["grid", "mesh"]
_EDGE = 2.0  # mm: the resolution of a sheet whose thickness is no number
_MOST_LENGTHS = 5  # of borders, that the report names


def new_tissue(
    path: str | Path,
    thickness: float | None = None,
    sphere: tuple[Sequence[float], float] | None = None,
    box: tuple[Sequence[float], Sequence[float]] | None = None,
    spacing: float | None = None,
    units: str | None = None,
    resolution: float | None = None,
    limits: ReadLimits = DEFAULT_LIMITS,
    at: tuple[Sequence[float], float] | None = None,
    outline: Outline | None = None,
    texture: Texture = "grid",
) -> tuple[Tissue, MeshReport]:
    """Make tissue from a mesh file.

    A closed surface is taken as it is. An open one, or a region of one, is thickened inwards into a closed sheet: its
    rim is the subset "fixed", its underside "bed", its UVs lay the skin out flat at 1 unit per 100 mm.

    Parameters
    ----------
    path
        A mesh file.
    thickness
        Thickness of the sheet in mm, less where there is no room for it. None for a closed surface, and for the skin
        around a point or inside an outline down to the surface's own inner side.
    sphere
        Center and radius in mm of a region to take.
    box
        Lowest and highest corner in mm of a region to take.
    spacing
        Lattice spacing in mm; None for a quarter of the thickness, and not so fine that there are more than about 40
        000 cells.
    units
        Units of the file, see `read_mesh`.
    resolution
        Length in mm down to which the edges of a region are divided; the thickness when None.
    limits
        What reading the file may take.
    at
        A point of the skin and a radius along the skin, both in mm: a region to take.
    outline
        A closed curve on the skin: a region to take.
    texture
        Of a sheet: "grid" lays the skin out flat, "mesh" keeps the mesh's own texture coordinates.

    Returns
    -------
    tuple[Tissue, MeshReport]
        The tissue, and what was found, repaired and taken.

    Raises
    ------
    RefusedError
        If the arguments or the mesh make no tissue, or the surface cannot be repaired; names the place.
    """
    path = Path(path)
    regions: list[Region] = []
    regions += [] if sphere is None else [Sphere(*sphere)]
    regions += [] if box is None else [Box(*box)]
    regions += [] if at is None else [Disc(*at)]
    regions += [] if outline is None else [outline]
    if len(regions) > 1:
        raise refused(ProblemCode.REGION_TWICE, path.name)
    region = regions[0] if regions else None
    _refuse_lengths(path.name, thickness, spacing, resolution, region)
    mesh, report = read_mesh(path, units, limits)
    return tissue_of_mesh(mesh, thickness, region, spacing, resolution, path.name, report, texture)


def tissue_of_mesh(
    mesh: Mesh,
    thickness: Thickness | None = None,
    region: Region | None = None,
    spacing: float | None = None,
    resolution: float | None = None,
    name: str = "mesh",
    report: MeshReport | None = None,
    texture: Texture = "grid",
) -> tuple[Tissue, MeshReport]:
    """Make tissue from a mesh, as `new_tissue` does from a file.

    Parameters
    ----------
    mesh
        The mesh.
    thickness
        Thickness of the sheet, also as a function of the place on the skin; None as of `new_tissue`.
    region
        The part of the surface to take, None for all of it.
    spacing
        Lattice spacing in mm; None for a chosen one.
    resolution
        Length in mm down to which the edges of a region are divided; None for the thickness, or where that is no number
        for 2 mm.
    name
        What messages call the mesh.
    report
        What was noted before.
    texture
        As of `new_tissue`.

    Returns
    -------
    tuple[Tissue, MeshReport]
        The tissue, and what was found, repaired and taken.

    Raises
    ------
    RefusedError
        As `new_tissue` does.

    Examples
    --------
    >>> import numpy as np
    >>> from lappet.tissue import Disc, tissue_of_mesh
    >>> from lappet.tissue.mesh_file import Mesh
    >>> x, y = (each.ravel() for each in np.meshgrid(np.arange(-20.0, 21.0), np.arange(-20.0, 21.0)))
    >>> i = (41 * np.arange(40)[:, None] + np.arange(40)).ravel()
    >>> faces = np.concatenate([np.stack([i, i + 1, i + 42], 1), np.stack([i, i + 42, i + 41], 1)])
    >>> skin = Mesh(np.stack([x, y, 0.01 * (x**2 + y**2)], 1), faces)
    >>> tissue, report = tissue_of_mesh(skin, thickness=3.0, region=Disc((0.0, 0.0, 0.0), 12.0))
    >>> report["thickness"]
    '3 mm'
    """
    _refuse_lengths(name, None if callable(thickness) else thickness, spacing, resolution, region)
    keep = texture == "mesh"
    if keep and mesh.uv is None:
        raise refused(ProblemCode.MESH_NO_TEXTURE, name)
    report = report or MeshReport()
    for repair in (weld, separate, orient):
        mesh, notes = repair(mesh)
        report = report.with_notes(notes)
    closed = len(open_edges(mesh.triangles)) == 0
    report = report.with_notes(_shape(mesh, closed))
    if region is None:
        if thickness is None:
            tissue, notes = closed_mesh_tissue(mesh, spacing, name)
        elif closed:
            raise refused(ProblemCode.SHEET_OF_CLOSED_SURFACE, name, _text(thickness))
        else:
            tissue, notes = open_mesh_tissue(mesh, thickness, spacing, name, keep_texture=keep)
        return tissue, report.with_notes(notes)
    if thickness is None:
        if isinstance(region, (Sphere, Box)) and closed:
            tissue, notes = closed_mesh_tissue(mesh, spacing, name, region)
            return tissue, report.with_notes(notes)
        if isinstance(region, (Sphere, Box)):
            raise refused(ProblemCode.REGION_NEEDS_THICKNESS, name)
    edge = resolution or (_EDGE if thickness is None or callable(thickness) else thickness)
    field, notes = surgical_field(mesh, region, edge, name)
    around = Surroundings.of(mesh.points, mesh.triangles, field.points)
    tissue, more = open_mesh_tissue(field, thickness, spacing, name, around, keep)
    return tissue, report.with_notes([*notes, *more])


def _refuse_lengths(
    name: str, thickness: float | None, spacing: float | None, resolution: float | None, region: Region | None
) -> None:
    radius = region.radius if isinstance(region, (Sphere, Disc)) else None
    lengths = {"thickness": thickness, "spacing": spacing, "resolution": resolution, "radius": radius}
    for what, value in lengths.items():
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, name, f"{value:g}", name=what)


def _shape(mesh: Mesh, closed: bool) -> list[Note]:
    """Whether the surface is closed, its borders and its parts."""
    loops = border_loops(mesh.triangles)
    lengths = sorted((perimeter(mesh.points, loop) for loop in loops), reverse=True)
    longest = ", ".join(f"{each:.3g}" for each in lengths[:_MOST_LENGTHS]) + (
        ", …" if len(loops) > _MOST_LENGTHS else ""
    )
    count = f"{len(loops)} border" + "s" * (len(loops) != 1)
    notes = [found("surface", "watertight" if closed else f"open: {count} of {longest} mm")]
    part = parts_of(mesh.triangles, len(mesh.points))
    parts = int(part.max()) + 1
    if parts > 1:
        open_parts = len(np.unique(part[np.isin(mesh.triangles, np.concatenate(loops)).any(axis=1)])) if loops else 0
        notes.append(found("separate parts", f"{parts}, of which {parts - open_parts} are closed"))
    return notes


def _text(thickness: Thickness) -> str:
    return "some" if callable(thickness) else f"{thickness:g}"
