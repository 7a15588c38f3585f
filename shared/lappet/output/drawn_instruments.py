"""Threads, knots and skin hooks in the skin cache as they are seen: tubes along the lines that pictures draw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import surgical_field
from lappet.drawing.hook_steel import HookSteel
from lappet.drawing.skin_source import SkinSource
from lappet.drawing.surface_look import STEEL_LOOK, THREAD_LOOK, SurfaceLook
from lappet.drawing.suture_thread import SutureThread, buried_sutures
from lappet.output.preview_materials import SKIN_ROOT, bind
from lappet.output.shown_frames import show_at
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

ROOT = f"{SKIN_ROOT}/Instruments"
# Lines of a frame and their radii, both in mm: one for a line, or one for each of its points.
Tubes = tuple[Sequence[NDArray[np.float64]], Sequence[float | NDArray[np.float64]]]


def write_instruments(stage: Any, source: SkinSource) -> None:
    """Write threads and hooks as curves with widths, shown while they act; variants of `instruments` hide them.

    What lies in the depth is not drawn. The number of curves changes in time, so that what is not placed yet is
    nowhere.

    Parameters
    ----------
    stage
        The stage of the cache.
    source
        The same, to be read.
    """
    field = surgical_field(source, source.frames)
    axes = np.stack([field.right, field.up, field.normal])
    scale = field.stitch_scale
    threads = SutureThread(source, axes[0] + 0.6 * axes[1], scale, buried_sutures(source))
    hooks = HookSteel(source, axes, field.center, scale)
    drawn = [
        _write(stage, source, "Threads", "Threads and knots", THREAD_LOOK, threads.tubes),
        _write(stage, source, "SkinHooks", "Skin hooks", STEEL_LOOK, hooks.tubes),
    ]
    if any(drawn):
        add_variants(stage)


def _write(
    stage: Any, source: SkinSource, name: str, title: str, look: SurfaceLook, tubes: Callable[[float], Tubes]
) -> bool:
    """Write the curves of one kind; nothing where none is ever drawn."""
    frames = {time: tubes(time) for time in source.frames}
    shown = {time: each for time, each in frames.items() if each[0]}
    if not shown:
        return False
    usd = pxr()
    tokens = usd.UsdGeom.Tokens
    usd.UsdGeom.Xform.Define(stage, ROOT)
    curves = usd.UsdGeom.BasisCurves.Define(stage, f"{ROOT}/{name}")
    curves.GetPrim().SetDisplayName(title)
    curves.CreateTypeAttr(tokens.linear)
    curves.SetWidthsInterpolation(tokens.vertex)
    primvars = usd.UsdGeom.PrimvarsAPI(curves)
    color = primvars.CreatePrimvar("displayColor", usd.Sdf.ValueTypeNames.Color3fArray, tokens.constant)
    color.Set([look.color])
    bind(stage, curves, look)
    for time, (lines, radii) in shown.items():
        points = np.concatenate(lines)
        widths = np.concatenate(
            [2.0 * np.broadcast_to(radius, len(line)) for line, radius in zip(lines, radii, strict=True)]
        )
        curves.CreatePointsAttr().Set(vectors(points), time)
        curves.CreateCurveVertexCountsAttr().Set(usd.Vt.IntArray([len(line) for line in lines]), time)
        curves.CreateWidthsAttr().Set(usd.Vt.FloatArray.FromNumpy(widths.astype(np.float32)), time)
        margin = 0.5 * float(widths.max())
        box = np.stack([points.min(axis=0) - margin, points.max(axis=0) + margin])
        curves.CreateExtentAttr().Set(vectors(box), time)
    show_at(curves, set(shown), source.frames)
    return True


def add_variants(stage: Any) -> None:
    """Write the variants of `instruments`, which show or hide them.

    Parameters
    ----------
    stage
        The stage, with its instruments.
    """
    usd = pxr()
    variants = stage.GetPrimAtPath(SKIN_ROOT).GetVariantSets().AddVariantSet("instruments")
    for name in ("shown", "hidden"):
        variants.AddVariant(name)
    variants.SetVariantSelection("hidden")
    with variants.GetVariantEditContext():
        usd.UsdGeom.Imageable(stage.OverridePrim(ROOT)).CreateVisibilityAttr(usd.UsdGeom.Tokens.invisible)
    variants.SetVariantSelection("shown")
