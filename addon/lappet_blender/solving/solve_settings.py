"""How and where a scene is solved: the options of its Solve panel as values."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

from lappet.program.settings import SolverSettings
from lappet.solve.store import FOLDER_VARIABLE, FrameStore, default_folder

from ..model.decimals import decimal

BESIDE = "lappet_frames"
_stores: dict[Path, FrameStore] = {}


def solve_settings(scene: bpy.types.Scene) -> SolverSettings:
    """The settings of a scene."""
    solving = scene.lappet.solving
    return SolverSettings(
        tolerance=decimal(solving.tolerance),
        quadrature=int(solving.quadrature),
        precision=solving.precision,
        friction=decimal(solving.friction) if solving.self_contact else 0.0,
        threads=solving.threads,
        correction=solving.error_estimate,  # which the estimate needs, and so asks for it
    )


def frame_folder(scene: bpy.types.Scene) -> Path:
    """Where the scene's frames are kept: the user's cache, or beside the saved .blend where that is asked for."""
    if scene.lappet.solving.beside_file and bpy.data.filepath:
        return Path(bpy.data.filepath).parent / BESIDE
    return default_folder()


def frame_folder_choice(scene: bpy.types.Scene) -> tuple[object, ...]:
    """Return what the folder depends on: as good for noticing another one, and no path is made at every turn."""
    beside = scene.lappet.solving.beside_file
    return beside, bpy.data.filepath if beside else "", os.environ.get(FOLDER_VARIABLE)


def frame_store(scene: bpy.types.Scene) -> FrameStore:
    """The store in that folder."""
    folder = frame_folder(scene)
    if folder not in _stores:
        _stores[folder] = FrameStore(folder)
    return _stores[folder]
