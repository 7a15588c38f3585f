"""Where Lappet keeps solved frames and finds Blender."""

from __future__ import annotations

import importlib.util
import os
import shutil
import tempfile
from pathlib import Path

from lappet.installation.finding import Finding
from lappet.output.render import PYTHON_VARIABLE
from lappet.solve.own_files import own_folder
from lappet.solve.store import default_folder

LEAST_FREE = 2**30  # bytes, chosen: some hundred frames of a usual scene


def check_places() -> list[Finding]:
    """Find whether frames can be kept and pictures can be drawn.

    Returns
    -------
    list[Finding]
        One of the store, one of Blender.
    """
    return [_store(default_folder()), _blender(os.environ.get(PYTHON_VARIABLE))]


def _store(folder: Path) -> Finding:
    """Whether a file can be written there, and how much room is left."""
    elsewhere = "name a folder of yours in LAPPET_STORE"
    try:
        own_folder(folder)
        with tempfile.NamedTemporaryFile(dir=folder) as file:
            file.write(b"\0" * 65536)
            file.flush()
            os.fsync(file.fileno())
        free = shutil.disk_usage(folder).free
    except OSError as error:
        said = error.strerror or error
        return Finding("store", "broken", f"solved frames cannot be kept in {folder}: {said}", elsewhere)
    value = f"{folder}, {free / 2**30:.1f} GiB free"
    if free < LEAST_FREE:
        return Finding("store", "missing", f"{value}: little for solved frames", f"free some space, or {elsewhere}")
    return Finding("store", "ok", value)


def _blender(python: str | None) -> Finding:
    """Whether there is a Python with Blender's module, here or where the user says."""
    if python:
        if shutil.which(python):
            return Finding("Blender", "ok", f"{PYTHON_VARIABLE} names {python}")
        remedy = f"name a Python that has bpy in {PYTHON_VARIABLE}, or unset it"
        return Finding("Blender", "missing", f"{PYTHON_VARIABLE} names {python}, which is no program", remedy)
    if importlib.util.find_spec("bpy") is not None:
        return Finding("Blender", "ok", "the module bpy is in this Python")
    remedy = f'pip install "lappet[render]" with Python 3.11, or name a Python that has bpy in {PYTHON_VARIABLE}'
    return Finding("Blender", "missing", "this Python has no module bpy; for pictures (lappet render)", remedy)
