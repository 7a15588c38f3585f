"""Materials of a painted plate: skin with a tone, pores and fine relief that lets light in, and moist wounds.

Textures ride on the tissue by the mesh attribute `rest`.
"""

from __future__ import annotations

from typing import Any

import bpy

from lappet.anatomy.tissue_layers import TissueLayers

from .material_nodes import MaterialNodes, Space
from .skin_material import BED, underside_material, wall_material

RIDING = Space(rest=True)
_WARM = (0.735, 0.455, 0.335)  # linear; without a tone of the Monk scale
_BLUSH = (1.0, 0.83, 0.78)  # what blood under the skin takes off green and blue
_VESSEL = (0.26, 0.018, 0.022, 1.0)
_GLOSS, _LEAST_GLOSS, _LIGHT_SKIN = 0.36, 0.3, 0.2  # of light skin; the least share of it; linear grey of light skin
_DARK = 0.15  # linear grey, of the seventh tone of the Monk scale
_WARM_GLOSS = (0.05, 0.12)  # what the sheen of the darkest skin lacks of green and blue
_PORES, _RELIEF = 11.0, 7.5  # per cm
_INSIDE = 0.35  # of the light that comes back has been in the skin
_WAY = (0.10, 0.038, 0.022)  # cm that red, green and blue go there


def linear(color: str) -> tuple[float, float, float]:
    """A color #rrggbb of sRGB as linear light."""
    shares = [int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    low = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return low[0], low[1], low[2]


def is_dark(tone: str) -> bool:
    """Whether a tone #rrggbb is so dark that dark threads are not seen on it."""
    return bool(tone) and sum(linear(tone)) / 3.0 < _DARK


def painted_skin(tone: str = "") -> bpy.types.Material:
    """The skin. tone: #rrggbb; "" for a warm one of its own."""
    nodes = MaterialNodes("Skin", RIDING)
    base = linear(tone) if tone else _WARM
    # On dark skin the same white sheen would lie over most of the color and turn it grey.
    gloss = min(max(sum(base) / (3.0 * _LIGHT_SKIN), _LEAST_GLOSS), 1.0)
    flushed = (base[0] * _BLUSH[0], base[1] * _BLUSH[1], base[2] * _BLUSH[2])
    blush = nodes.ramp(nodes.noise(0.9, 3.0), ((0.36, (0.0, 0.0, 0.0)), (0.72, (0.55, 0.55, 0.55))))
    speckle = nodes.math("MULTIPLY_ADD", nodes.noise(7.0, 4.0), 0.16, 0.92)
    pit, height = _relief(nodes)
    shade = nodes.math("MULTIPLY", speckle, nodes.math("MULTIPLY_ADD", pit, 0.09, 0.91))
    color = _scaled(nodes, nodes.mix(blush, (*base, 1.0), (*flushed, 1.0)), shade)
    nodes.bump(height, 0.32, 0.012)
    roughness = nodes.math("MULTIPLY_ADD", nodes.noise(3.0, 2.0), 0.16, 0.42)
    return nodes.finish(
        color,
        Roughness=roughness,
        Specular_IOR_Level=_GLOSS * gloss,
        Specular_Tint=(1.0, *(1.0 - (1.0 - gloss) * each for each in _WARM_GLOSS), 1.0),
        Subsurface_Weight=_INSIDE,
        Subsurface_Radius=_WAY,
        Subsurface_Scale=1.0,
    )


def painted_wall(layers: TissueLayers) -> bpy.types.Material:
    """A wound wall: the layers of the tissue where they are, wet."""
    return _wet(wall_material(layers, RIDING), 0.35)


def painted_underside(layers: TissueLayers) -> bpy.types.Material:
    """The underside of a flap, wet."""
    return _wet(underside_material(layers, RIDING), 0.25)


def painted_bed() -> bpy.types.Material:
    """The deep tissue in an open wound: fibers, small vessels and a film of fluid."""
    nodes = MaterialNodes("Bed", Space())
    fibers = nodes.ramp(nodes.noise(3.5, 4.0), ((0.3, BED), (0.72, (0.60, 0.21, 0.16))))
    bent = nodes.add("ShaderNodeTexNoise", {"Vector": nodes.position(), "Scale": 2.2, "Detail": 3.0}).outputs["Color"]
    place = nodes.add("ShaderNodeVectorMath", {0: bent, 1: (0.5, 0.5, 0.5)}, operation="MULTIPLY_ADD").outputs[0]
    nodes.put(place.node.inputs[2], nodes.position())
    away = nodes.add("ShaderNodeTexVoronoi", {"Vector": place, "Scale": 1.5}, feature="DISTANCE_TO_EDGE")
    fades = nodes.math("MULTIPLY_ADD", nodes.noise(1.3, 2.0), 0.09, -0.028)  # vessels end somewhere
    width = nodes.math("MAXIMUM", fades, 0.0001)
    vessel = nodes.math("SUBTRACT", 1.0, nodes.math("DIVIDE", away.outputs["Distance"], width))
    vessel = nodes.math("MINIMUM", nodes.math("MULTIPLY", nodes.math("MAXIMUM", vessel, 0.0), 2.0), 0.8)
    color = nodes.mix(vessel, fibers, _VESSEL)
    nodes.bump(nodes.math("ADD", nodes.noise(8.0, 4.0), nodes.math("MULTIPLY", vessel, 0.4)), 0.45, 0.05)
    material = nodes.finish(color, Roughness=0.35, Emission_Color=color, Emission_Strength=0.08)
    return _wet(material, 0.5)


def _relief(nodes: MaterialNodes) -> tuple[Any, Any]:
    """Pores (0 in one, 1 beside it), and the height of the skin with them and the fine folds between."""
    pore = nodes.add("ShaderNodeTexVoronoi", {"Vector": nodes.position(), "Scale": _PORES}, feature="F1")
    pit = nodes.math("MINIMUM", nodes.math("MULTIPLY", pore.outputs["Distance"], 3.2), 1.0)
    fold = nodes.add("ShaderNodeTexVoronoi", {"Vector": nodes.position(), "Scale": _RELIEF}, feature="DISTANCE_TO_EDGE")
    plain = nodes.math("MINIMUM", nodes.math("MULTIPLY", fold.outputs["Distance"], 6.0), 1.0)
    return pit, nodes.math("ADD", nodes.math("MULTIPLY", pit, 0.55), nodes.math("MULTIPLY", plain, 0.45))


def _scaled(nodes: MaterialNodes, color: Any, share: Any) -> Any:
    """A color times a share."""
    node = nodes.add("ShaderNodeVectorMath", {0: color}, operation="SCALE")
    nodes.put(node.inputs["Scale"], share)
    return node.outputs[0]


def _wet(material: bpy.types.Material, film: float) -> bpy.types.Material:
    """Lay a film of fluid on a material."""
    bsdf = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    bsdf.inputs["Coat Weight"].default_value = film
    bsdf.inputs["Coat Roughness"].default_value = 0.12
    return material
