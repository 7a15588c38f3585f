"""The materials of the skin cache, UsdPreviewSurface of one color each, and the looks that a reader may choose.

Colors stand in the variants of `look` alone: a value outside of them would be the stronger one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.quantity_scale import frame_peak, full_value, ramp_linear
from lappet.drawing.surface_look import PLAIN_COLOR, SKIN_LOOK, SurfaceLook
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

SKIN_ROOT = "/Procedure/Skin"
LOOK_ROOT = f"{SKIN_ROOT}/Look"
LOOKS = ("natural", "plain", "strain")
_SHADES = 64  # colors of the strain's scale
_OPAQUE = {"metallic": 0.0, "opacity": 1.0, "ior": 1.45}


def define_material(stage: Any, look: SurfaceLook) -> Any:
    """Define a material, if it is not there yet; `write_look_variants` moves its color into the variants.

    Parameters
    ----------
    stage
        The stage of the cache.
    look
        What it looks like.

    Returns
    -------
    UsdShade.Material
        The material.
    """
    usd = pxr()
    shade, types = usd.UsdShade, usd.Sdf.ValueTypeNames
    path = f"{LOOK_ROOT}/{look.name}"
    known = stage.GetPrimAtPath(path)
    if known:
        return shade.Material(known)
    material = shade.Material.Define(stage, path)
    material.GetPrim().SetDisplayName(look.title)
    shader = shade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    for name, value in {**_OPAQUE, "metallic": look.metallic, "roughness": look.roughness}.items():
        shader.CreateInput(name, types.Float).Set(value)
    shader.CreateInput("diffuseColor", types.Color3f).Set(usd.Gf.Vec3f(*look.color))
    surface = shader.CreateOutput("surface", types.Token)
    material.CreateSurfaceOutput().ConnectToSource(surface)
    return material


def bind(stage: Any, prim: Any, look: SurfaceLook) -> None:
    """Bind a material to a prim.

    Parameters
    ----------
    stage
        The stage of the cache.
    prim
        The prim.
    look
        What it looks like.
    """
    material = define_material(stage, look)
    pxr().UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def bind_faces(stage: Any, mesh: Any, looks: Sequence[SurfaceLook], index: NDArray[np.integer]) -> None:
    """Bind materials to the faces of a mesh, by a partition of them into subsets of the family `materialBind`.

    Parameters
    ----------
    stage
        The stage of the cache.
    mesh
        The mesh.
    looks
        What faces look like.
    index
        For each face the index of its look, shape (m,).
    """
    usd = pxr()
    shade, tokens = usd.UsdShade, usd.UsdGeom.Tokens
    binding = shade.MaterialBindingAPI
    for k, look in enumerate(looks):
        faces = usd.Vt.IntArray.FromNumpy(np.flatnonzero(index == k).astype(np.int32))
        subset = usd.UsdGeom.Subset.CreateGeomSubset(
            mesh, f"look{look.name}", tokens.face, faces, shade.Tokens.materialBind, tokens.partition
        )
        binding.Apply(subset.GetPrim()).Bind(define_material(stage, look))
    binding.Apply(mesh.GetPrim())
    # What a reader without subsets shows of the whole mesh.
    binding(mesh.GetPrim()).Bind(define_material(stage, SKIN_LOOK))


def read_color(stage: Any, look: SurfaceLook, primvar: str) -> None:
    """Let a material take its color from a primvar of what it is bound to, which is stronger than its own.

    Parameters
    ----------
    stage
        The stage of the cache.
    look
        The material's look; it is defined already.
    primvar
        Name of the primvar.
    """
    usd = pxr()
    types, path = usd.Sdf.ValueTypeNames, f"{LOOK_ROOT}/{look.name}"
    reader = usd.UsdShade.Shader.Define(stage, f"{path}/Color")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", types.String).Set(primvar)
    reader.CreateInput("fallback", types.Float3).Set(usd.Gf.Vec3f(*look.color))
    result = reader.CreateOutput("result", types.Float3)
    _color(stage, look.name).ConnectToSource(result)


def _color(stage: Any, name: str) -> Any:
    """The input of a material's surface that says its color."""
    return pxr().UsdShade.Shader(stage.GetPrimAtPath(f"{LOOK_ROOT}/{name}/Surface")).GetInput("diffuseColor")


def write_look_variants(
    stage: Any,
    tissue: Iterable[str],
    strain: Mapping[str, Mapping[float, NDArray[np.float32]]],
    pictures: Mapping[str, Callable[[str], None]] = MappingProxyType({}),
    strain_full: float | None = None,
) -> None:
    """Write the looks: `natural`, `plain` (tissue all gray) and, where strain is known, `strain`, colored by it.

    Where there are pictures of the skin, they are looks in place of `natural`; the first is chosen.

    Parameters
    ----------
    stage
        The stage of the cache, with all its materials.
    tissue
        Names of the materials of tissue.
    strain
        Strain at the points of each epoch's prim, shape (n,), by the prim's name and by time code; nothing where it
        is not known.
    pictures
        For the name of a look what lets a material show its picture, in the variant that is being edited.
    strain_full
        Strain at the top of its colors, where it is known; otherwise it is found from `strain`.
    """
    usd = pxr()
    gray = set(tissue)
    names = [prim.GetName() for prim in stage.GetPrimAtPath(LOOK_ROOT).GetChildren()]
    colors = {name: _color(stage, name).Get() for name in names}
    for name in names:
        _color(stage, name).GetAttr().Clear()
    variants = stage.GetPrimAtPath(SKIN_ROOT).GetVariantSets().AddVariantSet("look")
    looks = (*(pictures or LOOKS[:1]), *(LOOKS[1:] if strain else LOOKS[1:2]))
    for name in looks:
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            for material, color in colors.items():
                own = usd.Gf.Vec3f(*PLAIN_COLOR) if name == "plain" and material in gray else color
                _color(stage, material).Set(own)
            if name in pictures:
                pictures[name](SKIN_LOOK.name)
            if name == "strain":
                _color_by_strain(stage, strain, full_strain(strain) if strain_full is None else strain_full)
    variants.SetVariantSelection(looks[0])


def full_strain(strain: Mapping[str, Mapping[float, NDArray[np.float32]]]) -> float:
    """Find the strain at the top of its colors.

    Parameters
    ----------
    strain
        As of `write_look_variants`.

    Returns
    -------
    float
        The strain.
    """
    return full_value(max(frame_peak(values) for own in strain.values() for values in own.values()))


def shade_indices(strain: NDArray[np.float32], full: float) -> Any:
    """Choose the shade of each point by its strain.

    Parameters
    ----------
    strain
        Strain at the points, shape (n,).
    full
        Strain at the top of its colors.

    Returns
    -------
    Vt.IntArray
        Indices of the shades, n of them.
    """
    shade = np.clip(np.nan_to_num(strain) / full * _SHADES, 0, _SHADES - 1).astype(np.int32)
    return pxr().Vt.IntArray.FromNumpy(shade)


def _color_by_strain(stage: Any, strain: Mapping[str, Mapping[float, NDArray[np.float32]]], full: float) -> None:
    """Give the skin the colors of its strain: a scale of few colors, and for each frame the indices of its points."""
    usd = pxr()
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    palette = vectors(ramp_linear((np.arange(_SHADES) + 0.5) / _SHADES))
    for name, frames in strain.items():
        mesh = stage.GetPrimAtPath(f"{SKIN_ROOT}/{name}")
        color = usd.UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("strainColor", types.Color3fArray, tokens.vertex)
        color.Set(palette)
        color.CreateIndicesAttr()
        for time, values in frames.items():
            color.SetIndices(shade_indices(values, full), time)
    read_color(stage, SKIN_LOOK, "strainColor")
    stage.GetPrimAtPath(SKIN_ROOT).SetCustomDataByKey("lappet:strainFullScale", full)
