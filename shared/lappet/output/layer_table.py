"""The layers of the tissue in the skin cache: what the depth and the column of a face mean."""

from __future__ import annotations

from typing import Any

import numpy as np

from lappet.anatomy.tissue_kind import KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.usd.stage import pxr

PATH = "/Procedure/Skin/Layers"


def write_layers(stage: Any, layers: TissueLayers) -> None:
    """Write the table of layers: for each its column, where it begins in mm below the skin, its kind and its material.

    Parameters
    ----------
    stage
        The stage of the cache.
    layers
        The layers.
    """
    usd = pxr()
    types = usd.Sdf.ValueTypeNames
    prim = usd.UsdGeom.Scope.Define(stage, PATH).GetPrim()

    def author(name: str, kind: Any, value: Any) -> None:
        prim.CreateAttribute(f"lappet:{name}", kind, custom=False, variability=usd.Sdf.VariabilityUniform).Set(value)

    author("column", types.IntArray, usd.Vt.IntArray.FromNumpy(np.asarray(layers.column, np.int32)))
    author("depthFrom", types.DoubleArray, usd.Vt.DoubleArray.FromNumpy(np.asarray(layers.depth_from, np.float64)))
    author("kind", types.TokenArray, [KINDS[kind] for kind in layers.kind])
    author("material", types.StringArray, list(layers.materials))
