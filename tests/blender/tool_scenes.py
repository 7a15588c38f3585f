"""Scenes for the tools' tests: flat tissue, a dome, and a bent skin as the display shows a solved one."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from lappet_blender.tools import shown_surface

Bend = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def stand_in_display(monkeypatch: pytest.MonkeyPatch) -> None:
    """The skin of a scene is `scene.lappet.skin`, whether the display has made it or a test."""
    monkeypatch.setattr(shown_surface, "skin_object", lambda scene: scene.lappet.skin)


def flat_tissue(scene: bpy.types.Scene, scale_length: float = 0.001) -> bpy.types.Object:
    """A block of 40 x 40 x 4 mm, its skin at z = 0, in squares of 1 mm."""
    scene.unit_settings.scale_length = scale_length
    points, quads = _block(41)
    mesh = bpy.data.meshes.new("tissue")
    mesh.from_pydata((points / (1000.0 * scale_length)).tolist(), [], quads.tolist())
    tissue = bpy.data.objects.new("tissue", mesh)
    scene.collection.objects.link(tissue)
    scene.lappet.tissue.object = tissue
    bpy.context.view_layer.update()
    return tissue


def dome_tissue(
    scene: bpy.types.Scene, count: int = 71
) -> tuple[bpy.types.Object, Callable[[NDArray[np.float64] | float, NDArray[np.float64] | float], NDArray[np.float64]]]:
    """An open dome, 80 mm wide, in count x count points, and its height (mm) over the plane."""

    def height(x: NDArray[np.float64] | float, y: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return np.sqrt(60.0**2 - np.square(x) - np.square(y)) - 40.0

    scene.unit_settings.scale_length = 0.001
    x, y = np.meshgrid(np.linspace(-40, 40, count), np.linspace(-40, 40, count))
    ids = np.arange(count * count).reshape(count, count)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    mesh = bpy.data.meshes.new("dome")
    mesh.from_pydata(np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3).tolist(), [], quads.tolist())
    dome = bpy.data.objects.new("dome", mesh)
    scene.collection.objects.link(dome)
    scene.lappet.tissue.object, scene.lappet.tissue.thicken = dome, True
    bpy.context.view_layer.update()
    return dome, height


def solved_skin(
    scene: bpy.types.Scene, keep: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None
) -> tuple[bpy.types.Object, Bend]:
    """A skin as the display makes it of the flat tissue: rolled up around the y axis, with the attributes of an epoch.

    keep: which triangles (by their centers at rest, (m, 3)) are still there. Returns the object and the bend.
    """

    def bend(rest: NDArray[np.float64]) -> NDArray[np.float64]:
        radius = 25.0 + rest[:, 2]
        angle = rest[:, 0] / 25.0
        return np.stack([radius * np.sin(angle), 1.1 * rest[:, 1], radius * np.cos(angle) - 5.0], axis=1)

    rest, quads = _block(41)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    face = np.tile(np.arange(len(quads)), 2)
    if keep is not None:
        there = keep(rest[triangles].mean(axis=1))
        triangles, face = triangles[there], face[there]
    middle = rest[triangles].mean(axis=1)[:, 2]
    origin = np.where(middle > -1e-6, 0, np.where(middle < -4.0 + 1e-6, 2, 3)).astype(np.int32)
    mesh = bpy.data.meshes.new("epoch")
    mesh.from_pydata(bend(rest).tolist(), [], triangles.tolist())
    mesh.attributes.new("rest", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest.astype(np.float32).ravel())
    mesh.attributes.new("origin", "INT", "FACE").data.foreach_set("value", origin)
    mesh.attributes.new("face", "INT", "FACE").data.foreach_set("value", face.astype(np.int32))
    skin = bpy.data.objects.new("skin", mesh)
    scene.collection.objects.link(skin)
    scene.lappet.skin = skin
    scene.lappet.tissue.object.hide_set(True)
    bpy.context.view_layer.update()
    return skin, bend


def _block(count: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A closed block in mm: count x count points above and below, quads that look outward."""
    x, y = np.meshgrid(np.linspace(-20, 20, count), np.linspace(-20, 20, count))
    top = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    ids = np.arange(count * count).reshape(count, count)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    rim = np.concatenate([ids[0, :-1], ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0]])
    following = np.roll(rim, -1)
    below = count * count
    sides = np.stack([rim, rim + below, following + below, following], axis=1)
    return np.vstack([top, top - (0, 0, 4.0)]), np.concatenate([quads, quads[:, ::-1] + below, sides])
