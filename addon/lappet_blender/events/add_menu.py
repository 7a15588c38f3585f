"""The menu Lappet in Blender's menu Add."""

import bpy

from ..tissue.model_operators import VIEW3D_MT_lappet_model
from .flap_operators import VIEW3D_MT_lappet_flap


class VIEW3D_MT_lappet_add(bpy.types.Menu):
    bl_label = "Lappet"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.menu(VIEW3D_MT_lappet_model.__name__)
        self.layout.menu(VIEW3D_MT_lappet_flap.__name__)


def _draw(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.menu(VIEW3D_MT_lappet_add.__name__)


CLASSES = (VIEW3D_MT_lappet_add,)


def register() -> None:
    """Hang the menu into Add."""
    bpy.types.VIEW3D_MT_add.append(_draw)


def unregister() -> None:
    """Take it away."""
    bpy.types.VIEW3D_MT_add.remove(_draw)
