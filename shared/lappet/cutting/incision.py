"""Incisions: ribbons on the skin thickened to solids and subtracted from the tissue in one Boolean."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.ribbon import Ribbon, skin_ribbons
from lappet.geometry.flat_triangles import turn_flat_triangles
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.short_edges import collapse_short_edges
from lappet.geometry.solid import Label, LabeledSolid
from lappet.geometry.without_piercings import Change, Step, unchanged, without_piercings
from lappet.procedure import Incision
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.rest_skin import RestSkin

__all__ = ["cut", "cutter", "fragments", "incise", "tidy"]

_WALL = Label(FaceOrigin.WOUND_WALL)
# Share of the kerf by which a quad of a wall is out of its plane from where on both walls are divided by the same
# diagonal (chosen): by different ones they would pass through each other. Flat quads have no diagonal that shows.
_TWISTED = 0.01


def cutter(ribbon: Ribbon, kerf: float, above: float, ids: tuple[int, int, int]) -> manifold3d.Manifold:
    """Make the solid that a ribbon sweeps: from above the skin down to its depth.

    UVs are (arc length, depth), 1 unit per 100 mm, on the left wall; the right wall's are moved on by the kerf, so that
    the floor has an area too.

    Parameters
    ----------
    ribbon
        The ribbon.
    kerf
        Width of the cut in mm.
    above
        Height over the skin at which the solid ends in mm.
    ids
        Run ids of its left wall, its right wall and the rest (roof, floor, ends).

    Returns
    -------
    manifold3d.Manifold
        The solid.
    """
    position = ribbon.sections(kerf, above)
    along, depth = ribbon.along, ribbon.depth
    if ribbon.closed:
        position = np.concatenate([position, position[:1]])
        along = np.append(along, ribbon.length)
        depth = np.append(depth, depth[0])
    count = len(position)
    uv = np.zeros((count, 4, 2))
    uv[:, :, 0] = along[:, None] + [0.0, kerf, 0.0, kerf]
    uv[:, :, 1] = np.stack([np.full(count, -above), np.full(count, kerf - above), depth, depth + kerf], axis=1)

    a = 4 * np.arange(count - 1)
    b = a + 4

    def quads(i: int, j: int) -> NDArray[np.int64]:
        """Two triangles per section between the rails i and j, outward when j follows i around the section."""
        return np.concatenate([np.stack([a + i, b + i, b + j], 1), np.stack([a + i, b + j, a + j], 1)])

    left, right = quads(0, 2), quads(3, 1)
    twisted = np.tile(_out_of_plane(position[:, 1::2]) > _TWISTED * kerf, 2)
    right[twisted] = np.concatenate([np.stack([a + 1, a + 3, b + 3], 1), np.stack([a + 1, b + 3, b + 1], 1)])[twisted]
    rest = [quads(1, 0), quads(2, 3)]
    if not ribbon.closed:
        z = 4 * (count - 1)
        rest.append(np.array([[0, 2, 3], [0, 3, 1]]))
        rest.append(np.array([[0, 3, 2], [0, 1, 3]]) + z)
    triangles = np.concatenate([left, right, *rest])
    sizes = np.cumsum([0, len(left), len(right), sum(len(r) for r in rest)])
    seam = np.arange(4) if ribbon.closed else np.arange(0)
    mesh = manifold3d.Mesh64(
        vert_properties=np.ascontiguousarray(np.concatenate([position, UV_SCALE * uv], axis=2).reshape(-1, 5)),
        tri_verts=triangles.astype(np.uint64),
        merge_from_vert=(seam + 4 * (count - 1)).astype(np.uint64),
        merge_to_vert=seam.astype(np.uint64),
        run_index=(3 * sizes).astype(np.uint64),
        run_original_id=np.array(ids, np.uint32),
        face_id=np.arange(len(triangles), dtype=np.uint64),  # so that long walls keep their sections
    )
    return manifold3d.Manifold(mesh)


def _out_of_plane(rails: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far the quads between two rails, shape (k, 2, 3), are from flat in mm, shape (k - 1,)."""
    one, other, beside, across = rails[:-1, 0], rails[1:, 0], rails[:-1, 1], rails[1:, 1]
    normal = np.cross(other - one, beside - one)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    return np.asarray(np.abs(np.einsum("ij,ij->i", normal, across - one)))


def cut(
    tissue: LabeledSolid, skin: RestSkin, incisions: Sequence[Incision], spacing: float, timeline: str
) -> LabeledSolid:
    """Make incisions in one Boolean; their walls are labeled `WOUND_WALL`.

    Parameters
    ----------
    tissue
        The tissue before.
    skin
        The uncut skin on which the curves were drawn.
    incisions
        Events with the curves.
    spacing
        Lattice spacing in mm.
    timeline
        Path of the prims' parent, for messages.

    Returns
    -------
    LabeledSolid
        The tissue after.

    Raises
    ------
    RefusedError
        If a curve cannot be cut or leaves nothing.
    """
    wall = manifold3d.Manifold.reserve_ids(1)
    cutters = []
    for incision in incisions:
        prim = f"{timeline}/{incision.name}"
        cutters += incise(skin, incision, spacing, prim, (wall, wall, wall))
    solid = manifold3d.Manifold.batch_boolean([tissue.solid, *cutters], manifold3d.OpType.Subtract)
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        raise RefusedError([problem(ProblemCode.CUT_LEAVES_NOTHING, f"{timeline}/{i.name}", i.kerf) for i in incisions])
    return tissue.with_solid(solid, {wall: _WALL})


def incise(
    skin: RestSkin, incision: Incision, spacing: float, prim: str, ids: tuple[int, int, int]
) -> list[manifold3d.Manifold]:
    """Make the solids to subtract for one incision.

    Parameters
    ----------
    skin
        The uncut skin.
    incision
        The event.
    spacing
        Lattice spacing in mm.
    prim
        Path of the prim, for messages.
    ids
        Run ids of the left walls, the right walls and the rest.

    Returns
    -------
    list[manifold3d.Manifold]
        A solid for each ribbon.

    Raises
    ------
    RefusedError
        If the curve cannot be followed; see `skin_ribbons`.
    """
    ribbons = skin_ribbons(
        skin,
        incision.points,
        prim=prim,
        basis=incision.basis,
        closed=incision.closed,
        depth=incision.depth,
        kerf=incision.kerf,
        spacing=spacing,
        direction=incision.direction,
    )
    above = max(0.5 * min(spacing, 1.0), incision.kerf)
    return [cutter(ribbon, incision.kerf, above, ids) for ribbon in ribbons]


def tidy(tissue: LabeledSolid, spacing: float, tolerance: float) -> LabeledSolid:
    """Remove short edges and flat triangles and refine edges longer than 1.5 lattice spacings.

    Triangles that no cut has touched stay as they are, to the bit. Edges and triangles by whose removal walls, or skin
    beside a cut, would come to pass through others stay: at the tips of cuts and beside folds of the skin there is less
    room than the tolerance.

    Parameters
    ----------
    tissue
        The tissue.
    spacing
        Lattice spacing in mm.
    tolerance
        Edges and heights below this are removed, mm.

    Returns
    -------
    LabeledSolid
        The tidied tissue.
    """
    if tolerance > 0.0:
        cut_surface = tissue.surface()
        simple = without_piercings(lambda left_out: _simplified(cut_surface, tolerance, left_out))
        tissue = LabeledSolid.from_surface(simple)
    fine = tissue.with_solid(tissue.solid.refine_to_length(1.5 * spacing)).surface()
    if tolerance > 0.0:  # in the rows of long triangles that are hardly wider than that
        refined = fine
        fine = without_piercings(lambda left_out: collapse_short_edges(refined, tolerance, left_out))
    # Every triangle becomes a face of its own, so that no later step merges what was refined.
    return LabeledSolid.from_surface(fine)


def _simplified(surface: Surface, tolerance: float, left_out: frozenset[Step]) -> Change:
    """The surface without short edges and flat triangles, but for what steps that are left out would remove."""
    change = unchanged(surface)
    for _ in range(3):  # what one kind of step is kept from, the other may make possible
        for remove in (collapse_short_edges, turn_flat_triangles):
            change = change.then(remove(change.surface, tolerance, left_out))
    return change


def fragments(tissue: LabeledSolid) -> list[LabeledSolid]:
    """Split the tissue into parts that do not hang together.

    Parameters
    ----------
    tissue
        The tissue.

    Returns
    -------
    list[LabeledSolid]
        The parts, largest volume first.
    """
    parts = tissue.solid.decompose()
    order = sorted(range(len(parts)), key=lambda k: -parts[k].volume())
    return [tissue.with_solid(parts[k]) for k in order]
