"""Write the operations of every design of the flap library as files that the site offers: `flap_downloads.py FOLDER`.

One on a flat patch, and where the models' package is there those on a body, without what is only shown around them. A
`.usda` each, and where Blender's module is installed a `.blend`, which a process of its own writes: Blender's USD and
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
from lappet.models.body_package import COMMAND, is_fetched
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model, regional_flaps
from lappet.procedure import Procedure

ROOT = Path(__file__).resolve().parent.parent
BLENDS = "--blends"


def write_downloads(folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Write the files.

    Parameters
    ----------
    folder
        Where to; made if needed, with a folder for each design.
    names
        Designs of the library; none for all of them.

    Returns
    -------
    list of Path
        The files that there are now for these designs.
    """
    from lappet.usd.stage import write_procedure

    chosen = list(names) or list(DESIGNS)
    made = [(name, operation) for name in chosen for operation in operations(name)]
    for name, operation in made:
        (folder / name).mkdir(parents=True, exist_ok=True)
        write_procedure(procedure_of(operation), folder / name / f"{operation}.usda")
    if not is_fetched():
        print(f"flap_downloads: nothing on a body, as the models are not there; `{COMMAND}`.", file=sys.stderr)
    if importlib.util.find_spec("bpy") is None:
        print("flap_downloads: Blender's module is not installed; the site has no .blend files.", file=sys.stderr)
    else:
        path = os.pathsep.join([str(ROOT / "shared"), str(ROOT / "addon"), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, __file__, BLENDS, str(folder), *chosen]
        subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL)
    return [file for name in chosen for file in sorted((folder / name).glob("*"))]


def operations(design: str) -> list[str]:
    """The operations of a design that can be written: on the patch under its own name, and on models."""
    return [design, *(flap.name for flap in regional_flaps(design) if is_fetched())]


def procedure_of(operation: str) -> Procedure:
    """The procedure of one of them."""
    return flap_on_model(operation, scenery=False) if operation in REGIONAL_FLAPS else flap_on_patch(operation)


def write_blends(folder: Path, names: Sequence[str]) -> None:
    """Write the Blender files: in a process that has not loaded USD."""
    import bpy

    import lappet_blender
    from lappet_blender.model.scene_filling import fill_scene

    lappet_blender.register()
    for operation, file in ((each, folder / name / f"{each}.blend") for name in names for each in operations(name)):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 0.001
        scene.unit_settings.length_unit = "MILLIMETERS"
        fill_scene(scene, procedure_of(operation), scene.collection)
        bpy.ops.wm.save_as_mainfile(filepath=str(file.resolve()), compress=True, copy=True)


if __name__ == "__main__":
    if sys.argv[1] == BLENDS:
        write_blends(Path(sys.argv[2]), sys.argv[3:])
    else:
        write_downloads(Path(sys.argv[1]), sys.argv[2:])
