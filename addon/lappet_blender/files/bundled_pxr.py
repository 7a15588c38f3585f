"""Blender's own USD, loaded when it is first needed; the only way by which the extension comes to pxr."""

from __future__ import annotations

import bpy

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.usd.stage import Pxr, pxr


def bundled_pxr() -> Pxr:
    """USD's modules with Lappet's schemas registered.

    Raises RefusedError with a sentence where this Blender comes without USD; nothing but import and export needs it.
    """
    if hasattr(bpy.utils, "expose_bundled_modules"):
        bpy.utils.expose_bundled_modules()  # Blender as a module keeps them out of the way; the program has them there
    try:
        return pxr()
    except ImportError as cause:
        raise refused(ProblemCode.USD_NOT_IN_BLENDER, "", cause) from cause
