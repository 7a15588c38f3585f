"""Show a prim of the skin cache at the frames of its epoch alone."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from lappet.usd.stage import pxr

_INSTANT = 1.0 / 1024.0  # of a frame


def show_at(prim: Any, own: Collection[float], times: Sequence[float]) -> None:
    """Show a prim at some frames and at no others.

    Parameters
    ----------
    prim
        The prim, of a schema of USD that can be transformed.
    own
        Time codes at which it is shown.
    times
        Time codes of all frames of the cache.
    """
    usd = pxr()
    tokens = usd.UsdGeom.Tokens
    visibility = prim.CreateVisibilityAttr()
    # Blender reads no animated visibility, but it reads an animated scale. Nothing is shown in part between two frames.
    scale = prim.AddScaleOp()
    before: bool | None = None
    for time in times:
        shown = time in own
        visibility.Set(tokens.inherited if shown else tokens.invisible, time)
        if before is not None and shown is not before:
            scale.Set(usd.Gf.Vec3f(float(before)), time - _INSTANT)
        scale.Set(usd.Gf.Vec3f(float(shown)), time)
        before = shown
