"""Write the operation of every design of the flap library as files that the site offers: `flap_downloads.py FOLDER`.

A `.usda` each, and where Blender's module is installed a `.blend`, which a process of its own writes: Blender's USD and
that of the command line cannot live in one.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import flap_on_patch

ROOT = Path(__file__).resolve().parent.parent
BLENDS = "--blends"


def write_downloads(folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Write the files.

    Parameters
    ----------
    folder
        Where to; made if needed.
    names
        Designs of the library; none for all of them.

    Returns
    -------
    list of Path
        The files that there are now for these designs.
    """
    from lappet.usd.stage import write_procedure

    chosen = list(names) or list(DESIGNS)
    folder.mkdir(parents=True, exist_ok=True)
    for name in chosen:
        write_procedure(flap_on_patch(name), folder / f"{name}.usda")
    if importlib.util.find_spec("bpy") is None:
        print("flap_downloads: Blender's module is not installed; the site has no .blend files.", file=sys.stderr)
    else:
        path = os.pathsep.join([str(ROOT / "shared"), str(ROOT / "addon"), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, __file__, BLENDS, str(folder), *chosen]
        subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL)
    return [file for name in chosen for file in sorted(folder.glob(f"{name}.*"))]


def write_blends(folder: Path, names: Sequence[str]) -> None:
    """Write the Blender files: in a process that has not loaded USD."""
    import bpy

    import lappet_blender
    from lappet_blender.model.scene_filling import fill_scene

    lappet_blender.register()
    for name in names:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 0.001
        scene.unit_settings.length_unit = "MILLIMETERS"
        fill_scene(scene, flap_on_patch(name), scene.collection)
        bpy.ops.wm.save_as_mainfile(filepath=str((folder / f"{name}.blend").resolve()), compress=True, copy=True)


if __name__ == "__main__":
    if sys.argv[1] == BLENDS:
        write_blends(Path(sys.argv[2]), sys.argv[3:])
    else:
        write_downloads(Path(sys.argv[1]), sys.argv[2:])
