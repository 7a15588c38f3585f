"""A frame of a lesson in Chromium beside Blender's picture of the same frame, as USD, through the same camera."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lesson_browser import opened

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
FRAME = 6  # the hooks hold the lips of the wound apart
_SEEN = """(() => {
  const canvas = document.querySelector("canvas");
  const copy = new OffscreenCanvas(canvas.clientWidth, canvas.clientHeight);
  const pen = copy.getContext("2d");
  pen.drawImage(canvas, 0, 0, copy.width, copy.height);
  const { data } = pen.getImageData(0, 0, copy.width, copy.height);
  const box = canvas.getBoundingClientRect();
  const covered = [];
  const red = [];
  for (let k = 0; k < data.length; k += 4) {
    covered.push(data[k + 3] > 127 ? 1 : 0);
    red.push(data[k + 3] > 127 && data[k] > 1.4 * data[k + 1] ? 1 : 0);
  }
  const places = lappetLesson.shown();
  const pixels = [];
  for (let k = 0; k < places.length; k += 3) {
    const [x, y] = lappetLesson.onScreen(places.slice(k, k + 3));
    pixels.push([x - box.x, y - box.y]);
  }
  return { size: [copy.width, copy.height], covered, red, pixels, camera: lappetLesson.camera() };
})()"""

_BLENDER = """
import json, sys
from math import radians
import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

usd, frame, seen, picture, epoch = sys.argv[1], int(sys.argv[2]), json.load(open(sys.argv[3])), *sys.argv[4:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=usd)
scene = bpy.context.scene
scene.frame_set(frame)
for each in list(bpy.data.objects):
    # The skin of the frame alone: this cache has no scale by which Blender would know it.
    if each.type == "MESH" and each.name not in (epoch, "Bed"):
        bpy.data.objects.remove(each)
width, height = seen["size"]
columns = [seen["camera"]["matrix"][k : k + 4] for k in range(0, 16, 4)]
matrix = Matrix(columns).transposed()
matrix.translation = matrix.translation * 0.001  # Blender's unit is the metre
camera = bpy.data.objects.new("Seen", bpy.data.cameras.new("Seen"))
camera.matrix_world = matrix
camera.data.sensor_fit = "VERTICAL"
camera.data.angle = radians(seen["camera"]["angle"])
camera.data.clip_start, camera.data.clip_end = 1e-3, 100.0
scene.collection.objects.link(camera)
scene.camera = camera
render = scene.render
render.engine = "BLENDER_WORKBENCH"
render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
render.film_transparent = True
render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGBA"
render.filepath = picture
graph = bpy.context.evaluated_depsgraph_get()
pixels = []
for each in bpy.data.objects:
    own = each.evaluated_get(graph)
    if each.name == epoch:
        for vertex in own.to_mesh().vertices:
            x, y, _ = world_to_camera_view(scene, camera, own.matrix_world @ vertex.co)
            pixels.append([x * width, (1.0 - y) * height])
bpy.ops.render.render(write_still=True)
print("ANSWER " + json.dumps(pixels))
"""


@pytest.fixture(scope="module")
def lesson(lesson_file: Path) -> dict[str, Any]:
    """The lesson's picture of the frame without instruments, marks and letters."""
    unchecked = [("uncheck", f"input[name={name}]") for name in ("hooks", "threads", "letters")]
    smaller = [("focus", "canvas"), *[("press", "-")] * 12]  # the whole patch is in the picture
    actions = [("ready", None), ("evaluate", f"lappetLesson.seek({FRAME})"), *unchecked, *smaller, ("changed", None)]
    return opened(lesson_file, *actions, ("evaluate", _SEEN)).results[-1]


@pytest.fixture(scope="module")
def blender(skin_cache: Path, lesson: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Blender's, of the cache as USD."""
    pytest.importorskip("bpy")
    image, draw = pytest.importorskip("PIL.Image"), pytest.importorskip("PIL.ImageDraw")
    folder = tmp_path_factory.mktemp("blender")
    (usd,) = export(ExportRequest((skin_cache,), folder / "x.usdc", {"one_file": True}))
    (folder / "seen.json").write_text(json.dumps({key: lesson[key] for key in ("size", "camera")}))
    cache, picture = SkinCache(skin_cache), folder / "blender.png"
    time = cache.frames[FRAME]
    told = [str(usd), f"{time:g}", str(folder / "seen.json"), str(picture), cache.epoch_at(time).name]
    command = [sys.executable, "-c", _BLENDER, *told]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith("ANSWER ")]
    assert lines, done.stdout[-2000:] + done.stderr[-2000:]
    seen = image.open(picture).convert("RGBA").getchannel("A").point(lambda alpha: 255 if alpha > 127 else 0)
    covered = np.asarray(seen) > 0
    draw.floodfill(seen, (0, 0), 128)  # the background; what is left open is the wound, below which nothing is drawn
    return {"covered": covered, "wound": np.asarray(seen) == 0, "pixels": json.loads(lines[0][7:])}


def grown(mask: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """The pixels of a mask and those that are so near to one of them, along rows or columns."""
    wide = np.pad(mask, by)
    height, width = mask.shape
    steps = range(2 * by + 1)
    return np.any([wide[down : down + height, right : right + width] for down in steps for right in steps], axis=0)


def of_lesson(lesson: dict[str, Any], name: str) -> NDArray[np.bool_]:
    return np.array(lesson[name], bool).reshape(lesson["size"][::-1])


def test_every_vertex_is_at_the_same_place_of_the_picture(lesson: dict[str, Any], blender: dict[str, Any]) -> None:
    away = np.linalg.norm(np.array(lesson["pixels"]) - np.array(blender["pixels"]), axis=1)
    assert away.max() < 0.5, away.max()


def test_the_outlines_are_the_same_within_a_pixel(lesson: dict[str, Any], blender: dict[str, Any]) -> None:
    mine, theirs = of_lesson(lesson, "covered"), blender["covered"] | blender["wound"]
    assert mine.shape == theirs.shape
    assert 0.05 < theirs.mean() < 0.9
    assert not (mine & ~grown(theirs, 1)).any()
    assert not (theirs & ~grown(mine, 1)).any()


def test_the_wound_is_red_where_blender_sees_through_it_and_the_skin_is_not(
    lesson: dict[str, Any], blender: dict[str, Any]
) -> None:
    red, wound = of_lesson(lesson, "red"), blender["wound"]
    inner = ~grown(~wound, 1)
    assert inner.sum() > 500
    assert red[inner].mean() > 0.98
    skin = ~grown(~(blender["covered"] | wound), 15) & ~grown(wound, 12)  # without the rim, and the walls of the wound
    assert red[skin].mean() < 0.01
