"""Sentences with values in the interface's language: the pattern is translated, then the values are filled in."""

from __future__ import annotations

import bpy


def said(pattern: str, **values: object) -> str:
    """The pattern, a message of the dictionary with {names} of values, in the language that Blender's interface has."""
    return str(bpy.app.translations.pgettext_iface(pattern)).format(**values)
