"""Write a Blender file for each page of the gallery: `gallery_blends.py FOLDER [NAME ...]`.

It holds the page's procedure, the page itself with its settings (panel *Plate*), the camera, lights and paper of a
picture, and the look. Solved frames are bound to the computer that solved them, so it holds none: the extension solves
the file when it is opened, and says so. Two processes make a file, since Blender's USD and that of the command line
cannot live in one: the first writes the procedure as the gallery's commands do, the second fills Blender's scene.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shlex
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from gallery import GALLERY, ROOT, arguments, target_of
from lappet.commands.plate_command import plate as plate_command
from lappet.daemon.process import DaemonMissing, find_daemon
from lappet.models.body_package import COMMAND, is_fetched
from lappet.plates.plate_templates import from_template, steps_of
from lappet.procedure import Plate, PlatePanel, Procedure

BLENDS = "--blends"
_ZOOM = 12.0  # of the viewport at the camera's frame; 0 leaves half of it empty
_PICTURE = (1600, 1200)  # pixels of a render of one frame


@dataclass(frozen=True)
class Recipe:
    """How a page is made. begin: the command that writes the procedure. spacing: of the lattice, mm; 0: its own."""

    name: str
    title: str
    begin: str
    procedure: str
    spacing: float
    plate: tuple[str, ...]

    @property
    def needs_models(self) -> bool:
        """Whether it is on a body, whose meshes are fetched."""
        return "examples/faces" in self.begin


def recipes() -> list[Recipe]:
    """Every page of the gallery."""
    plates = tomllib.loads((GALLERY / "gallery.toml").read_text(encoding="utf-8"))["plate"]
    makers = {target_of(command): command for plate in plates for command in plate["commands"]}
    return [_recipe(plate, makers) for plate in plates]


def page_of(recipe: Recipe, procedure: Procedure) -> Plate:
    """The page with what the gallery's command says of it, the rest as its template or the command has it."""
    context = plate_command.make_context("plate", list(recipe.plate))
    given = {
        name: value
        for name, value in context.params.items()
        if value is not None and context.get_parameter_source(name).name != "DEFAULT"
    }
    template = given.pop("template", None)
    page = from_template(procedure, template) if template else Plate(recipe.name)
    if "section" in given:
        numbers = tuple(given.pop("section"))
        given["section_at"], given["section_normal"] = numbers[:3], numbers[3:]
    given["quantity"] = given.pop("mapped", page.quantity)
    captions = dict(given.pop("captions", ()))
    known = {field.name for field in fields(Plate)} - {"name", "panels"}
    page = replace(page, name=recipe.name, **{name: value for name, value in given.items() if name in known})
    if captions and not page.panels:
        page = replace(page, panels=tuple(PlatePanel(step, step) for step in steps_of(procedure)))
    panels = (replace(each, caption=captions.get(i, each.caption)) for i, each in enumerate(page.panels))
    return replace(page, panels=tuple(panels))


def write_gallery_blends(folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Write the files of some pages, of all for none; those there are. Without Blender's module or models some lack."""
    if importlib.util.find_spec("bpy") is None:
        print("gallery_blends: Blender's module is not installed; the site has no projects.", file=sys.stderr)
        return []
    try:
        find_daemon()
    except DaemonMissing as error:
        print(f"gallery_blends: no projects, as nothing cuts their tissue: {error}", file=sys.stderr)
        return []
    chosen = [each for each in recipes() if not names or each.name in names]
    if any(each.needs_models for each in chosen) and not is_fetched():
        print(f"gallery_blends: nothing on a body, as the models are not there; `{COMMAND}`.", file=sys.stderr)
        chosen = [each for each in chosen if not each.needs_models]
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        for command in dict.fromkeys(each.begin for each in chosen):
            subprocess.run(arguments(command), cwd=work, check=True, stdout=subprocess.DEVNULL)
        jobs = [_job(each, Path(work), folder.resolve()) for each in chosen]
        listed = Path(work) / "jobs.json"
        listed.write_text(json.dumps(jobs), encoding="utf-8")
        path = os.pathsep.join([str(ROOT / "shared"), str(ROOT / "addon"), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, __file__, BLENDS, str(listed)]
        subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL)
    return sorted(folder / f"{each.name}.blend" for each in chosen)


def _recipe(plate: dict[str, Any], makers: dict[str, str]) -> Recipe:
    words = shlex.split(plate["commands"][-1])
    assert words[:2] == ["lappet", "plate"], plate["name"]
    solve = shlex.split(makers[words[2]])
    assert solve[:2] == ["lappet", "solve"], plate["name"]
    spacing = float(solve[solve.index("--spacing") + 1]) if "--spacing" in solve else 0.0
    return Recipe(plate["name"], plate["title"], makers[solve[2]], solve[2], spacing, tuple(words[2:]))


def _job(recipe: Recipe, work: Path, folder: Path) -> dict[str, Any]:
    return {"name": recipe.name, "usda": str(work / recipe.procedure), "blend": str(folder / f"{recipe.name}.blend")}


def write_blends(jobs: list[dict[str, Any]]) -> None:
    """Fill and save the files, in a process that has not loaded USD."""
    import bpy

    import lappet_blender

    lappet_blender.register()
    by_name = {each.name: each for each in recipes()}
    for job in jobs:
        bpy.ops.wm.read_factory_settings()  # with its windows, which a file brings along
        bpy.context.preferences.filepaths.save_version = 0  # no file of before beside the new one
        for data in (bpy.data.objects, bpy.data.collections, bpy.data.materials, bpy.data.lights, bpy.data.cameras):
            bpy.data.batch_remove(list(data))
        bpy.data.orphans_purge(do_recursive=True)
        fill(bpy.context.scene, by_name[job["name"]], job["usda"])
        bpy.ops.wm.save_as_mainfile(filepath=job["blend"], compress=True, copy=True, relative_remap=False)
    lappet_blender.unregister()


def fill(scene: Any, recipe: Recipe, usda: str) -> None:
    """Give an empty scene the procedure of a file, the page, camera, lights and look. Solves nothing."""
    import bpy

    from lappet_blender.model.plate_values import keep_plates
    from lappet_blender.model.scene_procedure import read_scene

    scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 0.001
    scene.unit_settings.length_unit = "MILLIMETERS"
    bpy.ops.lappet.import_procedure(filepath=usda)
    scene.name = recipe.name
    if recipe.spacing:
        scene.lappet.tissue.spacing = recipe.spacing
    procedure = read_scene(scene).procedure
    assert procedure is not None
    page = page_of(recipe, procedure)
    keep_plates(scene, (page,))
    bpy.ops.lappet.look_preset(preset="OPERATION")  # with pen marks and steel, which a page has over a map as well
    if page.quantity in ("tension", "strain"):
        scene.lappet.look.color = page.quantity.upper()
    scene.lappet.solving.when_opened = True
    scene.frame_set(scene.frame_start)
    bpy.ops.lappet.plan_now(wait=True)
    bpy.ops.lappet.set_stage(view=page.view.upper(), engine="CYCLES", width=_PICTURE[0], height=_PICTURE[1])
    scene.lappet.active_event = -1  # none: its points would lie over the picture
    for area in (area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"):
        space = area.spaces.active
        space.show_region_ui = True  # where it says that it solves
        space.region_3d.view_perspective = "CAMERA"
        space.region_3d.view_camera_zoom = _ZOOM


if __name__ == "__main__":
    if sys.argv[1] == BLENDS:
        write_blends(json.loads(Path(sys.argv[2]).read_text(encoding="utf-8")))
    else:
        for made in write_gallery_blends(Path(sys.argv[1]), sys.argv[2:]):
            print(made)
