"""Triangles as rows of corners: their normals and areas, and points on them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def directions(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Scale vectors to length 1; those of length 0 stay.

    Parameters
    ----------
    vectors
        Vectors, shape (k, 3).

    Returns
    -------
    NDArray[np.float64]
        Unit vectors, shape (k, 3).
    """
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)


def area_normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute normals of triangles that are twice as long as the triangles are large.

    Parameters
    ----------
    corners
        Triangles, shape (k, 3, 3).

    Returns
    -------
    NDArray[np.float64]
        Normals, shape (k, 3).
    """
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def areas(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the areas of triangles.

    Parameters
    ----------
    corners
        Triangles, shape (k, 3, 3).

    Returns
    -------
    NDArray[np.float64]
        Areas, shape (k,).
    """
    return np.asarray(0.5 * np.linalg.norm(area_normals(corners), axis=1))


def barycentric(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the barycentric weights of points on triangles, clipped to the triangle.

    Parameters
    ----------
    points
        Points, shape (k, 3).
    corners
        The triangle of each, shape (k, 3, 3).

    Returns
    -------
    NDArray[np.float64]
        Weights, shape (k, 3).
    """
    a = corners[:, 0]
    u, v, w = corners[:, 1] - a, corners[:, 2] - a, points - a
    uu, uv, vv = (np.einsum("ij,ij->i", p, q) for p, q in ((u, u), (u, v), (v, v)))
    wu, wv = np.einsum("ij,ij->i", w, u), np.einsum("ij,ij->i", w, v)
    det = uu * vv - uv * uv
    safe = np.where(np.abs(det) > 1e-300, det, 1.0)
    b, c = (vv * wu - uv * wv) / safe, (uu * wv - uv * wu) / safe
    weights = np.clip(np.stack([1.0 - b - c, b, c], axis=1), 0.0, 1.0)
    return weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-300)
