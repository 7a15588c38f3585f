"""Meshes like those of faces, made from formulas: a bumpy skin with a nose, a fold, an ala with its nostril, shells."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from lappet.tissue.mesh_file import Mesh


def grid_triangles(rows: int, columns: int) -> NDArray[np.int64]:
    """The triangles of a grid of rows x columns vertices, counterclockwise where x runs along a row."""
    i = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([i, i + 1, i + columns + 1], axis=1)
    upper = np.stack([i, i + columns + 1, i + columns], axis=1)
    return np.concatenate([lower, upper]).astype(np.int64)


def nose(spacing: float = 1.5, noise: float = 0.0) -> Mesh:
    """A skin of 80 x 80 mm with a nose 18 mm high whose tip and alae are rounder than 5 mm, its normals up."""
    at = np.arange(-40.0, 40.0 + 1e-9, spacing)
    x, y = (each.ravel() for each in np.meshgrid(at, at))
    bridge = 12.0 * np.exp(-((x / 7.0) ** 2)) / (1.0 + np.exp(-(y + 12.0) / 1.5)) / (1.0 + np.exp((y - 22.0) / 6.0))
    tip = 7.0 * np.exp(-((x / 4.5) ** 2 + ((y + 8.0) / 4.5) ** 2))
    alae = sum(6.0 * np.exp(-(((x - side) / 3.0) ** 2 + ((y + 8.0) / 3.5) ** 2)) for side in (-9.0, 9.0))
    z = bridge + tip + alae - 0.004 * (x * x + y * y)
    if noise:
        z = z + noise * np.random.default_rng(7).standard_normal(len(z))
    return Mesh(np.stack([x, y, z], axis=1), grid_triangles(len(at), len(at)))


def fold(gap: float = 3.0, depth: float = 15.0, spacing: float = 0.75) -> Mesh:
    """A skin folded back like an ear: two flat sides `gap` apart, joined by a round rim, lying in the x direction."""
    radius = gap / 2.0
    flat = np.arange(0.0, depth, spacing)
    turn = np.linspace(-np.pi / 2.0, np.pi / 2.0, 9)
    x = np.concatenate([flat, depth + radius * np.cos(turn), flat[::-1]])
    z = np.concatenate([np.full(len(flat), -radius), radius * np.sin(turn), np.full(len(flat), radius)])
    y = np.arange(-10.0, 10.0 + 1e-9, spacing)
    points = np.stack([np.tile(x, len(y)), np.repeat(y, len(x)), np.tile(z, len(y))], axis=1)
    return Mesh(points, grid_triangles(len(y), len(x))[:, ::-1])


def roll(radius: float = 4.0, spacing: float = 0.6) -> Mesh:
    """A skin that runs flat for 20 mm and then around a cylinder by 150°, turned away from its outside."""
    turn = np.arange(0.0, np.radians(150.0), spacing / radius)
    flat = np.arange(spacing, 20.0, spacing)
    x = np.concatenate([-radius * np.sin(turn[::-1]), flat])
    z = np.concatenate([radius * (np.cos(turn[::-1]) - 1.0), np.zeros(len(flat))])
    y = np.arange(-10.0, 10.0 + 1e-9, spacing)
    points = np.stack([np.tile(x, len(y)), np.repeat(y, len(x)), np.tile(z, len(y))], axis=1)
    return Mesh(points, grid_triangles(len(y), len(x)))


def ala(thickness: float = 3.0, radius: float = 9.0) -> Mesh:
    """A closed solid with a pit: a block of skin whose side wall, between its outside and the pit, is so thick.

    The block is the ball of `radius` + `thickness`; the pit is a smaller ball around the same middle that opens through
    a hole at the bottom, as a nostril does. The pit's lining is connected with the skin.
    """
    import manifold3d

    outer = manifold3d.Manifold.sphere(radius + thickness, 128)
    pit = manifold3d.Manifold.sphere(radius, 128)
    opening = manifold3d.Manifold.cylinder(2.0 * radius, 4.0, 4.0, 64).translate([0.0, 0.0, -2.0 * radius])
    mesh = (outer - pit - opening).to_mesh64()
    return Mesh(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64))


def shell(outer: float = 60.0, inner: float = 56.0) -> Mesh:
    """A hollow ball: its outer wall faces outwards, its inner wall inwards."""
    walls = [trimesh.creation.icosphere(subdivisions=5, radius=radius) for radius in (outer, inner)]
    walls[1].invert()
    both = trimesh.util.concatenate(walls)
    return Mesh(np.asarray(both.vertices, np.float64), np.asarray(both.faces, np.int64))
