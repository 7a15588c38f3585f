"""Repair a triangle mesh: weld, drop, turn and fill, and say what was done."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.nesting import outermost_around
from lappet.geometry.separate_sheets import separate_sheets
from lappet.geometry.surface_check import directed_edges, open_edges, signed_volume, unique_edges
from lappet.geometry.triangulation import clip_ears
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_report import Note, repaired

_WELD = 1e-6  # of the mesh's diagonal


def weld(mesh: Mesh) -> tuple[Mesh, list[Note]]:
    """Keep one vertex per position (to 10⁻⁶ of the diagonal), and drop doubles and faces without area.

    Parameters
    ----------
    mesh
        The mesh.

    Returns
    -------
    tuple[Mesh, list[Note]]
        The welded mesh, and what was done.
    """
    used = np.unique(mesh.triangles)
    grid = _WELD * max(float(np.linalg.norm(np.ptp(mesh.points[used], axis=0))), 1e-300)
    _, first, inverse = np.unique(np.round(mesh.points[used] / grid), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    renamed = np.full(len(mesh.points), -1, np.int64)
    renamed[used] = rank[inverse.reshape(-1)]
    points = mesh.points[used][first[order]]
    triangles = renamed[mesh.triangles]
    a, b, c = triangles.T
    keep = (a != b) & (b != c) & (c != a)
    _, unique = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    single = np.zeros(len(triangles), bool)
    single[unique] = True
    counts = {
        "merged vertices": (len(used) - len(points), "at the same place"),
        "loose points": (len(mesh.points) - len(used), "without a face, left out"),
        "degenerate faces": (int((~keep).sum()), "removed"),
        "doubled faces": (int((keep & ~single).sum()), "removed"),
    }
    notes = [repaired(what, f"{count} {done}") for what, (count, done) in counts.items() if count]
    keep &= single
    return Mesh(points, triangles[keep], None if mesh.uv is None else mesh.uv[keep]), notes


def separate(mesh: Mesh) -> tuple[Mesh, list[Note]]:
    """Take the mesh apart where it is not manifold: at edges of more than two faces, and where fans of faces touch.

    Parameters
    ----------
    mesh
        The mesh.

    Returns
    -------
    tuple[Mesh, list[Note]]
        A mesh whose edges belong to one face or two, and what was done.
    """
    source, triangles, crowded = separate_sheets(mesh.points, mesh.triangles)
    copies = len(source) - len(mesh.points)
    notes = [repaired("non-manifold edges", f"{crowded} of more than two faces, taken apart")] if crowded else []
    if copies and not crowded:
        notes.append(repaired("non-manifold vertices", f"{copies} fans of faces taken apart"))
    return Mesh(mesh.points[source], triangles, mesh.uv), notes


def orient(mesh: Mesh) -> tuple[Mesh, list[Note]]:
    """Turn neighboring faces alike: closed parts outwards, open parts as most of their faces were.

    A closed part inside another one is a cavity of it, and turned inwards, if the file turns the two against each
    other. Faces that meet along an edge of three or more are not compared. A surface that cannot be turned alike (a
    Möbius strip) is left with its seam, which the later check names.

    Parameters
    ----------
    mesh
        The mesh.

    Returns
    -------
    tuple[Mesh, list[Note]]
        The oriented mesh, and what was done.
    """
    edges = directed_edges(mesh.triangles)
    count = len(mesh.triangles)
    _, inverse, times = unique_edges(edges)
    order = np.argsort(inverse, kind="stable")
    starts = np.concatenate([[0], np.cumsum(times)[:-1]])[times == 2]
    one, two = order[starts], order[starts + 1]
    same = edges[one, 0] == edges[two, 0]
    neighbors: list[list[tuple[int, bool]]] = [[] for _ in range(count)]
    for f, g, s in zip((one % count).tolist(), (two % count).tolist(), same.tolist(), strict=True):
        neighbors[f].append((g, s))
        neighbors[g].append((f, s))
    turned = np.zeros(count, bool)
    part = np.full(count, -1)
    parts = 0
    for seed in range(count):
        if part[seed] >= 0:
            continue
        part[seed] = parts
        queue = deque([seed])
        while queue:
            f = queue.popleft()
            for g, s in neighbors[f]:
                if part[g] < 0:
                    part[g] = parts
                    turned[g] = turned[f] ^ s
                    queue.append(g)
        parts += 1
    flipped = mesh.triangles.copy()
    flipped[turned] = flipped[turned][:, ::-1]
    members = [np.flatnonzero(part == k) for k in range(parts)]
    closed = [faces for faces in members if len(open_edges(flipped[faces])) == 0]
    for faces in members:
        # What most faces of the part say.
        if turned[faces].mean() > 0.5:
            turned[faces] = ~turned[faces]
            flipped[faces] = flipped[faces][:, ::-1]
    inside_out = _inside_out(mesh.points, [flipped[faces] for faces in closed])
    for k in inside_out:
        turned[closed[k]] = ~turned[closed[k]]
    triangles, uv = mesh.triangles.copy(), None if mesh.uv is None else mesh.uv.copy()
    triangles[turned] = triangles[turned][:, ::-1]
    if uv is not None:
        uv[turned] = uv[turned][:, ::-1]
    notes = [repaired("flipped normals", f"{int(turned.sum())} faces turned")] if turned.any() else []
    if inside_out:
        notes.append(repaired("parts inside out", f"{len(inside_out)} closed, turned outwards"))
    return Mesh(mesh.points, triangles, uv), notes


def _inside_out(points: NDArray[np.float64], closed: list[NDArray[np.int64]]) -> list[int]:
    """Which of the closed parts (m, 3) are to be turned, so that all face outwards but the walls of cavities."""
    outwards = [signed_volume(points, part) >= 0.0 for part in closed]
    cavity = [False] * len(closed)
    if len(set(outwards)) > 1:  # else no part is turned against another
        for k, around in enumerate(outermost_around(points, closed)):
            cavity[k] = around is not None and outwards[k] != outwards[around]
    return [k for k, out in enumerate(outwards) if out == cavity[k]]


def fill(mesh: Mesh, loops: list[NDArray[np.int64]]) -> Mesh:
    """Close border loops by triangles; the UVs there are those of the loop's vertices.

    Parameters
    ----------
    mesh
        The mesh.
    loops
        Vertex indices of each loop.

    Returns
    -------
    Mesh
        The mesh with these loops closed.
    """
    pieces, uvs = [mesh.triangles], [mesh.uv]
    uv_at = None
    if mesh.uv is not None:
        uv_at = np.zeros((len(mesh.points), 2))
        uv_at[mesh.triangles.reshape(-1)] = mesh.uv.reshape(-1, 2)
    for loop in loops:
        back = loop[::-1]
        triangles = back[clip_ears(mesh.points[back])]
        pieces.append(triangles)
        if uv_at is not None:
            uvs.append(uv_at[triangles])
    uv = None if mesh.uv is None else np.concatenate([u for u in uvs if u is not None])
    return Mesh(mesh.points, np.concatenate(pieces), uv)
