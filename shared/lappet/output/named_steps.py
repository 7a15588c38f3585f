"""The steps of the operation in the skin cache: for each its name and its range of time codes."""

from __future__ import annotations

from typing import Any

from lappet.drawing.figure_steps import Step, hook_height, story_steps
from lappet.drawing.framing import surgical_field
from lappet.drawing.skin_source import SkinSource
from lappet.drawing.suture_thread import buried_sutures
from lappet.output.preview_materials import SKIN_ROOT
from lappet.usd.stage import pxr

ROOT = f"{SKIN_ROOT}/Steps"


def operation_steps(source: SkinSource) -> list[Step]:
    """Choose the steps of a solved procedure.

    Parameters
    ----------
    source
        The procedure.

    Returns
    -------
    list[Step]
        The steps, each with the frame at which it is done.
    """
    normal = surgical_field(source, (source.frames[0],)).normal
    return story_steps(source.events, source.frames, hook_height(source, normal), len(buried_sutures(source)))


def write_steps(stage: Any, source: SkinSource) -> None:
    """Write a prim for each step: it begins where the one before it is done.

    Parameters
    ----------
    stage
        The stage of the cache.
    source
        The same, to be read.
    """
    usd = pxr()
    types, uniform = usd.Sdf.ValueTypeNames, usd.Sdf.VariabilityUniform
    usd.UsdGeom.Scope.Define(stage, ROOT)
    begin = source.frames[0]
    for number, step in enumerate(operation_steps(source), start=1):
        prim = usd.UsdGeom.Scope.Define(stage, f"{ROOT}/step_{number:02d}").GetPrim()
        prim.SetDisplayName(step.caption)
        for name, kind, value in (
            ("start", types.Double, begin),
            ("end", types.Double, step.frame),
            ("caption", types.String, step.caption),
            ("detail", types.String, step.detail),
        ):
            prim.CreateAttribute(f"lappet:{name}", kind, custom=False, variability=uniform).Set(value)
        begin = step.frame
