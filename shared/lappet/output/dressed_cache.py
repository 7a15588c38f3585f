"""What makes the skin cache look right in other programs: threads and hooks, steps, looks, and what stays hidden."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.solved_frame import SolvedFrame
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.drawing.surface_look import BED_LOOK, BONE_LOOK, LANDMARK_LOOK, MUCOSA_LOOK, SKIN_LOOK, VESSEL_LOOK
from lappet.output.drawn_bed import write_bed
from lappet.output.drawn_instruments import write_instruments
from lappet.output.named_steps import write_steps
from lappet.output.preview_materials import LOOK_ROOT, SKIN_ROOT, bind, define_material, read_color, write_look_variants
from lappet.procedure import Procedure
from lappet.procedure.prim_paths import ANATOMY, BONE, FLAPS, MATERIALS, PLATES, SCENERY, SKIN_LINES, TIMELINE, TISSUE
from lappet.program.program import Program
from lappet.usd.stage import pxr
from lappet.usd.writer import layer as procedure_layer

# Drawings of what is planned, and tables: of no use to a viewer, whatever it thinks of visibility or of purpose.
PLANS = (TISSUE, TIMELINE, SKIN_LINES, ANATOMY, FLAPS, PLATES, MATERIALS)
TABLES = ("Layers", "Reactions", "Sections", "Steps")
MEASURED = ("Sutures", "Threads", "Hooks", "Seams")


def dress(layer: Any, path: Path, procedure: Procedure, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """Add to a skin cache what other programs show.

    Parameters
    ----------
    layer
        The cache's layer, with everything else.
    path
        The procedure's file, by whose name it is shown; the cache's own name is not in it.
    procedure
        The procedure.
    program
        What the solver was told.
    frames
        The solved frames.
    """
    usd = pxr()
    below = procedure_layer(procedure, usd)
    stage = usd.Usd.Stage.Open(layer)
    try:
        source = SkinCache(path, _over(stage, below))
        write_bed(stage, source)
        write_instruments(stage, source)
        write_steps(stage, source)
    except FigureError:
        pass  # tissue without skin to speak of: its cache does without drawings
    _bind_others(stage, procedure)
    tissue = [prim.GetName() for prim in stage.GetPrimAtPath(LOOK_ROOT).GetChildren() if is_tissue(prim.GetName())]
    write_look_variants(stage, tissue, _strain(program, frames))
    _hide(stage, below)
    _name(stage, path.stem)


def _over(stage: Any, below: Any) -> Any:
    """A stage of the cache over its procedure, in memory."""
    usd = pxr()
    root = usd.Sdf.Layer.CreateAnonymous(".usda")
    cache = stage.GetRootLayer()
    root.subLayerPaths = [cache.identifier, below.identifier]
    both = usd.Usd.Stage.Open(root)
    usd.UsdGeom.SetStageMetersPerUnit(both, usd.UsdGeom.GetStageMetersPerUnit(stage))
    both.SetTimeCodesPerSecond(stage.GetTimeCodesPerSecond())
    return both


def is_tissue(name: str) -> bool:
    """Tell materials of tissue from those of instruments and marks.

    Parameters
    ----------
    name
        Name of the material.

    Returns
    -------
    bool
        Whether it is one of tissue.
    """
    return name in (SKIN_LOOK.name, MUCOSA_LOOK.name, BED_LOOK.name) or name.startswith(("Cut", "Rim"))


def _bind_others(stage: Any, procedure: Procedure) -> None:
    define_material(stage, SKIN_LOOK)
    marks = stage.GetPrimAtPath(f"{SKIN_ROOT}/Landmarks")
    if marks:
        bind(stage, marks, LANDMARK_LOOK)
    vessels = stage.GetPrimAtPath(f"{SKIN_ROOT}/Vessels")
    if vessels:
        bind(stage, vessels, VESSEL_LOOK)
        read_color(stage, VESSEL_LOOK, "displayColor")
    if procedure.bones:
        bind(stage, stage.OverridePrim(BONE), BONE_LOOK)
    if procedure.scenery:
        bind(stage, stage.OverridePrim(SCENERY), SKIN_LOOK)


def _strain(program: Program, frames: Sequence[SolvedFrame]) -> dict[str, dict[float, NDArray[np.float32]]]:
    """The strain of each epoch's frames; nothing where one of them has none."""
    epochs = {each.time: each.epoch for each in program.frames}
    found: dict[str, dict[float, NDArray[np.float32]]] = {}
    for frame in frames:
        values = frame.scalar("strain")
        if values is None:
            return {}
        found.setdefault(f"epoch_{epochs[frame.time]:02d}", {})[frame.time] = np.asarray(values, np.float32)
    return found


def _hide(stage: Any, below: Any) -> None:
    usd = pxr()
    tokens = usd.UsdGeom.Tokens
    tables = [f"{SKIN_ROOT}/{name}" for name in TABLES if stage.GetPrimAtPath(f"{SKIN_ROOT}/{name}")]
    for path in (*(path for path in PLANS if below.GetPrimAtPath(path)), *tables):
        hidden = usd.UsdGeom.Imageable(stage.OverridePrim(path))
        hidden.CreateVisibilityAttr(tokens.invisible)
        hidden.CreatePurposeAttr(tokens.guide)
    for name in MEASURED:
        prim = stage.GetPrimAtPath(f"{SKIN_ROOT}/{name}")
        if prim:
            usd.UsdGeom.Imageable(prim).CreatePurposeAttr(tokens.guide)


def _name(stage: Any, title: str) -> None:
    usd = pxr()
    procedure = stage.GetPrimAtPath("/Procedure")
    procedure.SetDisplayName(title)
    usd.Usd.ModelAPI(procedure).SetKind("component")
    for prim in stage.GetPrimAtPath(SKIN_ROOT).GetChildren():
        if prim.IsA(usd.UsdGeom.Mesh):
            prim.SetDisplayName(f"Skin, epoch {int(prim.GetName().rpartition('_')[2]) + 1}")
