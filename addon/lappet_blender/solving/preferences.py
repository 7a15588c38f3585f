"""The preferences of the extension: which daemon solves, and which command line draws plates."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty

from ..interface.sentence_lines import draw_sentence
from ..interface.sidebar_panel import with_fields
from .chosen_daemon import ADDON, said

# What the extension adds to the user's Blender when it is asked to: (operator that adds, that removes, icon).
_HOME = (
    ("lappet.template_install", "lappet.template_remove", "FILE_NEW"),
    ("lappet.assets_install", "lappet.assets_remove", "ASSET_MANAGER"),
)


class LappetPreferences(bpy.types.AddonPreferences):
    """Which daemon solves"""

    bl_idname = ADDON

    daemon: StringProperty(
        name="Daemon",
        description="Address of a daemon that runs already, like tcp://solver.example.org:5570; empty to start one on "
        "this computer",
    )
    server_key: StringProperty(
        name="Server's Key",
        description="Public key of that daemon, or the file server.pub that holds it",
        subtype="FILE_PATH",
    )
    key: StringProperty(
        name="Your Key",
        description="File of your own key for that daemon, which lappet keys new writes",
        subtype="FILE_PATH",
    )

    command: StringProperty(
        name="Command Line",
        description="The installed program lappet, which draws plates and films; empty for the one on the search path",
        subtype="FILE_PATH",
    )

    offers_assets: BoolProperty(
        name="Offer Asset Library",
        description="Blender's asset browser shows Lappet's library while the extension is enabled",
        default=True,
        options={"HIDDEN"},
    )

    def draw(self, context: bpy.types.Context) -> None:
        layout = with_fields(self.layout)
        layout.prop(self, "daemon", placeholder="none: one is started here")
        column = layout.column()
        column.enabled = bool(self.daemon.strip())
        column.prop(self, "server_key")
        column.prop(self, "key")
        draw_sentence(layout, context, said(), "INFO")
        layout.prop(self, "command", placeholder="lappet")
        for add, remove, icon in _HOME:
            row = self.layout.row(align=True)
            row.operator(add, icon=icon)
            row.operator(remove, text="", icon="X")


CLASSES = (LappetPreferences,)
