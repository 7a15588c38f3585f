"""Alembic and FBX, written by Blender and read by it again."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.geometry.closest_point import ClosestPoint

CLOSE = 0.05  # mm

_IMPORT = """
import sys
import bpy
import numpy as np

path, out, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = int(sys.argv[4])
first = 0
if path.endswith(".abc"):
    bpy.ops.wm.alembic_import(filepath=path, as_background_job=False)
else:
    bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0)
seen = {}
for frame in range(count):
    scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    for each in scene.objects:
        if each.type == "MESH":
            own = each.evaluated_get(graph)
            mesh = own.to_mesh()
            points = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", points)
            matrix = np.array(own.matrix_world)
            world = (points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]) * 1000.0
            if np.ptp(world, axis=0).max() > 1e-3:
                seen[f"{each.name} {frame}"] = world
            own.to_mesh_clear()
np.savez(out, materials=[each.name for each in bpy.data.materials], **seen)
"""


def distance(a: np.ndarray, b: np.ndarray) -> float:
    """The greatest distance from a point of either set to the nearest of the other."""
    worst = 0.0
    for one, other in ((a, b), (b, a)):
        every = np.arange(len(other))
        worst = max(worst, float(ClosestPoint(other.astype(float), np.stack([every] * 3, 1)).query(one)[2].max()))
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["abc", "fbx"])
def test_blender_reads_the_right_epoch_at_every_frame_where_it_was_solved(tmp_path: Path, suffix: str) -> None:
    pytest.importorskip("bpy")
    cache = SkinCache(synthetic.write_cache(tmp_path, step=4.0))
    (path,) = export(ExportRequest((cache.path,), tmp_path / f"skin.{suffix}"))
    out = tmp_path / "seen.npz"
    arguments = [str(path), str(out), str(len(cache.frames)), f"{cache.fps:g}"]
    command = [sys.executable, "-c", _IMPORT, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    seen = np.load(out)
    assert {each.replace("_", " ") for each in seen["materials"]} >= {"Skin with grid", "Cut skin", "Thread", "Steel"}
    for frame, time in enumerate(cache.frames):
        epoch = cache.epoch_at(time)
        shown = {key.rpartition(" ")[0] for key in seen.files if key.endswith(f" {frame}")}
        assert {name for name in shown if name.startswith("epoch")} == {epoch.name}
        assert distance(seen[f"{epoch.name} {frame}"], cache.positions(epoch, time)) < CLOSE


def test_a_python_without_blender_is_told_before_the_cache_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAPPET_BLENDER_PYTHON", str(tmp_path / "python"))
    (tmp_path / "no.usdc").touch()
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((tmp_path / "no.usdc",), tmp_path / "skin.abc"))
    assert [each.code for each in refusal.value.problems] == [ProblemCode.EXPORT_NO_BPY]
