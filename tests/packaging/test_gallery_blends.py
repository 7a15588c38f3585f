"""The gallery's pages as projects for Blender: each with its procedure and settings, and a link below its picture."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from gallery import GALLERY, TOLD, cache_of, page, told
from gallery_blends import ROOT, page_of, recipes, write_gallery_blends
from lappet.designs.library_operation import flap_on_patch
from website.pages import stage, with_project_files

needs_blender = pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="bpy is not installed")

# What a Blender that opens a project finds in it; printed as JSON.
LOOK = """
import json, sys
import bpy, lappet_blender
lappet_blender.register()
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
scene = bpy.context.scene
from lappet_blender.model.scene_procedure import read_scene
page = scene.lappet.pages[0]
bpy.context.view_layer.update()
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
tissue = scene.lappet.tissue.object
corners = [world_to_camera_view(scene, scene.camera, tissue.matrix_world @ Vector(c)) for c in tissue.bound_box]
print("SEEN", json.dumps({
    "problems": [each.message for each in read_scene(scene).problems],
    "events": len(scene.lappet.events),
    "page": [page.name, page.style, page.columns, page.width, *(each.caption for each in list(page.panels)[:1])],
    "color": scene.lappet.look.color,
    "marks": [scene.lappet.look.show_plan, scene.lappet.look.show_hooks],
    "landmarks": scene.lappet.look.show_landmarks,
    "active": scene.lappet.active_event,
    "spacing": scene.lappet.tissue.spacing,
    "opened": scene.lappet.solving.when_opened,
    "lights": sorted(o.name for o in scene.objects if o.type == "LIGHT"),
    "paths": [p for p in bpy.utils.blend_paths(absolute=False)],
    "views": sorted({a.spaces.active.region_3d.view_perspective for s in bpy.data.screens for a in s.areas
                     if a.type == "VIEW_3D"}),
    "objects": [o.name for o in bpy.data.objects if o.name in ("Cube", "Light")],
    "depths": [c.z for c in corners],
}))
"""


def test_every_page_of_the_gallery_has_a_recipe_with_the_settings_of_its_command() -> None:
    procedure = flap_on_patch("v-y")
    pages = {each.name: (each, page_of(each, procedure)) for each in recipes()}
    shown = {file.stem for file in GALLERY.iterdir() if file.suffix in (".svg", ".png")}
    assert set(pages) == shown
    assert pages["z_plasty_tension"][1].quantity == "tension"
    assert pages["cheek_limberg"][1].tone == 6
    assert pages["w_plasty"][1].view == "top"
    assert pages["keystone"][1].language == "de"
    assert pages["cheek_limberg_section"][1].section_at == (-50.0, 112.0, 692.0)
    assert pages["keystone_atlas"][1].style == "ink"  # of the template
    assert [each.step for each in pages["rhomboid_before_after"][1].panels] == ["plan", "result"]
    assert pages["v_y"][0].spacing == 1.5


def test_a_page_of_the_site_links_to_the_projects_that_there_are() -> None:
    text = (GALLERY / "README.md").read_text(encoding="utf-8")
    linked = with_project_files(text, ["z_plasty.blend", "v_y.blend"])
    assert linked.count(".blend](") == 2
    assert linked.index("(z_plasty.png)") < linked.index("(z_plasty.blend)") < linked.index("(z_plasty_tension.png)")
    assert with_project_files(text, []) == text


def opened(project: Path) -> dict[str, Any]:
    """What a Blender that opens the project finds in it."""
    paths = os.pathsep.join([str(ROOT / "shared"), str(ROOT / "addon"), os.environ.get("PYTHONPATH", "")])
    call = [sys.executable, "-c", LOOK, str(project)]
    said = subprocess.run(
        call, check=True, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": paths}, timeout=120
    ).stdout
    found = json.loads(next(line for line in said.splitlines() if line.startswith("SEEN")).removeprefix("SEEN"))
    assert isinstance(found, dict)
    return found


@needs_blender
def test_a_project_of_a_map_shows_the_plan_as_its_page_does(tmp_path: Path) -> None:
    (made,) = write_gallery_blends(tmp_path, ["z_plasty_tension"])
    seen = opened(made)
    assert (seen["color"], seen["marks"]) == ("TENSION", [True, True])


@needs_blender
def test_a_project_holds_the_procedure_the_page_and_a_camera_that_sees_it_and_no_path_of_this_computer(
    tmp_path: Path,
) -> None:
    (tmp_path / "v_y.blend").write_bytes(b"of before")
    (made,) = write_gallery_blends(tmp_path, ["v_y"])
    assert [file.name for file in tmp_path.iterdir()] == ["v_y.blend"]
    assert made.stat().st_size < 3_000_000
    seen = opened(made)
    assert seen["problems"] == []
    assert seen["events"] > 5
    assert seen["page"] == ["v_y", "ink", 1, 85.0, "The plan: a V whose limbs close as a Y"]
    assert (seen["color"], seen["spacing"], seen["opened"]) == ("PLAIN", 1.5, True)
    assert (seen["marks"], seen["landmarks"], seen["active"]) == ([True, True], False, -1)
    assert seen["lights"] == ["Fill", "Key", "Rim"]
    assert (seen["paths"], seen["objects"], seen["views"]) == ([], [], ["CAMERA"])
    assert min(seen["depths"]) > 0.0


def test_the_site_gets_the_projects_beside_the_pictures(tmp_path: Path) -> None:
    (tmp_path / "files/gallery").mkdir(parents=True)
    (tmp_path / "files/gallery/v_y.blend").write_bytes(b"BLENDER")
    stage(ROOT, tmp_path / "pages", tmp_path / "files")
    assert (tmp_path / "pages/docs/gallery/v_y.blend").read_bytes() == b"BLENDER"
    assert "(v_y.blend)" in (tmp_path / "pages/docs/gallery/README.md").read_text(encoding="utf-8")


def test_the_gallerys_page_says_of_its_frames_what_the_solve_says() -> None:
    error = {"max": 0.68, "rms": 0.1}
    report = {
        "frames": [{"estimated_error_mm": {"max": 1.35}}, {"estimated_error_mm": error}],
        "notes": [
            {"severity": "warning", "prim": "Frames 24 to 40", "message": "Not to be trusted near (-6, 0, 4) mm."},
            {"severity": "note", "prim": "", "message": "Of no one's concern."},
        ],
    }
    said = told(report)
    assert said == [
        "Estimated error: 0.68 mm at most in the last frame, 1.4 mm in all.",
        "Frames 24 to 40: Not to be trusted near (-6, 0, 4) mm.",
    ]
    plates = tomllib.loads((GALLERY / "gallery.toml").read_text(encoding="utf-8"))["plate"]
    kept = json.loads(TOLD.read_text(encoding="utf-8"))
    assert set(kept) == {cache_of(each) for each in plates}
    assert all("Estimated error" in lines[0] for lines in kept.values())
    assert (GALLERY / "README.md").read_text(encoding="utf-8") == page(plates, kept)
    assert "- Frames 24 to 40: Not" in page(plates, {**kept, "v_y.usdc": said})
