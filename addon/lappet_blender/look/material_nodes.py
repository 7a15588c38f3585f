"""Build a material node by node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy


@dataclass(frozen=True)
class Space:
    """Where a material is.

    Blender units per mm, and whether its mesh has the attribute `rest` (mm), on which blotches then ride.
    """

    units: float = 0.1
    rest: bool = False


FIGURE = Space()


class MaterialNodes:
    """Add nodes to a material's tree and link them; values may be constants or sockets."""

    def __init__(self, name: str, space: Space = FIGURE) -> None:
        self.space = space
        self.material = bpy.data.materials.new(name)
        if not self.material.use_nodes:
            self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.bsdf = next(n for n in self.tree.nodes if n.type == "BSDF_PRINCIPLED")

    def add(self, kind: str, inputs: dict[int | str, Any] | None = None, **settings: Any) -> Any:
        """A new node. inputs: values or sockets by name or index; settings: its properties."""
        node = self.tree.nodes.new(kind)
        for name, setting in settings.items():
            setattr(node, name, setting)
        for key, value in (inputs or {}).items():
            self.put(node.inputs[key], value)
        return node

    def put(self, socket: Any, value: Any) -> None:
        """Link a socket to an input, or set its value."""
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation: str, a: Any, b: Any = 0.0, c: Any = 0.0) -> Any:
        """The result of a math node."""
        return self.add("ShaderNodeMath", {0: a, 1: b, 2: c}, operation=operation).outputs[0]

    def attribute(self, name: str) -> Any:
        """A node that reads an attribute of the mesh."""
        return self.add("ShaderNodeAttribute", attribute_name=name, attribute_type="GEOMETRY")

    def mix(self, factor: Any, a: Any, b: Any) -> Any:
        """A color between two."""
        node = self.add("ShaderNodeMix", data_type="RGBA")
        self.put(next(s for s in node.inputs if s.name == "Factor" and s.type == "VALUE"), factor)
        self.put(next(s for s in node.inputs if s.name == "A" and s.type == "RGBA"), a)
        self.put(next(s for s in node.inputs if s.name == "B" and s.type == "RGBA"), b)
        return next(s for s in node.outputs if s.type == "RGBA")

    def ramp(self, value: Any, stops: Any, interpolation: str = "LINEAR") -> Any:
        """A color by a value. stops: positions and colors, ascending."""
        node = self.add("ShaderNodeValToRGB", {0: value})
        node.color_ramp.interpolation = interpolation
        for k, (position, color) in enumerate(stops):
            element = node.color_ramp.elements[k] if k < 2 else node.color_ramp.elements.new(position)
            element.position, element.color = position, (*color[:3], 1.0)
        return node.outputs[0]

    def position(self) -> Any:
        """In cm."""
        if not self.space.rest:
            return self.add("ShaderNodeTexCoord").outputs["Object"]
        at = self.attribute("rest").outputs["Vector"]
        scaled = self.add("ShaderNodeVectorMath", {0: at}, operation="SCALE")
        scaled.inputs["Scale"].default_value = 0.1
        return scaled.outputs[0]

    def noise(self, scale: float, detail: float = 2.0) -> Any:
        """Noise that rides on the tissue where its mesh has a rest; scale: per cm."""
        position = self.position()
        return self.add("ShaderNodeTexNoise", {"Vector": position, "Scale": scale, "Detail": detail}).outputs[0]

    def bump(self, height: Any, strength: float, distance: float) -> None:
        """Bend the normals by a height. distance: in cm."""
        node = self.add(
            "ShaderNodeBump", {"Height": height, "Strength": strength, "Distance": distance * self.space.units / 0.1}
        )
        self.put(self.bsdf.inputs["Normal"], node.outputs[0])

    def finish(self, color: Any, **inputs: Any) -> bpy.types.Material:
        """The material, with this base color and these inputs of the principled shader, `_` for a space."""
        self.put(self.bsdf.inputs["Base Color"], color)
        for name, value in inputs.items():
            self.put(self.bsdf.inputs[name.replace("_", " ")], value)
        if not isinstance(color, bpy.types.NodeSocket):
            self.material.diffuse_color = color
        return self.material
