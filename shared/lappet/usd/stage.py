"""Procedures as USD files. The only module that imports pxr, and it does so when first asked.

`pxr()` gives the other modules USD; before it hands it out it registers Lappet's codeless schemas, since USD reads them
once, at the first use of its schema registry. `usd_reader` and `usd_writer` do the work on open stages.
"""

from __future__ import annotations

import os
import re
import tempfile
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Procedure
from lappet.usd import reader as usd_reader
from lappet.usd import writer as usd_writer

SCHEMA = Path(__file__).with_name("schema")
SUFFIXES = (".usda", ".usdc", ".usd")


class Pxr(SimpleNamespace):
    """The USD modules that Lappet uses: Gf, Plug, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdUtils, Vt."""

    Gf: Any
    Plug: Any
    Sdf: Any
    Tf: Any
    Usd: Any
    UsdGeom: Any
    UsdShade: Any
    UsdUtils: Any
    Vt: Any


@lru_cache(maxsize=1)
def pxr() -> Pxr:
    """USD's Python modules, with Lappet's schemas registered.

    Raises ModuleNotFoundError, with the line that installs it, where USD is missing.
    """
    try:
        from pxr import Gf, Plug, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdUtils, Vt
    except ImportError as cause:
        raise ModuleNotFoundError(
            f"Procedures are USD files, and USD's Python modules cannot be imported ({cause}). "
            "In Blender they come with Blender 4.5 or newer from blender.org; elsewhere install them with: pip install "
            "usd-core.",
            name="pxr",
        ) from cause
    Plug.Registry().RegisterPlugins(str(SCHEMA.resolve()))
    return Pxr(Gf=Gf, Plug=Plug, Sdf=Sdf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdShade=UsdShade, UsdUtils=UsdUtils, Vt=Vt)


def open_stage(path: str | os.PathLike[str]) -> Any:
    """The stage in a file, as it is on disk now.

    Raises RefusedError where the file is missing, cannot be read as USD, or refers to files that are missing.
    """
    file = Path(path)
    if not file.exists():
        raise _refused(
            file, "no such file", f"The file {file} does not exist.", "Give the path of a .usda or .usdc file."
        )
    if file.is_dir():
        raise _refused(file, "a folder", f"The path {file} is a folder.", "Give the path of a .usda or .usdc file.")
    usd = pxr()
    # What USD would print while it opens the stage is collected, and dropped: it comes back below as errors.
    quiet = usd.UsdUtils.CoalescingDiagnosticDelegate()
    try:
        known = usd.Sdf.Layer.Find(str(file.resolve()))
        if known is not None and not known.dirty:
            known.Reload()
        layer = usd.Sdf.Layer.FindOrOpen(str(file.resolve()))
        stage = usd.Usd.Stage.Open(layer) if layer else None
    except usd.Tf.ErrorException as cause:
        remedy = "Give a .usda or .usdc file; a mesh file becomes a procedure with: lappet new MESH -o P.usda."
        sentence = f"The file {file} cannot be read as USD: {_reason(cause)}."
        raise _refused(file, file.suffix, sentence, remedy) from cause
    finally:
        del quiet
    if stage is None:
        remedy = "Give a .usda or .usdc file; a mesh file becomes a procedure with: lappet new MESH -o P.usda."
        raise _refused(file, file.suffix, f"The file {file} is of a kind that USD does not read.", remedy)
    errors = [str(error) for error in stage.GetCompositionErrors()]
    if errors:
        remedy = "Put the missing file back, or remove what refers to it."
        raise RefusedError(
            [
                Problem(
                    ProblemCode.UNSORTED,
                    str(file),
                    "composition",
                    f"The file {file} does not compose: {_one_line(error)}.",
                    remedy,
                )
                for error in errors
            ]
        )
    return stage


def save_layer(layer: Any, path: str | os.PathLike[str]) -> None:
    """Writes a layer to a file atomically: whoever reads the file sees the old content or the new, never a part.

    The suffix (.usda, .usdc or .usd) chooses the format. Raises RefusedError for another suffix or a missing folder,
    OSError where the file system refuses.
    """
    file = Path(path).resolve()
    if file.suffix not in SUFFIXES:
        sentence = f"{file.name} does not end in a USD suffix."
        raise _refused(file, file.suffix, sentence, f"Use one of {', '.join(SUFFIXES)}.")
    if not file.parent.is_dir():
        raise _refused(file, "no such folder", f"The folder {file.parent} does not exist.", "Make the folder first.")
    with tempfile.TemporaryDirectory(prefix=f".{file.stem}-", dir=file.parent) as folder:
        fresh = Path(folder) / file.name
        quiet = pxr().UsdUtils.CoalescingDiagnosticDelegate()
        try:
            written = layer.Export(str(fresh))
        except pxr().Tf.ErrorException as cause:
            raise OSError(f"USD could not write {file}: {_reason(cause)}.") from cause
        finally:
            del quiet
        if not written:
            raise OSError(f"USD could not write {file}; look for space and permissions in {file.parent}.")
        fresh.replace(file)
    known = pxr().Sdf.Layer.Find(str(file))
    if known is not None:
        known.Reload(True)


def read_procedure(path: str | os.PathLike[str], notes: list[str] | None = None) -> Procedure:
    """The procedure in a USD file, in mm and Z up whatever the stage's own units and axes.

    notes: gets a sentence for everything that was converted or left aside. Raises RefusedError with every problem
    that kept the file from being read; what was read may still be wrong, see `lappet.checks.validation.check`.
    """
    stage = open_stage(path)
    return usd_reader.read(stage, pxr(), notes if notes is not None else [])


def read_what_can_be(
    path: str | os.PathLike[str], notes: list[str] | None = None
) -> tuple[Procedure | None, list[Problem]]:
    """The procedure in a USD file as far as it can be read, and every problem that kept something from being read.

    Where `read_procedure` raises, this goes on, so that `lappet check` can name everything at once; only a file that
    cannot be opened raises RefusedError. Without a tissue there is no procedure.
    """
    stage = open_stage(path)
    return usd_reader.read_what_can_be(stage, pxr(), notes if notes is not None else [])


def write_procedure(procedure: Procedure, path: str | os.PathLike[str]) -> None:
    """Writes a procedure to a .usda or .usdc file, atomically.

    Reading it back gives an equal procedure. The file is replaced: prims and attributes of other tools are not kept, so
    put cameras and lights into a layer of their own that has this file as a sublayer. Raises RefusedError where a
    name cannot be the name of a prim or is used twice.
    """
    save_layer(usd_writer.layer(procedure, pxr()), path)


def _refused(file: Path, value: str, sentence: str, remedy: str) -> RefusedError:
    return RefusedError([Problem(ProblemCode.UNSORTED, str(file), value, sentence, remedy)])


def _one_line(text: object) -> str:
    return " ".join(str(text).split()).rstrip(".")


def _reason(cause: BaseException) -> str:
    """The first thing that USD complained of, without the place in USD's own source that it prefixes."""
    said = re.search(r": '(.*?)'\s*(?:Error in '|$)", str(cause), re.DOTALL)
    return _one_line(said[1] if said else cause) or type(cause).__name__
