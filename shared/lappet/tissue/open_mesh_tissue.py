"""Make tissue of an open surface: a sheet whose rim is held and whose underside lies on a bed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.flatten import flatten
from lappet.geometry.labeled_surface import LINING
from lappet.geometry.mesh_faults import EDGES, refuse_faults
from lappet.geometry.normals import vertex_normals
from lappet.geometry.surface_check import directed_edges, place, signed_volume, unique_edges
from lappet.geometry.triangles import areas, directions
from lappet.procedure import Tissue
from lappet.tissue.chosen_spacing import chosen_spacing
from lappet.tissue.inner_side import Surroundings, inner_side
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_repair import fill
from lappet.tissue.mesh_report import Note, found, repaired, taken
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.thicken import Sheet, rim_rows, thicken

Thickness = float | Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""In mm: one number, or a function from points of the skin in mm, shape (n, 3), to the thickness below each, (n,)."""

_SMALL_HOLE = 0.15  # of the rim: holes shorter than this are filled
_DEEPEST = 30.0  # mm below the skin in which an inner side is looked for
_NARROW = 0.75  # of the wanted thickness: places that are thinner are told


def open_mesh_tissue(
    mesh: Mesh,
    thickness: Thickness | None,
    spacing: float | None,
    name: str,
    around: Surroundings | None = None,
    keep_texture: bool = False,
) -> tuple[Tissue, list[Note]]:
    """Make a sheet of the largest part of an open surface.

    Its rim is the subset "fixed". Its underside is "bed", but where it lies on the free inner side of the surface that
    it was taken from, such as the lining of a nostril: there it is "lining". Its UVs lay the skin out flat at 1 unit
    per 100 mm, or are those of the mesh.

    Parameters
    ----------
    mesh
        The surface, welded and oriented.
    thickness
        Thickness of the sheet; it is less where there is no room for it. None for a sheet down to the inner side of the
        surface that it was taken from.
    spacing
        Lattice spacing in mm; None for a chosen one.
    name
        What messages call the surface.
    around
        The surface that this one was taken from, None where it is whole.
    keep_texture
        Whether the mesh's own texture coordinates are kept, which it has then.

    Returns
    -------
    tuple[Tissue, list[Note]]
        The tissue, and what was found, repaired and taken.

    Raises
    ------
    RefusedError
        If the surface is closed, not manifold or not oriented alike, or has no room for a sheet, or no inner side where
        that is the thickness; names the place.
    """
    mesh, notes = _largest_part(mesh)
    refuse_faults(name, mesh.points, mesh.triangles, EDGES)
    mesh, more = _small_holes_filled(mesh, name)
    wanted = _wanted(mesh, thickness, name, around)
    thick = float(np.median(wanted))
    sheet = thicken(mesh.points, mesh.triangles, wanted, rim_rows(mesh.points, mesh.triangles, thick), name, around)
    refuse_faults(name, sheet.points, sheet.triangles)
    texture, kept = _mesh_texture(sheet, mesh, mesh.uv) if keep_texture and mesh.uv is not None else _grid(sheet, mesh)
    volume = signed_volume(sheet.points, sheet.triangles)
    if spacing is None:
        spacing = chosen_spacing(volume, thick)
    subsets = {"fixed": sheet.rim, "bed": sheet.underside & ~sheet.lining}
    if sheet.lining.any():
        subsets[LINING] = sheet.lining
    tissue = Tissue(
        points=sheet.points.astype(np.float32).astype(np.float64),
        face_vertex_counts=np.full(len(sheet.triangles), 3, np.int32),
        face_vertex_indices=sheet.triangles.reshape(-1).astype(np.int32),
        uv=texture.reshape(-1, 2).astype(np.float32),
        subsets={subset: np.flatnonzero(faces).astype(np.int32) for subset, faces in subsets.items()},
        spacing=spacing,
    )
    notes += [
        *more,
        taken("tissue", f"sheet of {len(sheet.triangles)} triangles, {volume:.4g} mm³"),
        *_thickness_notes(mesh, sheet, wanted),
        taken("lattice spacing", f"{spacing:g} mm"),
        taken("texture", kept),
    ]
    return tissue, notes


def _wanted(mesh: Mesh, thickness: Thickness | None, name: str, around: Surroundings | None) -> NDArray[np.float64]:
    """The thickness that is wanted below each point of the skin in mm."""
    if callable(thickness):
        return thickness(mesh.points)
    if thickness is not None:
        return np.full(len(mesh.points), float(thickness))
    if around is None:
        raise refused(ProblemCode.REGION_NEEDS_THICKNESS, name)
    inwards = -vertex_normals(mesh.points, mesh.triangles)
    distance = inner_side(mesh.points, inwards, np.full(len(mesh.points), _DEEPEST), around).distance
    missing = np.flatnonzero(~np.isfinite(distance))
    if len(missing):
        where = mesh.points[missing[0]]
        fields = {"where": place(where), "share": f"{len(missing) / len(distance):.0%}"}
        raise refused(ProblemCode.REGION_NO_INNER_SIDE, name, f"{_DEEPEST:g}", place=Place.at(where), **fields)
    return distance


def _largest_part(mesh: Mesh) -> tuple[Mesh, list[Note]]:
    part = parts_of(mesh.triangles, len(mesh.points))
    sizes = np.bincount(part, areas(mesh.points[mesh.triangles]))
    if len(sizes) == 1:
        return mesh, []
    value = f"the largest of {len(sizes)}, {sizes.max():.4g} of {sizes.sum():.4g} mm²"
    return mesh.part(part == sizes.argmax()), [taken("part", value)]


def _small_holes_filled(mesh: Mesh, name: str) -> tuple[Mesh, list[Note]]:
    loops = sorted(border_loops(mesh.triangles), key=lambda loop: -perimeter(mesh.points, loop))
    if not loops:
        raise refused(ProblemCode.REGION_WHOLE_SURFACE, name)
    notes = []
    limit = _SMALL_HOLE * perimeter(mesh.points, loops[0])
    small = [loop for loop in loops[1:] if perimeter(mesh.points, loop) < limit]
    if small:
        mesh = fill(mesh, small)
        notes.append(repaired("small holes", f"{len(small)} filled"))
    if len(loops) - len(small) > 1:
        notes.append(found("borders", f"{len(loops) - len(small)}, each becomes a fixed rim"))
    return mesh, notes


def _thickness_notes(mesh: Mesh, sheet: Sheet, wanted: NDArray[np.float64]) -> list[Note]:
    low, high = float(sheet.depth.min()), float(sheet.depth.max())
    value = f"{high:.4g} mm" if high - low < 0.005 * high else f"{low:.2g} to {high:.4g} mm"
    thin = sheet.depth < _NARROW * wanted
    if thin.any():
        less = float(areas(mesh.points[mesh.triangles])[thin[mesh.triangles].any(axis=1)].sum())
        where = place(mesh.points[int((sheet.depth / wanted).argmin())].round(2))
        value += f", less than {_NARROW:.0%} of what was wanted on {less:.3g} mm², the least at {where}"
    notes = [taken("thickness", value)]
    if sheet.lining.any():
        lined = float(areas(sheet.points[sheet.triangles[sheet.lining]]).sum())
        notes.append(taken("lining", f"{lined:.3g} mm² of the underside are the surface's own inner side, and free"))
    return notes


def _grid(sheet: Sheet, mesh: Mesh) -> tuple[NDArray[np.float64], str]:
    """Texture coordinates (m, 3, 2) that lay the skin out flat, and what is to be said of them."""
    uv = flatten(mesh.points, mesh.triangles)
    return UV_SCALE * sheet_uv(sheet, mesh, uv), _lengths_kept(mesh, uv)


def _mesh_texture(sheet: Sheet, mesh: Mesh, uv: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
    """The mesh's texture coordinates (m, 3, 2): the underside has the skin's, the rim those of the border above it."""
    triangles = mesh.triangles
    edges = directed_edges(triangles)
    _, inverse, uses = unique_edges(edges)
    border = np.flatnonzero(uses[inverse] == 1)
    size = len(mesh.points)
    key = edges[border, 0] * size + edges[border, 1]
    border = border[np.argsort(key)]
    key = np.sort(key)
    face, corner = border % len(triangles), border // len(triangles)
    ends = np.stack([uv[face, corner], uv[face, (corner + 1) % 3]], axis=1)
    tops = sheet.top[sheet.triangles[sheet.rim]]
    low, high = tops.min(axis=1), tops.max(axis=1)
    ahead = np.minimum(np.searchsorted(key, low * size + high), len(key) - 1)
    back = np.minimum(np.searchsorted(key, high * size + low), len(key) - 1)
    row = np.where(key[ahead] == low * size + high, ahead, back)
    first = key[row] // size
    rim = np.where((tops == first[:, None])[:, :, None], ends[row, 0][:, None], ends[row, 1][:, None])
    return np.concatenate([uv, uv[:, ::-1], rim]), "the mesh's own texture coordinates"


def sheet_uv(sheet: Sheet, mesh: Mesh, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lay out a sheet: the underside below the skin, the rim continuing the skin outwards.

    Parameters
    ----------
    sheet
        The sheet.
    mesh
        The skin that it was made from.
    uv
        Flat coordinates of the skin's vertices in mm, shape (n, 2).

    Returns
    -------
    NDArray[np.float64]
        Flat coordinates of the corners of the sheet's triangles in mm, shape (m, 3, 2).
    """
    outward = np.zeros_like(uv)
    for loop in border_loops(mesh.triangles):
        along = uv[np.roll(loop, -1)] - uv[np.roll(loop, 1)]
        aside = np.stack([along[:, 1], -along[:, 0]], axis=1)
        outward[loop] = directions(aside)
    flat = uv[sheet.top]
    rim = flat + (sheet.depth[sheet.top] * sheet.rim_level)[:, None] * outward[sheet.top]
    return np.where(sheet.rim[:, None, None], rim[sheet.triangles], flat[sheet.triangles])


def _lengths_kept(mesh: Mesh, uv: NDArray[np.float64]) -> str:
    """How much edges are longer or shorter in the flat layout."""
    following = np.roll(mesh.triangles, -1, axis=1)
    true = np.linalg.norm(mesh.points[mesh.triangles] - mesh.points[following], axis=2)
    flat = np.linalg.norm(uv[mesh.triangles] - uv[following], axis=2)
    half, most = np.quantile(np.abs(flat / np.maximum(true, 1e-300) - 1.0), (0.5, 0.95))
    return f"a grid whose lengths are the skin's within {100 * half:.2g} % for half of it, {100 * most:.2g} % for 95 %"
