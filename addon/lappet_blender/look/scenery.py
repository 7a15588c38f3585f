"""Scenery in the scene: the rest of a face, its eyes and teeth."""

from __future__ import annotations

import bpy
import numpy as np

from lappet.drawing.scenery_read import SceneryMesh

from .skin_import import build_mesh, set_attribute
from .skin_material import plain_material, skin_material

EYE, IRIS, PUPIL, TEETH = (
    (0.86, 0.85, 0.83, 1.0),
    (0.13, 0.19, 0.22, 1.0),
    (0.01, 0.01, 0.012, 1.0),
    (0.8, 0.76, 0.66, 1.0),
)
_PLAIN = {"eye": (EYE, 0.15), "iris": (IRIS, 0.2), "pupil": (PUPIL, 0.1), "teeth": (TEETH, 0.25)}


def add_scenery(
    meshes: tuple[SceneryMesh, ...],
    collection: bpy.types.Collection,
    pixel: float,
    skin: bpy.types.Material | None = None,
) -> None:
    """Put scenery into a collection. pixel: size of a picture's pixel, mm. skin: that of the tissue, if not plain."""
    for mesh in meshes:
        data = build_mesh(mesh.name, mesh.points, mesh.triangles)
        if mesh.kind in _PLAIN:
            color, roughness = _PLAIN[mesh.kind]
            data.materials.append(plain_material(mesh.kind.capitalize(), color, roughness))
        else:
            data.materials.append(skin or skin_material("plain", pixel))
            set_attribute(data, "rest", "FLOAT_VECTOR", "POINT", mesh.points.astype(np.float32))
        collection.objects.link(bpy.data.objects.new(mesh.name, data))
