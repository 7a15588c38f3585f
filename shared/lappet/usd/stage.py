"""Procedures as USD files. The only module that imports pxr, and it does so when first asked.

`pxr()` gives the other modules USD; before it hands it out it registers Lappet's codeless schemas, since USD reads them
once, at the first use of its schema registry. `usd_reader` and `usd_writer` do the work on open stages.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import tempfile
import threading
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from lappet.core.durable import replace_durably
from lappet.core.output_place import check_place
from lappet.core.problem import Problem, ProblemsError, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.regular_file import refuse_irregular
from lappet.procedure import Procedure
from lappet.usd import reader as usd_reader
from lappet.usd import writer as usd_writer
from lappet.usd.layer_files import LayerFiles
from lappet.usd.procedure_file import ProcedureFile
from lappet.usd.stage_procedure import StageProcedure

SCHEMA = Path(__file__).with_name("schema")
SUFFIXES = (".usda", ".usdc", ".usd")


class Pxr(SimpleNamespace):
    """The USD modules that Lappet uses."""

    Gf: Any
    Kind: Any
    Plug: Any
    Sdf: Any
    Tf: Any
    Usd: Any
    UsdGeom: Any
    UsdLux: Any
    UsdShade: Any
    UsdSkel: Any
    UsdUtils: Any
    Vt: Any


class UsdMissingError(ProblemsError, ModuleNotFoundError):
    """USD's Python modules cannot be imported."""


@contextlib.contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Let Ctrl-C wait: modules that USD's own loader imports would swallow it, and stay half loaded."""
    arrived: list[int] = []
    ours = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGINT) if ours else None
    if before is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, lambda number, _: arrived.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if arrived:
        raise KeyboardInterrupt


@lru_cache(maxsize=1)
def pxr() -> Pxr:
    """Load USD's Python modules and register Lappet's schemas.

    Returns
    -------
    Pxr
        The modules.

    Raises
    ------
    UsdMissingError
        If USD is missing; the message has the line that installs it.
    """
    try:
        with _interrupts_wait():
            from pxr import Gf, Kind, Plug, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel, UsdUtils, Vt
    except ImportError as cause:
        raise UsdMissingError((problem(ProblemCode.USD_MISSING, "", cause),)) from cause
    Plug.Registry().RegisterPlugins(str(SCHEMA.resolve()))
    return Pxr(
        Gf=Gf,
        Kind=Kind,
        Plug=Plug,
        Sdf=Sdf,
        Tf=Tf,
        Usd=Usd,
        UsdGeom=UsdGeom,
        UsdLux=UsdLux,
        UsdShade=UsdShade,
        UsdSkel=UsdSkel,
        UsdUtils=UsdUtils,
        Vt=Vt,
    )


def open_stage(path: str | os.PathLike[str], limits: ReadLimits = DEFAULT_LIMITS) -> Any:
    """Open the stage in a file, as it is on disk now, in this process: for files that are trusted, or by a child.

    Parameters
    ----------
    path
        A .usda, .usdc, .usd or .usdz file.
    limits
        How large files may be, and whether those outside the file's folder are followed. Memory and time are not
        limited here.

    Returns
    -------
    Any
        The stage.

    Raises
    ------
    RefusedError
        If the file is missing, is no regular file, cannot be read as USD, or refers to files that are missing or may
        not be read.
    """
    file = Path(path)
    if not file.exists():
        raise refused(ProblemCode.USD_NO_FILE, file, "no such file")
    if file.is_dir():
        raise refused(ProblemCode.USD_IS_FOLDER, file, "a folder")
    refuse_irregular(file, limits)
    usd = pxr()
    files = LayerFiles(usd, file.resolve(), limits)
    # What USD would print while it opens the stage is collected, and dropped: it comes back below as errors.
    quiet = usd.UsdUtils.CoalescingDiagnosticDelegate()
    try:
        known = usd.Sdf.Layer.Find(str(file.resolve()))
        if known is not None and not known.dirty:
            known.Reload()
        layer = usd.Sdf.Layer.FindOrOpen(str(file.resolve()))
        held = files.open_all(layer) if layer else []
        stage = usd.Usd.Stage.Open(layer) if layer else None
        del held
    except usd.Tf.ErrorException as cause:
        raise refused(ProblemCode.USD_UNREADABLE, file, file.suffix, reason=_reason(cause)) from cause
    finally:
        del quiet
    if stage is None:
        raise refused(ProblemCode.USD_UNKNOWN_KIND, file, file.suffix)
    errors = [str(error) for error in stage.GetCompositionErrors()]
    if errors:
        code = ProblemCode.USD_COMPOSITION
        raise RefusedError([problem(code, file, "composition", reason=_one_line(error)) for error in errors])
    files.refuse_used(stage)
    return stage


def check_usd_place(path: str | os.PathLike[str]) -> Path:
    """Refuse a name that no layer can be written to, before the work that is to go into it.

    Parameters
    ----------
    path
        The file to write.

    Returns
    -------
    Path
        The file, absolute.

    Raises
    ------
    RefusedError
        If its suffix is none of USD's, its folder is missing or cannot be written, or a folder has its name.
    """
    file = Path(path).resolve()
    if file.suffix not in SUFFIXES:
        raise refused(ProblemCode.USD_SUFFIX, file, file.suffix, known=", ".join(SUFFIXES))
    if not file.parent.is_dir():
        raise refused(ProblemCode.FILE_NO_FOLDER, file, file.parent)
    check_place(file)
    return file


def save_layer(layer: Any, path: str | os.PathLike[str]) -> None:
    """Write a layer to a file atomically: readers see the old content or the new, never a part.

    Parameters
    ----------
    layer
        The layer.
    path
        The file; its suffix (.usda, .usdc or .usd) chooses the format.

    Raises
    ------
    RefusedError
        If the suffix is another one, or the folder is missing or cannot be written.
    OSError
        If the file system refuses.
    """
    file = check_usd_place(path)
    with tempfile.TemporaryDirectory(prefix=f".{file.stem}-", dir=file.parent) as folder:
        fresh = Path(folder) / file.name
        quiet = pxr().UsdUtils.CoalescingDiagnosticDelegate()
        try:
            written = layer.Export(str(fresh))
        except pxr().Tf.ErrorException as cause:
            raise refused(ProblemCode.FILE_NOT_WRITTEN, file, _reason(cause), folder=file.parent) from cause
        finally:
            del quiet
        if not written:
            raise refused(ProblemCode.FILE_NOT_WRITTEN, file, "USD gives no reason", folder=file.parent)
        replace_durably(fresh, file)
    known = pxr().Sdf.Layer.Find(str(file))
    if known is not None:
        known.Reload(True)


def read_procedure(
    path: str | os.PathLike[str], notes: list[Problem] | None = None, limits: ReadLimits = DEFAULT_LIMITS
) -> Procedure:
    """Read the procedure in a USD file, in mm and Z up whatever the stage's own units and axes.

    A child process reads it, with limits on memory, time and size.

    Parameters
    ----------
    path
        A .usda, .usdc or .usd file.
    notes
        Gets a note of everything that was converted or left aside.
    limits
        What reading may take.

    Returns
    -------
    Procedure
        The procedure. It may still be wrong; see `lappet.check`.

    Raises
    ------
    RefusedError
        If something kept the file from being read; holds every such problem.
    """
    with ProcedureFile(path, limits) as file:
        return file.procedure(notes)


def read_here(path: str | os.PathLike[str], limits: ReadLimits = DEFAULT_LIMITS) -> StageProcedure:
    """Read a USD file as far as possible in this process: for files that are trusted, or by a child.

    Parameters
    ----------
    path
        A .usda, .usdc or .usd file.
    limits
        What `open_stage` may take.

    Returns
    -------
    StageProcedure
        What was read.

    Raises
    ------
    RefusedError
        If the file cannot be opened, or is damaged.
    """
    notes: list[Problem] = []
    stage = open_stage(path, limits)
    try:
        procedure, problems = usd_reader.read_what_can_be(stage, pxr(), notes)
    except pxr().Tf.ErrorException as cause:
        raise refused(ProblemCode.USD_UNREADABLE, path, Path(path).suffix, reason=_reason(cause)) from cause
    return StageProcedure(procedure, tuple(problems), tuple(notes))


def write_procedure(procedure: Procedure, path: str | os.PathLike[str]) -> None:
    """Write a procedure to a USD file, atomically.

    Reading it back gives an equal procedure. The file is replaced: prims and attributes of other tools are not kept, so
    put cameras and lights into a layer of their own that has this file as a sublayer.

    Parameters
    ----------
    procedure
        The procedure.
    path
        The file; its suffix (.usda, .usdc or .usd) chooses the format.

    Raises
    ------
    RefusedError
        If a name cannot be the name of a prim or is used twice.
    """
    save_layer(usd_writer.layer(procedure, pxr()), path)


def _one_line(text: object) -> str:
    return " ".join(str(text).split()).rstrip(".")


def _reason(cause: BaseException) -> str:
    """The first thing that USD complained of, without the place in USD's own source that it prefixes."""
    said = re.search(r": '(.*?)'\s*(?:Error in '|$)", str(cause), re.DOTALL)
    return _one_line(said[1] if said else cause) or type(cause).__name__
