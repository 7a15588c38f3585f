"""Pictures on the skin of an exported USD file: the grid, the painted look, and the picture of the source mesh."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.export.skin_tile import SQUARES, write_skin_tile
from lappet.output.preview_materials import LOOK_ROOT
from lappet.usd.stage import pxr

_TILE = 5.0 * SQUARES  # mm
_PICTURES = (".png", ".jpg", ".jpeg")


@dataclass(frozen=True)
class SkinPicture:
    """A picture that a look of the skin shows.

    Parameters
    ----------
    look
        Name of the look.
    file
        Name of the picture's file, beside that of the stage.
    scale
        By what the texture coordinates of the skin are multiplied; (1, 1) for those of the mesh.
    """

    look: str
    file: str
    scale: tuple[float, float]


def check_picture(path: Path) -> None:
    """Refuse a picture that viewers do not read.

    Parameters
    ----------
    path
        The picture.

    Raises
    ------
    RefusedError
        If it is not there, or is no PNG or JPEG.
    """
    if not path.is_file():
        raise refused(ProblemCode.EXPORT_PICTURE, path, path.suffix, reason="there is no such file")
    head = path.read_bytes()[:8]
    if path.suffix.lower() not in _PICTURES or not (head.startswith((b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"))):
        raise refused(ProblemCode.EXPORT_PICTURE, path, path.suffix, reason="it is neither a PNG nor a JPEG")


def write_pictures(target: Path, grid_scale: NDArray[np.float64], source: Path | None) -> list[SkinPicture]:
    """Write the pictures beside a file.

    Parameters
    ----------
    target
        The file of the stage; the pictures have its name before theirs.
    grid_scale
        Millimetres on the skin in a unit of its texture coordinates, shape (2,).
    source
        The picture of the mesh that the tissue was made of; None where there is none.

    Returns
    -------
    list[SkinPicture]
        The pictures.

    Raises
    ------
    OSError
        If one cannot be written.
    """
    across, up = (float(each) / _TILE for each in grid_scale)
    found = []
    for look, grid in (("grid", True), ("painted", False)):
        name = f"{target.stem}_{look}.png"
        write_skin_tile(target.with_name(name), grid)
        found.append(SkinPicture(look, name, (across, up)))
    if source is not None:
        name = f"{target.stem}_photo{source.suffix.lower()}"
        shutil.copyfile(source, target.with_name(name))
        found.append(SkinPicture("photo", name, (1.0, 1.0)))
    return found


def picture_files(target: Path, pictures: Sequence[SkinPicture]) -> list[Path]:
    """Name the files of pictures.

    Parameters
    ----------
    target
        The file of the stage.
    pictures
        The pictures.

    Returns
    -------
    list[Path]
        Their files.
    """
    return [target.with_name(each.file) for each in pictures]


def show_picture(stage: Any, material: str, picture: SkinPicture, folder: str = ".") -> None:
    """Let a material show a picture, in the variant that is being edited.

    Parameters
    ----------
    stage
        The stage.
    material
        Name of the material.
    picture
        The picture.
    folder
        Where the picture lies from the layer that says so.
    """
    usd = pxr()
    shade, types, path = usd.UsdShade, usd.Sdf.ValueTypeNames, f"{LOOK_ROOT}/{material}"
    reader = shade.Shader.Define(stage, f"{path}/Coordinates")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", types.String).Set("st")
    place = reader.CreateOutput("result", types.Float2)
    if picture.scale != (1.0, 1.0):
        scaled = shade.Shader.Define(stage, f"{path}/Scale")
        scaled.CreateIdAttr("UsdTransform2d")
        scaled.CreateInput("in", types.Float2).ConnectToSource(place)
        scaled.CreateInput("scale", types.Float2).Set(usd.Gf.Vec2f(*picture.scale))
        place = scaled.CreateOutput("result", types.Float2)
    texture = shade.Shader.Define(stage, f"{path}/Picture")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", types.Asset).Set(usd.Sdf.AssetPath(f"{folder}/{picture.file}"))
    texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
    for axis in ("wrapS", "wrapT"):
        texture.CreateInput(axis, types.Token).Set("repeat")
    texture.CreateInput("st", types.Float2).ConnectToSource(place)
    surface = shade.Shader(stage.GetPrimAtPath(f"{path}/Surface"))
    surface.CreateInput("diffuseColor", types.Color3f).ConnectToSource(texture.CreateOutput("rgb", types.Float3))
