"""Node materials of the plate: skin with a printed grid, wound wall, fat, bed, thread and steel.

Lengths in the shaders are mm through the mesh attributes `grid` (mm on the skin) and `depth` (mm below the skin).
"""

from __future__ import annotations

from typing import Any

import bpy

from lappet.anatomy.tissue_kind import KIND_COLORS, KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.drawing.quantity_scale import RAMP
from lappet.drawing.skin_source import SCALARS
from lappet.procedure.vessel import VESSEL_COLORS

from .layer_image import ROW, depth_reach, layer_image
from .material_nodes import FIGURE, MaterialNodes, Space

SKIN = (0.80, 0.535, 0.405, 1.0)
GRID_INK = (0.235, 0.11, 0.085, 1.0)
MUCOSA = (0.62, 0.27, 0.24, 1.0)
BED = (0.47, 0.115, 0.10, 1.0)
EDGE = (0.30, 0.045, 0.04, 1.0)
VIOLET = (0.115, 0.045, 0.26, 1.0)
THREAD = (0.008, 0.012, 0.045, 1.0)
PALE_THREAD = (0.50, 0.62, 0.85, 1.0)
STEEL = (0.62, 0.64, 0.66, 1.0)
GRID_PITCH = 5.0
TICK_PITCH = 1.0
INK_SHARE = 0.62
CHECKER_INK = (0.30, 0.135, 0.10, 1.0)
CHECKER_SHARE = 0.72


_MOTTLE, _PALE = 0.22, 0.3
TRANSLUCENT = 0.35  # opacity of skin and walls through which vessels are to show
FULL_SCALE = "lappet_full_scale"  # the node that divides `quantity`


def _lines(nodes: MaterialNodes, coordinate: Any, pitch: float, width: float) -> Any:
    """1 on lines of a width (mm) at every multiple of a pitch (mm), with edges softened over a third of the width."""
    away = nodes.math("PINGPONG", coordinate, pitch / 2)
    edge = nodes.add(
        "ShaderNodeMapRange",
        {0: away, 1: width * 0.33, 2: width * 0.67, 3: 1.0, 4: 0.0},
        interpolation_type="SMOOTHSTEP",
    )
    return edge.outputs[0]


def _grid(nodes: MaterialNodes, pixel: float) -> Any:
    """How much ink (0 to 1) the printed grid lays on the skin; pixel: size of a picture's pixel on the skin, mm."""
    parts = nodes.add("ShaderNodeSeparateXYZ", {0: nodes.attribute("grid").outputs["Vector"]})
    heavy = max(0.24, 1.5 * pixel)
    fine = max(0.09, 1.1 * pixel)
    wide = nodes.math("MAXIMUM", *(_lines(nodes, parts.outputs[k], GRID_PITCH, heavy) for k in (0, 1)))
    # A tick finer than a pixel would shimmer: it fades out instead.
    strength = 0.12 * max(0.0, min(1.0, (0.28 - pixel) / 0.16))
    if strength <= 0.0:
        return nodes.math("MULTIPLY", wide, INK_SHARE)
    ticks = nodes.math("MAXIMUM", *(_lines(nodes, parts.outputs[k], TICK_PITCH, fine) for k in (0, 1)))
    return nodes.math("MAXIMUM", nodes.math("MULTIPLY", wide, INK_SHARE), nodes.math("MULTIPLY", ticks, strength))


def _checker(nodes: MaterialNodes) -> Any:
    """0 and 1 on the squares of a checkerboard of `GRID_PITCH`."""
    parts = nodes.add("ShaderNodeSeparateXYZ", {0: nodes.attribute("grid").outputs["Vector"]})
    u, v = (nodes.math("FLOOR", nodes.math("DIVIDE", parts.outputs[k], GRID_PITCH)) for k in (0, 1))
    return nodes.math("FLOORED_MODULO", nodes.math("ADD", u, v), 2.0)


def set_full_scale(material: bpy.types.Material, highest: float) -> None:
    """Change the value at the top of the ramp of a material made by `skin_material`; one without a ramp stays."""
    node = material.node_tree.nodes.get(FULL_SCALE)
    if node is not None and node.inputs[1].default_value != highest:
        node.inputs[1].default_value = highest


def skin_material(
    color: str, pixel: float, highest: float = 1.0, space: Space = FIGURE, opacity: float = 1.0
) -> bpy.types.Material:
    """The skin. color: plain, grid, checker, strain, stress or tension; these three map `quantity` from 0 to highest.

    pixel: size of a picture's pixel on the skin, mm. opacity: below 1 what lies in the tissue shows through.
    """
    nodes = MaterialNodes("Skin", space)
    mottle = nodes.noise(1.1, 3.0)
    tone = nodes.ramp(mottle, ((0.3, (0.74, 0.455, 0.335)), (0.7, (0.775, 0.50, 0.38))))
    if color in SCALARS:
        share = nodes.math("DIVIDE", nodes.attribute("quantity").outputs["Fac"], max(highest, 1e-9))
        share.node.name = FULL_SCALE
        tone = nodes.ramp(nodes.math("MINIMUM", share, 1.0), RAMP)
    if color == "checker":
        tone = nodes.mix(nodes.math("MULTIPLY", _checker(nodes), CHECKER_SHARE), tone, CHECKER_INK)
    elif color != "plain":
        tone = nodes.mix(_grid(nodes, pixel), tone, GRID_INK)
    # Subsurface scattering would cost half of the render time again; warm color and soft light stand in for it.
    material = nodes.finish(tone, Roughness=0.55, Specular_IOR_Level=0.32)
    nodes.put(nodes.bsdf.inputs["Alpha"], opacity)
    material.diffuse_color = (*SKIN[:3], opacity)
    return material


def _layer_color(nodes: MaterialNodes, layers: TissueLayers, uneven: float) -> Any:
    """The color of the layer that a face shows. uneven: by how much the borders of layers waver, mm."""
    depth = nodes.attribute("depth").outputs["Fac"]
    if layers.deepest_border > 0.0:
        waver = nodes.math("SUBTRACT", nodes.noise(5.0, 3.0), 0.5)
        depth = nodes.math("MAXIMUM", nodes.math("MULTIPLY_ADD", waver, 2.0 * uneven, depth), 0.0)
    across = nodes.math("DIVIDE", depth, depth_reach(layers))
    place = nodes.add("ShaderNodeCombineXYZ", {0: across, 1: nodes.attribute(ROW).outputs["Fac"]}).outputs[0]
    picture = nodes.add("ShaderNodeTexImage", {0: place}, interpolation="Closest", extension="EXTEND")
    picture.image = layer_image(layers)
    blotch = nodes.math("MULTIPLY", nodes.noise(4.0, 3.0), _MOTTLE)
    return nodes.mix(blotch, picture.outputs["Color"], (0.0, 0.0, 0.0, 1.0))


def _first_color(layers: TissueLayers) -> tuple[float, float, float, float]:
    """The color of the first layer, for shading that knows no nodes."""
    return (*KIND_COLORS[KINDS[int(layers.kind[0])]], 1.0)


def wall_material(layers: TissueLayers, space: Space = FIGURE, opacity: float = 1.0) -> bpy.types.Material:
    """A wound wall: the layers of the tissue where they are, moist."""
    nodes = MaterialNodes("Wound wall", space)
    color = _layer_color(nodes, layers, 0.3)
    nodes.bump(nodes.noise(9.0, 4.0), 0.35, 0.04)
    material = nodes.finish(color, Roughness=0.32, Emission_Color=color, Emission_Strength=0.07)
    nodes.put(nodes.bsdf.inputs["Alpha"], opacity)
    material.diffuse_color = _first_color(layers)
    return material


def rim_material(layers: TissueLayers, space: Space = FIGURE) -> bpy.types.Material:
    """The cut rim of a patch: a quiet section through its layers."""
    nodes = MaterialNodes("Rim", space)
    pale = nodes.mix(_PALE, _layer_color(nodes, layers, 0.1), SKIN)
    material = nodes.finish(pale, Roughness=0.6)
    material.diffuse_color = _first_color(layers)
    return material


def mucosa_material(space: Space = FIGURE) -> bpy.types.Material:
    """A free border of the tissue, such as the edge of a lid or a lip: moist and red, no cut."""
    nodes = MaterialNodes("Mucosa", space)
    return nodes.finish(MUCOSA, Roughness=0.3)


def plain_material(name: str, color: tuple[float, float, float, float], roughness: float) -> bpy.types.Material:
    """A material of one color."""
    return MaterialNodes(name).finish(color, Roughness=roughness)


def underside_material(layers: TissueLayers, space: Space = FIGURE) -> bpy.types.Material:
    """The underside of the tissue: its deepest layer, lobules where that is fat."""
    nodes = MaterialNodes("Underside", space)
    color = _layer_color(nodes, layers, 0.3)
    if KINDS.index("fat") in layers.kind:
        cells = nodes.add(
            "ShaderNodeTexVoronoi", {"Vector": nodes.position(), "Scale": 4.5}, feature="SMOOTH_F1"
        ).outputs["Distance"]
        nodes.bump(nodes.math("SUBTRACT", 1.0, cells), 0.6, 0.06)
    else:
        nodes.bump(nodes.noise(7.0, 4.0), 0.3, 0.04)
    material = nodes.finish(color, Roughness=0.36, Emission_Color=color, Emission_Strength=0.05)
    material.diffuse_color = _first_color(layers)
    return material


def vessel_material(kind: str) -> bpy.types.Material:
    """A vessel or nerve in the color that atlases give its kind."""
    color = (*VESSEL_COLORS[kind], 1.0)
    return MaterialNodes(kind.capitalize()).finish(color, Roughness=0.34, Specular_IOR_Level=0.4)


def lumen_material() -> bpy.types.Material:
    """The opening of a cut vessel."""
    return MaterialNodes("Lumen").finish((0.012, 0.003, 0.003, 1.0), Roughness=0.5)


def bed_material(space: Space = FIGURE) -> bpy.types.Material:
    """The deep tissue in an open wound: dark red, fibrous, moist.

    A little light of its own, here and on the wall, stands in for the bounces that a deep pocket would need.
    """
    nodes = MaterialNodes("Bed", space)
    color = nodes.ramp(nodes.noise(3.5, 4.0), ((0.3, BED), (0.72, (0.62, 0.22, 0.17))))
    nodes.bump(nodes.noise(8.0, 4.0), 0.4, 0.05)
    material = nodes.finish(color, Roughness=0.35, Emission_Color=color, Emission_Strength=0.10)
    material.diffuse_color = BED
    return material


def edge_material() -> bpy.types.Material:
    """The line of the wound's lips: clotted red."""
    return MaterialNodes("Wound edge").finish(EDGE, Roughness=0.6, Specular_IOR_Level=0.2)


def ink_material() -> bpy.types.Material:
    """The surgeon's marking pen: gentian violet."""
    return MaterialNodes("Marking ink").finish(VIOLET, Roughness=0.9, Specular_IOR_Level=0.1)


def landmark_material() -> bpy.types.Material:
    """A landmark's bead: surgical blue."""
    return MaterialNodes("Landmark").finish((0.02, 0.16, 0.42, 1.0), Roughness=0.4)


def thread_material(pale: bool = False) -> bpy.types.Material:
    """Monofilament nylon, blue-black. pale: undyed, as it is told from dark skin."""
    return MaterialNodes("Thread").finish(PALE_THREAD if pale else THREAD, Roughness=0.32)


def steel_material() -> bpy.types.Material:
    """Brushed surgical steel."""
    return MaterialNodes("Steel").finish(STEEL, Metallic=1.0, Roughness=0.36)


def glowing_material(name: str, color: tuple[float, float, float, float] | None) -> bpy.types.Material:
    """A flat color that no light changes; None: the mesh's color attribute `Color`."""
    material = bpy.data.materials.new(name)
    if not material.use_nodes:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    glow = tree.nodes.new("ShaderNodeEmission")
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(glow.outputs[0], out.inputs[0])
    if color is None:
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = "Color"
        tree.links.new(attribute.outputs["Color"], glow.inputs["Color"])
    else:
        glow.inputs["Color"].default_value = color
        material.diffuse_color = color
    return material


def backdrop_material() -> bpy.types.Material:
    """The seamless paper behind the plate."""
    return MaterialNodes("Backdrop").finish((0.80, 0.81, 0.815, 1.0), Roughness=1.0, Specular_IOR_Level=0.0)
