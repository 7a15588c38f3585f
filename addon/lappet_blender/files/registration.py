"""Register import and export."""

from __future__ import annotations

import bpy

from .usd_operators import CLASSES, export_entries, import_entries

__all__ = ["CLASSES", "register", "unregister"]


def register() -> None:
    """Add the operators, the menu entries and the drop of files."""
    bpy.types.TOPBAR_MT_file_export.append(export_entries)
    bpy.types.TOPBAR_MT_file_import.append(import_entries)


def unregister() -> None:
    """Take them away."""
    bpy.types.TOPBAR_MT_file_import.remove(import_entries)
    bpy.types.TOPBAR_MT_file_export.remove(export_entries)
