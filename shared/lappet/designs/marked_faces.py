"""A defect that is marked on a mesh: faces that were selected, painted or named."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.connected_labels import connected_labels
from lappet.procedure import Tissue
from lappet.procedure.prim_paths import TISSUE
from lappet.tissue.surface import skin_faces

REGION = "region:"  # before the name of a face subset


def subset_outline(tissue: Tissue, name: str) -> NDArray[np.float64]:
    """Find the outline of a face subset of a tissue, as far as it is skin.

    Parameters
    ----------
    tissue
        The tissue.
    name
        Name of the subset.

    Returns
    -------
    NDArray[np.float64]
        Points around it in mm, shape (n, 3), in no order.

    Raises
    ------
    RefusedError
        If there is no such subset, nothing of it is skin, or it is in pieces.
    """
    if name not in tissue.subsets:
        known = ", ".join(tissue.subsets) or "none"
        raise refused(ProblemCode.DESIGN_REGION_UNKNOWN, TISSUE, name, known=known)
    marked = np.zeros(len(tissue.face_vertex_counts), bool)
    marked[np.asarray(tissue.subsets[name], np.int64)] = True
    return marked_outline(
        tissue.points,
        tissue.face_vertex_counts,
        tissue.face_vertex_indices,
        marked & skin_faces(tissue),
        f"{TISSUE}/{name}",
    )


def marked_outline(
    points: ArrayLike, counts: ArrayLike, indices: ArrayLike, marked: NDArray[np.bool_], what: str
) -> NDArray[np.float64]:
    """Find the outline of marked faces.

    Parameters
    ----------
    points
        Points of the mesh in mm, shape (n, 3).
    counts
        Number of corners of each face, shape (m,).
    indices
        Points of the corners, one face after the other.
    marked
        Which faces are marked, shape (m,): faces of the skin.
    what
        Name of what is marked, for the message of an error.

    Returns
    -------
    NDArray[np.float64]
        The points of the edges that one marked face alone has, in mm, shape (k, 3), in no order: what is as large as
        them holds all the faces where these are nearly flat.

    Raises
    ------
    RefusedError
        If no face is marked, or the marked faces are in pieces that share no point.
    """
    places, sizes, corners = np.asarray(points, np.float64), np.asarray(counts, np.int64), np.asarray(indices, np.int64)
    if not marked.any():
        raise refused(ProblemCode.DESIGN_DEFECT_UNMARKED, what, 0)
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    face = np.repeat(np.arange(len(sizes)), sizes)
    following = np.arange(len(corners)) + 1
    following[starts + sizes - 1] = starts
    edges = np.sort(np.stack([corners, corners[following]], axis=1)[marked[face]], axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    pieces = len(np.unique(connected_labels(len(places), unique)[unique]))
    if pieces > 1:
        raise refused(ProblemCode.DESIGN_DEFECT_PIECES, what, pieces)
    return places[np.unique(unique[uses == 1])]
