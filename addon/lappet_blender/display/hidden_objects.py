"""Hide the user's own objects (the tissue, bones) while the display stands in for them, and bring them back."""

from __future__ import annotations

import bpy

_BEFORE = "lappet_hidden"


def hide(each: bpy.types.Object) -> None:
    """Hide an object in viewports and renders, remembering how it was; one that cannot be changed (linked) stays."""
    if _BEFORE in each or each.library is not None:
        return
    each[_BEFORE] = [int(each.hide_viewport), int(each.hide_render)]
    each.hide_viewport = each.hide_render = True


def bring_back(each: bpy.types.Object) -> None:
    """Undo `hide`; an object that was not hidden so stays as it is."""
    if _BEFORE not in each or each.library is not None:
        return
    viewport, render = each[_BEFORE]
    each.hide_viewport, each.hide_render = bool(viewport), bool(render)
    del each[_BEFORE]
