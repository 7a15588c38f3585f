"""Make tissue from a mesh file: `lappet new`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.flatten import flatten
from lappet.geometry.mesh_faults import EDGES, SOLID, refuse_faults
from lappet.geometry.surface_check import open_edges, place, signed_volume
from lappet.geometry.triangles import areas, directions
from lappet.procedure import Tissue
from lappet.tissue.crop_mesh import Level, box_levels, crop, near, refine_smoothly, sphere_level
from lappet.tissue.mesh_file import Mesh, read_mesh
from lappet.tissue.mesh_repair import fill, orient, weld
from lappet.tissue.outer_part import outer_part
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.thicken import Sheet, rim_rows, thicken

_SMALL_HOLE = 0.15  # of the rim, or of the diagonal of a mesh without one: holes shorter than this are filled
_CELLS = 40_000


def new_tissue(
    path: str | Path,
    thickness: float | None = None,
    sphere: tuple[Sequence[float], float] | None = None,
    box: tuple[Sequence[float], Sequence[float]] | None = None,
    spacing: float | None = None,
    units: str | None = None,
    resolution: float | None = None,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> tuple[Tissue, list[str]]:
    """Make tissue from a mesh file.

    A closed surface is taken as it is. An open one, or the region of one inside a sphere or a box, is thickened inwards
    into a closed sheet: its rim is the subset "fixed", its underside "bed", its UVs lay the skin out flat at 1 unit per
    100 mm.

    Parameters
    ----------
    path
        A mesh file.
    thickness
        Thickness of the sheet in mm; None for a closed surface.
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

    Returns
    -------
    tuple[Tissue, list[str]]
        The tissue, and a line for each thing that was found or repaired.

    Raises
    ------
    RefusedError
        If the arguments or the mesh make no tissue, or the surface cannot be repaired; names the place.
    """
    path = Path(path)
    name = path.name
    lengths = {"thickness": thickness, "spacing": spacing, "resolution": resolution}
    for what, value in {**lengths, "radius": sphere[1] if sphere else None}.items():
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, name, f"{value:g}", name=what)
    if sphere is not None and box is not None:
        raise refused(ProblemCode.REGION_TWICE, name)
    mesh, lines = read_mesh(path, units, limits)
    for repair in (weld, orient):
        mesh, done = repair(mesh)
        lines += [f"repaired: {line}" for line in done]
    closed = len(open_edges(mesh.triangles)) == 0
    holes = border_loops(mesh.triangles)
    lines.append("watertight" if closed else f"not watertight: {len(holes)} open borders")

    levels: list[Level] = []
    middle = np.zeros(3)
    if sphere is not None:
        levels, middle = sphere_level(*sphere), np.asarray(sphere[0], np.float64)
    elif box is not None:
        levels, middle = box_levels(*box), np.mean(np.asarray(box, np.float64), axis=0)
    if levels:
        if thickness is None:
            raise refused(ProblemCode.REGION_NEEDS_THICKNESS, name)
        mesh = _region(mesh, levels, middle, resolution or thickness, name, lines)
    if thickness is None:
        tissue = _closed_tissue(mesh, spacing, name, lines)
    else:
        if not levels and closed:
            raise refused(ProblemCode.SHEET_OF_CLOSED_SURFACE, name, f"{thickness:g}")
        tissue = _sheet_tissue(mesh, thickness, spacing, name, lines)
    return tissue, lines


def chosen_spacing(volume: float, thickness: float = 0.0) -> float:
    """Choose a lattice spacing: about 40 000 cells, and at least a quarter of a sheet's thickness.

    Parameters
    ----------
    volume
        Volume of the tissue in mm³.
    thickness
        Thickness of a sheet in mm, 0 for other tissue.

    Returns
    -------
    float
        Spacing in mm with two digits.
    """
    return float(f"{max(thickness / 4.0, (volume / _CELLS) ** (1.0 / 3.0)):.2g}")


def _region(
    mesh: Mesh, levels: list[Level], middle: NDArray[np.float64], edge: float, name: str, lines: list[str]
) -> Mesh:
    """One connected part of the surface inside the region, refined to edges of `edge` mm and cut cleanly."""
    low, high = place(mesh.points.min(axis=0)), place(mesh.points.max(axis=0))
    triangles = near(mesh.points, mesh.triangles, levels)
    if len(triangles) == 0:
        raise refused(ProblemCode.REGION_EMPTY, name, low=low, high=high)
    used, compact = np.unique(triangles, return_inverse=True)
    points, triangles, moved = refine_smoothly(mesh.points[used], compact.reshape(-1, 3), edge)
    if moved > 0.0:
        lines.append(f"refined to edges of about {edge:g} mm; new points lie up to {moved:.2g} mm off the old edges")
    points, triangles = crop(points, triangles, levels)
    if len(triangles) == 0:
        raise refused(ProblemCode.REGION_EMPTY, name, low=low, high=high)
    part, line = outer_part(mesh, Mesh(points, triangles), middle)
    lines += [] if line is None else [line]
    return part


def _largest_part(mesh: Mesh, lines: list[str]) -> Mesh:
    part = parts_of(mesh.triangles, len(mesh.points))
    sizes = np.bincount(part, areas(mesh.points[mesh.triangles]))
    if len(sizes) > 1:
        lines.append(f"kept the largest of {len(sizes)} separate parts, {sizes.max():.4g} of {sizes.sum():.4g} mm²")
    used, compact = np.unique(mesh.triangles[part == sizes.argmax()], return_inverse=True)
    return Mesh(mesh.points[used], compact.reshape(-1, 3))


def _closed_tissue(mesh: Mesh, spacing: float | None, name: str, lines: list[str]) -> Tissue:
    loops = border_loops(mesh.triangles)
    limit = _SMALL_HOLE * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    large = [loop for loop in loops if len(loop) > 4 and perimeter(mesh.points, loop) > limit]
    if large:
        value, border = f"{perimeter(mesh.points, large[0]):.4g}", mesh.points[large[0]]
        raise refused(ProblemCode.MESH_LARGE_HOLE, name, value, place=Place.at(*border[:100]), where=place(border[0]))
    if loops:
        mesh = fill(mesh, loops)
        lines.append(f"repaired: filled {len(loops)} small holes")
    refuse_faults(name, mesh.points, mesh.triangles, SOLID)
    volume = signed_volume(mesh.points, mesh.triangles)
    if spacing is None:
        spacing = chosen_spacing(volume)
    part = parts_of(mesh.triangles, len(mesh.points))
    cavities = sum(signed_volume(mesh.points, mesh.triangles[part == each]) < 0.0 for each in np.unique(part))
    hollow = f" with {cavities} cavit{'ies' if cavities > 1 else 'y'}" if cavities else ""
    lines.append(
        f"closed tissue{hollow}: {len(mesh.triangles)} triangles, {volume:.4g} mm³, lattice spacing {spacing:g} mm"
    )
    return Tissue(
        points=_single(mesh.points),
        face_vertex_counts=np.full(len(mesh.triangles), 3, np.int32),
        face_vertex_indices=mesh.triangles.reshape(-1).astype(np.int32),
        uv=None if mesh.uv is None else mesh.uv.reshape(-1, 2).astype(np.float32),
        spacing=spacing,
    )


def _sheet_tissue(mesh: Mesh, thickness: float, spacing: float | None, name: str, lines: list[str]) -> Tissue:
    mesh = _largest_part(mesh, lines)
    refuse_faults(name, mesh.points, mesh.triangles, EDGES)
    loops = sorted(border_loops(mesh.triangles), key=lambda loop: -perimeter(mesh.points, loop))
    if not loops:
        raise refused(ProblemCode.REGION_WHOLE_SURFACE, name)
    limit = _SMALL_HOLE * perimeter(mesh.points, loops[0])
    small = [loop for loop in loops[1:] if perimeter(mesh.points, loop) < limit]
    if small:
        mesh = fill(mesh, small)
        lines.append(f"repaired: filled {len(small)} small holes")
    if len(loops) - len(small) > 1:
        lines.append(f"{len(loops) - len(small)} borders: each becomes a fixed rim")

    uv = flatten(mesh.points, mesh.triangles)
    rows = rim_rows(mesh.points, mesh.triangles, thickness)
    sheet = thicken(mesh.points, mesh.triangles, thickness, rows, name)
    refuse_faults(name, sheet.points, sheet.triangles)
    volume = signed_volume(sheet.points, sheet.triangles)
    if spacing is None:
        spacing = chosen_spacing(volume, thickness)
    distortion = _stretches(mesh, uv)
    lines.append(
        f"thickened by {thickness:g} mm: {len(sheet.triangles)} triangles, {volume:.4g} mm³, "
        f"lattice spacing {spacing:g} mm"
    )
    lines.append(f"texture: lengths of the skin within {100 * distortion:.2g} % of the flat layout (95 of 100 edges)")
    return Tissue(
        points=_single(sheet.points),
        face_vertex_counts=np.full(len(sheet.triangles), 3, np.int32),
        face_vertex_indices=sheet.triangles.reshape(-1).astype(np.int32),
        uv=(UV_SCALE * _sheet_uv(sheet, mesh, uv, thickness)).reshape(-1, 2).astype(np.float32),
        subsets={
            "fixed": np.flatnonzero(sheet.rim).astype(np.int32),
            "bed": np.flatnonzero(sheet.underside).astype(np.int32),
        },
        spacing=spacing,
    )


def _sheet_uv(sheet: Sheet, mesh: Mesh, uv: NDArray[np.float64], thickness: float) -> NDArray[np.float64]:
    """Flat coordinates (m, 3, 2), mm: the underside below the skin, the rim continuing the skin outwards."""
    outward = np.zeros_like(uv)
    for loop in border_loops(mesh.triangles):
        along = uv[np.roll(loop, -1)] - uv[np.roll(loop, 1)]
        aside = np.stack([along[:, 1], -along[:, 0]], axis=1)
        outward[loop] = directions(aside)
    flat = uv[sheet.top]
    rim = flat + thickness * sheet.rim_level[:, None] * outward[sheet.top]
    return np.where(sheet.rim[:, None, None], rim[sheet.triangles], flat[sheet.triangles])


def _stretches(mesh: Mesh, uv: NDArray[np.float64]) -> float:
    """The relative change of edge length by flattening that 95 of 100 edges stay below."""
    following = np.roll(mesh.triangles, -1, axis=1)
    true = np.linalg.norm(mesh.points[mesh.triangles] - mesh.points[following], axis=2)
    flat = np.linalg.norm(uv[mesh.triangles] - uv[following], axis=2)
    return float(np.quantile(np.abs(flat / np.maximum(true, 1e-300) - 1.0), 0.95))


def _single(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points rounded to what USD's float points hold."""
    return points.astype(np.float32).astype(np.float64)
