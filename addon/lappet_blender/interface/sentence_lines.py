"""A sentence broken into lines, since a label of Blender has only one."""

from __future__ import annotations

import textwrap

import bpy

_PIXELS_PER_LETTER = 7.0
_WIDE = "\u2e80"  # from here on letters are twice as wide: those of Chinese


def draw_sentence(layout: bpy.types.UILayout, context: bpy.types.Context, sentence: str, icon: str = "NONE") -> None:
    """Labels that together say the sentence in the width of the region."""
    region = context.region
    preferences = context.preferences
    scale = (preferences.system.ui_scale if preferences is not None else 1.0) or 1.0  # 0 without a window
    width = region.width if region is not None else 300
    letters = max(20, int((width - 60 * scale) / (_PIXELS_PER_LETTER * scale)))
    sentence = bpy.app.translations.pgettext_iface(sentence)  # as a whole: its lines are no messages
    if any(letter >= _WIDE for letter in sentence):
        letters //= 2
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(sentence, letters)):
        first = icon if number == 0 else ("BLANK1" if icon != "NONE" else "NONE")
        column.label(text=line, icon=first)
