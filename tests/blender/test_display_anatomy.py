"""Layers and vessels of a solved skin: the colors of cut faces are those of materials, vessels are tubes."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
import pytest

from lappet.anatomy.tissue_kind import KIND_COLORS, KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.procedure import Vessel
from lappet_blender.display import skin_display
from lappet_blender.display.display_collection import find_collection, find_object
from lappet_blender.look.layer_image import ROW, WIDTH, depth_reach, layer_pixels, layer_rows
from lappet_blender.look.skin_material import TRANSLUCENT
from lappet_blender.look.vessel_tubes import STUMP
from slit_manifest import Solved, add_tissue, slit, slit_manifest, solved

__all__ = ["solved"]  # a fixture
STEP = 5.0
SKIN_OVER_FAT = TissueLayers(
    np.zeros(2, np.int32),
    np.array([0.0, 1.5]),
    np.array([KINDS.index("skin"), KINDS.index("fat")], np.int32),
    ("skin", "fat"),
)
RADIUS = 0.8
WHOLE = np.array([(-3.0, -8.0, -1.0), (-3.0, 0.0, -1.0), (-3.0, 8.0, -1.0)])
HALVES = np.array([(-3.0, -8.0, -1.0), (-3.0, -0.1, -1.0), (-3.0, 0.1, -1.0), (-3.0, 8.0, -1.0)])


@pytest.fixture
def shown(scene: bpy.types.Scene, solved: Solved) -> bpy.types.Scene:
    """A scene with the slit patch solved, its wall of two layers, an artery across the slit, at frame 1."""
    add_tissue(scene)
    manifest, frames = slit_manifest(STEP)
    pieces = (
        VesselPieces(np.zeros(1, np.int32), np.array([3], np.int32), np.zeros((1, 2), np.uint8), WHOLE),
        VesselPieces(np.zeros(2, np.int32), np.array([2, 2], np.int32), np.array([(0, 1), (1, 0)], np.uint8), HALVES),
    )
    manifest = replace(manifest, layers=SKIN_OVER_FAT, vessels=(Vessel("a", ((0, 0, 0),)),), vessels_at=pieces)
    manifest = replace(manifest, vessels=(replace(manifest.vessels[0], radius=RADIUS),))
    frames = {
        time: replace(frame, vessel_points=pieces[int(time >= slit.INCISED)].points) for time, frame in frames.items()
    }
    solved.manifests[scene.name] = (manifest, frames)
    skin_display.refresh(scene)
    return scene


def tubes(scene: bpy.types.Scene, role: str) -> bpy.types.Object:
    collection = find_collection(scene)
    assert collection is not None
    found = find_object(collection, role)
    assert found is not None
    return found


def extent(each: bpy.types.Object) -> np.ndarray:
    """Lowest and highest corner in mm; the scene's unit is a centimetre."""
    at = np.array([vertex.co for vertex in each.data.vertices]) * 10.0
    return np.stack([at.min(axis=0), at.max(axis=0)])


def test_a_vessel_is_a_tube_of_its_radius_and_its_cut_ends_stand_out_of_the_walls(shown: bpy.types.Scene) -> None:
    low, high = extent(tubes(shown, "artery"))
    assert (low[1], high[1]) == pytest.approx((-8.0, 8.0), abs=1e-4)
    assert high[2] - low[2] == pytest.approx(2.0 * RADIUS, rel=1e-3)
    shown.frame_set(slit.INCISED)
    rings = np.array([vertex.co for vertex in tubes(shown, "artery").data.vertices])[:, 1] * 10.0
    assert rings[rings < -1.0].max() == pytest.approx(-8.0, abs=1e-4)
    assert (rings[np.abs(rings) < 1.0].max(), rings[np.abs(rings) < 1.0].min()) == pytest.approx(
        (-0.1 + STUMP, 0.1 - STUMP), abs=1e-4
    )
    assert len(tubes(shown, "lumen").data.vertices) > 0


def test_vessels_can_be_hidden_and_shown_through_the_skin(shown: bpy.types.Scene) -> None:
    shown.lappet.look.show_through = True
    skin = skin_display.skin_object(shown)
    assert skin is not None
    principled = next(n for n in skin.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    assert principled.inputs["Alpha"].default_value == pytest.approx(TRANSLUCENT)
    shown.lappet.look.show_through = False
    principled = next(n for n in skin.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    assert principled.inputs["Alpha"].default_value == 1.0
    shown.lappet.look.show_vessels = False
    assert tubes(shown, "artery").hide_viewport


def test_the_wall_has_the_colors_of_the_layers_at_its_depths(shown: bpy.types.Scene) -> None:
    shown.frame_set(slit.INCISED)
    skin = skin_display.skin_object(shown)
    assert skin is not None
    (image,) = {
        node.image for node in skin.data.materials[1].node_tree.nodes if node.type == "TEX_IMAGE" and node.image
    }
    assert tuple(image.size) == (WIDTH, 1)
    pixels = np.empty(4 * WIDTH, np.float32)
    image.pixels.foreach_get(pixels)
    depth = (np.arange(WIDTH) + 0.5) / WIDTH * depth_reach(SKIN_OVER_FAT)
    for kind, held in (("skin", depth < 1.5), ("fat", depth >= 1.5)):
        assert np.allclose(pixels.reshape(-1, 4)[held, :3], KIND_COLORS[kind], atol=1e-6)
    rows = np.empty(len(skin.data.polygons), np.float32)
    skin.data.attributes[ROW].data.foreach_get("value", rows)
    assert np.all(rows == 0.5)


def test_columns_have_rows_of_their_own_in_the_picture() -> None:
    layers = TissueLayers(
        np.array([0, 0, 1], np.int32),
        np.array([0.0, 2.0, 0.0]),
        np.array([0, 1, KINDS.index("scar")], np.int32),
        ("skin", "fat", "scar"),
    )
    pixels = layer_pixels(layers)
    assert pixels.shape == (2, WIDTH, 4)
    assert np.allclose(pixels[1, :, :3], KIND_COLORS["scar"])
    assert np.allclose(layer_rows(layers, np.array([0, 1], np.int32)), [0.25, 0.75])
