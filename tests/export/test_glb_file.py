"""A .glb is valid glTF, and what other readers see of it is the cache, frame by frame."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd

import synthetic_skin_cache as synthetic
import viewer
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export import glb_file
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.geometry.closest_point import ClosestPoint

CLOSE = 0.05  # mm


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("glb"), step=2.0))


@pytest.fixture(scope="module")
def glb(cache: SkinCache) -> Path:
    (path,) = export(ExportRequest((cache.path,), cache.path.with_name("skin.glb")))
    return path


@pytest.fixture(scope="module")
def quantized(cache: SkinCache, glb: Path) -> Path:
    target = glb.with_name("quantized.glb")
    (path,) = export(ExportRequest((cache.path,), target, {"quantized": True}))
    return path


@pytest.fixture(params=["glb", "quantized"])
def either(request: pytest.FixtureRequest) -> Path:
    """The file, and the quantized one."""
    path: Path = request.getfixturevalue(request.param)
    return path


def document_of(path: Path) -> dict[str, Any]:
    data = path.read_bytes()
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert (data[:4], kind) == (b"glTF", b"JSON")
    found: dict[str, Any] = json.loads(data[20 : 20 + length])
    return found


def test_a_quantized_file_is_smaller_and_says_how_far_its_vertices_are(cache: SkinCache, glb: Path) -> None:
    told: list[Problem] = []
    target = glb.with_name("told.glb")
    export(ExportRequest((cache.path,), target, {"quantized": True}, note=told.append))
    assert target.stat().st_size < 0.8 * glb.stat().st_size
    document = document_of(target)
    assert document["extensionsRequired"] == ["KHR_mesh_quantization"]
    kinds = {document["accessors"][p["attributes"]["POSITION"]]["componentType"] for p in primitives(document)}
    assert kinds == {5122}
    (said,) = told
    assert said.code == ProblemCode.EXPORT_DRIFT_FOUND
    # Half a step of 16 bits of the tissue or a hook in each direction, and what a vertex that lies still may move.
    assert 0.0 < float(said.value) < 0.002 + 200.0 / 65535 * 3**0.5


def test_a_quantized_skin_that_would_drift_is_refused(
    cache: SkinCache, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(glb_file, "MOST_DRIFT", 1e-4)
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((cache.path,), tmp_path / "skin.glb", {"quantized": True}))
    assert [each.code for each in refusal.value.problems] == [ProblemCode.EXPORT_DRIFT]
    assert list(tmp_path.iterdir()) == []


def primitives(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [each for mesh in document["meshes"] for each in mesh["primitives"]]


_VALIDATE = """
import fs from "node:fs";
import { createRequire } from "node:module";
const validator = createRequire(process.argv[1])("gltf-validator");
const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])));
console.log(JSON.stringify(report.issues));
"""


def test_the_validator_of_khronos_finds_nothing(either: Path) -> None:
    try:
        node, _ = viewer.node()
        viewer.install(tests=True)
    except (FileNotFoundError, subprocess.CalledProcessError) as missing:
        pytest.skip(f"NOT VALIDATED: node or the package gltf-validator is missing; run `make setup` ({missing})")
    command = [str(node), "--input-type=module", "-e", _VALIDATE, str(viewer.VIEWER / "package.json"), str(either)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    found = json.loads(done.stdout)
    assert [found[each] for each in ("numErrors", "numWarnings", "numHints")] == [0, 0, 0]
    # It says of these two extensions that it does not know all of their rules, and nothing else.
    unknown = {"UNSUPPORTED_EXTENSION", "INCOMPLETE_EXTENSION_SUPPORT"}
    said = [each for each in found["messages"] if each["code"] not in unknown]
    assert said == []
    named = [each["message"] for each in found["messages"] if each["code"] == "UNSUPPORTED_EXTENSION"]
    assert all("'KHR_node_visibility'" in message for message in named)
    assert all(
        "KHR_animation_pointer" in each["pointer"]
        for each in found["messages"]
        if each["code"] == "INCOMPLETE_EXTENSION_SUPPORT"
    )


def test_visibility_switches_as_scale_does_where_it_is_understood(either: Path) -> None:
    document = document_of(either)
    data = either.read_bytes()
    buffer = data[28 + struct.unpack_from("<I", data, 12)[0] :]

    def values(index: int) -> list[float]:
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        kind = {5121: np.uint8, 5126: np.float32}[accessor["componentType"]]
        columns = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        found = np.frombuffer(buffer, kind, accessor["count"] * columns, view["byteOffset"])
        return found.reshape(-1, columns)[:, 0].astype(float).tolist()

    assert {"KHR_node_visibility", "KHR_animation_pointer"} <= set(document["extensionsUsed"])
    assert not {"KHR_node_visibility", "KHR_animation_pointer"} & set(document.get("extensionsRequired", ()))
    for animation in document["animations"]:
        switches: dict[str, dict[int, tuple[int, list[float]]]] = {"scale": {}, "pointer": {}}
        for channel in animation["channels"]:
            target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
            if target["path"] == "pointer":
                assert "node" not in target
                pointer = target["extensions"]["KHR_animation_pointer"]["pointer"].split("/")
                assert pointer[3:] == ["extensions", "KHR_node_visibility", "visible"]
                number = int(pointer[2])
            else:
                number = target["node"]
            if target["path"] in switches:
                assert sampler["interpolation"] == "STEP"
                switches[target["path"]][number] = (sampler["input"], values(sampler["output"]))
        assert switches["scale"]
        assert switches["pointer"] == switches["scale"]
    for node in document["nodes"]:
        if "extensions" in node:
            assert node["extensions"]["KHR_node_visibility"]["visible"] == ("scale" not in node)


def test_steps_are_animations_besides_the_one_of_all(glb: Path, cache: SkinCache) -> None:
    document = document_of(glb)
    names = [each["name"] for each in document["animations"]]
    assert names[0] == "Operation"
    assert [int(name.split()[0]) for name in names[1:]] == list(range(1, len(names)))
    accessors = document["accessors"]
    ends = [
        max(accessors[sampler["input"]]["max"][0] for sampler in animation["samplers"])
        for animation in document["animations"]
    ]
    assert ends[0] == pytest.approx((cache.frames[-1] - cache.frames[0]) / cache.fps, abs=1e-6)
    for animation in document["animations"]:
        assert min(accessors[sampler["input"]]["min"][0] for sampler in animation["samplers"]) == 0.0


def test_what_a_frame_does_not_move_takes_no_space(glb: Path) -> None:
    document = document_of(glb)
    (skin,) = [each for each in document["meshes"] if each["name"] == "epoch_00"]
    assert "targets" not in skin["primitives"][0]  # the skin lies still before it is cut
    (cut,) = [each for each in document["meshes"] if each["name"] == "epoch_01"]
    targets = [document["accessors"][each["POSITION"]] for each in cut["primitives"][0]["targets"]]
    assert any("sparse" in each for each in targets)


def test_trimesh_reads_the_last_frame_in_metres_with_y_up(either: Path, cache: SkinCache) -> None:
    import trimesh

    scene = trimesh.load_scene(either)
    epoch = cache.epoch_at(cache.frames[-1])
    solved = cache.positions(epoch, cache.frames[-1])
    found = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        if epoch.name in node or epoch.name in name:
            found.append(trimesh.transform_points(scene.geometry[name].vertices, transform))
    points = np.unique(np.concatenate(found), axis=0) * 1000.0
    assert both_ways(np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1), solved) < CLOSE


def both_ways(a: np.ndarray, b: np.ndarray) -> float:
    """The greatest distance from a point of either set to the nearest of the other."""
    worst = 0.0
    for one, other in ((a, b), (b, a)):
        every = np.arange(len(other))
        worst = max(worst, float(ClosestPoint(other.astype(float), np.stack([every] * 3, 1)).query(one)[2].max()))
    return worst


_IMPORT = """
import sys
import bpy
import numpy as np

glb, out, fps = sys.argv[1], sys.argv[2], int(sys.argv[3])
frames = [float(each) for each in sys.argv[4].split(",")]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = fps
bpy.ops.import_scene.gltf(filepath=glb)
seen = {}
for time in frames:
    # The importer lays second 0 on frame 0.
    scene.frame_set(round(time - frames[0]))
    graph = bpy.context.evaluated_depsgraph_get()
    for each in scene.objects:
        if each.type != "MESH":
            continue
        own = each.evaluated_get(graph)
        if max(own.matrix_world.to_scale()) < 1e-9:
            continue
        mesh = own.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        matrix = np.array(own.matrix_world)
        seen[f"{each.name} {time:g}"] = (points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]) * 1000.0
        own.to_mesh_clear()
np.savez(out, materials=[each.name for each in bpy.data.materials], **seen)
"""


@pytest.mark.slow
def test_blender_shows_the_right_epoch_at_every_frame_where_it_was_solved(
    either: Path, cache: SkinCache, tmp_path: Path
) -> None:
    pytest.importorskip("bpy")
    times = ",".join(f"{time:g}" for time in cache.frames)
    command = [sys.executable, "-c", _IMPORT, str(either), str(tmp_path / "seen.npz"), f"{cache.fps:g}", times]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-2000:]
    seen = np.load(tmp_path / "seen.npz")
    assert "Skin with grid" in seen["materials"]
    for time in cache.frames:
        epoch = cache.epoch_at(time)
        shown = {key.rpartition(" ")[0] for key in seen.files if key.endswith(f" {time:g}")}
        assert {name for name in shown if name.startswith("epoch")} == {epoch.name}
        assert ("threads" in shown) == bool(cache.sutures(time).active.any())
        assert ("hooks" in shown) == bool(cache.hooks(time).active.any())
        assert both_ways(seen[f"{epoch.name} {time:g}"], cache.positions(epoch, time)) < CLOSE


def test_chosen_frames_alone_are_written(cache: SkinCache, tmp_path: Path) -> None:
    chosen = (cache.frames[2], cache.frames[-1])
    export(ExportRequest((cache.path,), tmp_path / "two.glb", {"frames": chosen}))
    document = document_of(tmp_path / "two.glb")
    (cut,) = [each for each in document["meshes"] if each["name"] == "epoch_01"]
    assert cut["extras"]["targetNames"] == [f"frame {chosen[0]:g}"]
    assert [each["name"] for each in document["meshes"] if each["name"].startswith("epoch")] == ["epoch_01"]


def test_a_frame_that_the_cache_does_not_hold_is_refused_before_anything_is_written(
    cache: SkinCache, tmp_path: Path
) -> None:
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((cache.path,), tmp_path / "no.glb", {"frames": (99.0,)}))
    assert [each.code for each in refusal.value.problems] == [ProblemCode.EXPORT_FRAME]
    assert list(tmp_path.iterdir()) == []


def test_a_cache_without_its_procedure_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    below = tmp_path / "below"
    below.mkdir()
    moved = below / "skin.usdc"
    stage = Usd.Stage.CreateNew(str(moved))
    stage.GetRootLayer().subLayerPaths.append("./gone.usda")
    stage.Save()
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((moved,), tmp_path / "skin.glb"))
    assert {each.code for each in refusal.value.problems} == {ProblemCode.USD_COMPOSITION}
    assert not (tmp_path / "skin.glb").exists()


def test_an_unknown_suffix_is_refused_with_those_that_are_known(cache: SkinCache, tmp_path: Path) -> None:
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((cache.path,), tmp_path / "skin.dwg"))
    (problem,) = refusal.value.problems
    assert problem.code == ProblemCode.EXPORT_SUFFIX
    assert ".glb" in str(problem)
