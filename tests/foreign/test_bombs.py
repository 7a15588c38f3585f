"""Small files that ask for much are refused within their limits, with the limit and the remedy named."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import bombs
import numpy as np
import pytest

from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import GIB, ReadLimits
from lappet.output.render import render_cache
from lappet.procedure.scene_profile import measured_costs
from lappet.tissue.mesh_file import read_mesh
from lappet.usd.stage import read_procedure

LIMITS = ReadLimits(memory=GIB, seconds=30, size=64 << 20)  # time for a busy machine to meet the others first
SHORT = replace(LIMITS, seconds=3)
POSIX = pytest.mark.skipif(os.name != "posix", reason="no limits of memory, pipes and links here")
# What spends memory in USD's own code meets the limit there: it ends as it likes.
SPENT = {ProblemCode.READ_MEMORY, ProblemCode.READ_TIME, ProblemCode.READ_DIED}


@contextmanager
def in_time(limits: ReadLimits) -> Iterator[None]:
    begun = time.monotonic()
    yield
    assert time.monotonic() - begun < limits.wall_seconds + 5.0


def refusal(read: Callable[[], object], limits: ReadLimits = LIMITS) -> Problem:
    """The one reason why a file is not read, which comes in time."""
    with in_time(limits), pytest.raises(RefusedError) as error:
        read()
    (problem,) = error.value.problems
    return problem


@POSIX
def test_a_crate_that_unfolds_is_refused(tmp_path: Path) -> None:
    bomb = bombs.unfolding_crate(tmp_path, 600)
    assert bomb.stat().st_size < 60_000
    problem = refusal(lambda: read_procedure(bomb, limits=LIMITS))
    assert (problem.code, problem.prim, problem.value) == (ProblemCode.READ_MEMORY, str(bomb), "1 GiB")
    assert "--read-memory" in problem.remedy


def test_a_skin_cache_whose_frames_unfold_is_not_drawn(tmp_path: Path) -> None:
    """No single value is large; Blender would hold them all."""
    bomb = bombs.unfolding_cache(tmp_path, 100)
    assert bomb.stat().st_size < 60_000
    problem = refusal(lambda: render_cache(bomb, tmp_path / "pictures", limits=LIMITS))
    assert (problem.code, problem.value) == (ProblemCode.READ_MEMORY, "1 GiB")
    assert not (tmp_path / "pictures").exists()


@POSIX
def test_what_is_read_of_a_file_may_not_be_larger_than_a_file_may(tmp_path: Path) -> None:
    problem = refusal(lambda: read_procedure(bombs.unfolding_crate(tmp_path, 20), limits=LIMITS))
    assert (problem.code, problem.value) == (ProblemCode.READ_RESULT_SIZE, "64 MiB")
    assert "--read-size" in problem.remedy


@POSIX
def test_a_crate_that_takes_for_ever_is_refused(tmp_path: Path) -> None:
    bomb = bombs.slow_crate(tmp_path, 45_000, 100)
    assert bomb.stat().st_size < 800_000
    problem = refusal(lambda: read_procedure(bomb, limits=SHORT), SHORT)
    assert (problem.code, problem.value) == (ProblemCode.READ_TIME, "3 s")
    assert "--read-seconds" in problem.remedy


@POSIX
def test_ten_million_prims_by_nested_references_are_refused(tmp_path: Path) -> None:
    assert refusal(lambda: read_procedure(bombs.nested_references(tmp_path, 7), limits=SHORT), SHORT).code in SPENT


@pytest.mark.parametrize("stride", ["1e-9", "0", "-1"])
def test_value_clips_with_a_tiny_stride_are_refused_before_they_are_listed(tmp_path: Path, stride: str) -> None:
    bomb = bombs.clips(tmp_path, f"double templateStride = {stride}")
    assert refusal(lambda: read_procedure(bomb, limits=LIMITS)).code is ProblemCode.USD_CLIPS


@POSIX
def test_a_tiny_stride_that_two_layers_make_together_is_refused(tmp_path: Path) -> None:
    whole = bombs.clips(tmp_path, "double templateStride = 1e-9").read_text(encoding="utf-8")
    span = [line for line in whole.splitlines() if "templateStartTime" in line or "templateEndTime" in line]
    lines = [line for line in whole.splitlines() if line not in span]
    (tmp_path / "over.usda").write_text("\n".join(lines).replace("sound.usda", "below.usda"), encoding="utf-8")
    below = "\n".join(line for line in whole.splitlines() if "templateStride" not in line)
    (tmp_path / "below.usda").write_text(below, encoding="utf-8")
    assert refusal(lambda: read_procedure(tmp_path / "over.usda", limits=SHORT), SHORT).code in SPENT


def test_archives_are_not_opened(tmp_path: Path) -> None:
    problem = refusal(lambda: read_mesh(bombs.zip_of_a_mesh(tmp_path, 64), limits=LIMITS))
    assert (problem.code, problem.value) == (ProblemCode.READ_KIND, ".zip")


def test_a_package_that_is_folded_is_not_read(tmp_path: Path) -> None:
    package = bombs.folded_package(tmp_path, 512)
    assert package.stat().st_size < 1 << 20
    with in_time(LIMITS), pytest.raises(RefusedError):
        read_mesh(package, limits=LIMITS)


def test_pictures_and_materials_are_not_read(tmp_path: Path) -> None:
    """A PNG of 400 million pixels, and then a pipe in the place of the materials."""
    mesh, _ = read_mesh(bombs.obj_with_a_large_picture(tmp_path, 20_000), limits=LIMITS)
    assert mesh.uv is not None
    assert np.allclose(mesh.uv[0], [(0, 0), (1, 0), (0, 1)])
    if os.name == "posix":
        (tmp_path / "skin.mtl").unlink()
        os.mkfifo(tmp_path / "skin.mtl")
        with in_time(LIMITS):
            read_mesh(tmp_path / "skin.obj", limits=LIMITS)


def chain(length: int) -> list[dict[str, object]]:
    return [*({"children": [i + 1]} for i in range(length - 1)), {"mesh": 0}]


def doubling(levels: int) -> list[dict[str, object]]:
    """Nodes of which each draws the next one twice."""
    return [*({"children": [i + 1, i + 1]} for i in range(levels)), {"mesh": 0}]


@pytest.mark.parametrize("nodes", [chain(50_000), doubling(40), [{"children": [0], "mesh": 0}]])
def test_nodes_that_are_no_tree_of_a_few_levels_are_refused(tmp_path: Path, nodes: list[dict[str, object]]) -> None:
    assert refusal(lambda: read_mesh(bombs.gltf(tmp_path, nodes=nodes), limits=LIMITS)).code is ProblemCode.MESH_NODES


def test_nodes_that_draw_a_mesh_too_often_are_refused(tmp_path: Path) -> None:
    nodes = [{"children": list(range(1, 300_001))}, *({"mesh": 0} for _ in range(300_000))]
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}} for _ in range(20)]}]
    bomb = bombs.gltf(tmp_path, nodes=nodes, meshes=meshes)
    assert refusal(lambda: read_mesh(bomb, limits=LIMITS)).code is ProblemCode.READ_RESULT_SIZE


ROW = {"componentType": 5126, "type": "VEC3"}


@pytest.mark.parametrize(
    "changed",
    [
        {"accessors": [{"count": 10**9, **ROW}]},
        {"accessors": [{"count": 10**9, "bufferView": 0, **ROW}]},
        {"accessors": [{"count": -1, "bufferView": 0, **ROW}]},
        {"accessors": [{"count": 4, "bufferView": 0, **ROW}]},
        {"bufferViews": [{"buffer": 0, "byteLength": 10**9}]},
        {"bufferViews": [{"buffer": 0, "byteOffset": -40, "byteLength": 36}]},
        {"buffers": [{"uri": "points.bin", "byteLength": 10**9}]},
    ],
)
def test_a_gltf_that_promises_more_than_it_holds_is_refused(tmp_path: Path, changed: dict[str, object]) -> None:
    problem = refusal(lambda: read_mesh(bombs.gltf(tmp_path, **changed), limits=LIMITS))
    assert problem.code is ProblemCode.MESH_SIZES


@pytest.mark.parametrize("text", ["[" * 100_000, "null", "{", '{"nodes": 3}', '{"accessors": [{"count": "x"}]}'])
def test_a_gltf_that_is_none_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "none.gltf").write_text(text)
    assert refusal(lambda: read_mesh(tmp_path / "none.gltf", limits=LIMITS)).code is ProblemCode.FILE_NO_MESH


def test_a_ply_and_an_stl_that_promise_more_than_they_hold_are_refused(tmp_path: Path) -> None:
    properties = "".join(f"property float {axis}\n" for axis in "xyz")
    remarks = "comment of somebody who has much to say\n" * 3000
    for kind, before in (("ascii", ""), ("binary_little_endian", ""), ("ascii", remarks)):
        ply = f"ply\nformat {kind} 1.0\n{before}element vertex 4000000000\n{properties}end_header\n"
        (tmp_path / "mesh.ply").write_text(ply)
        problem = refusal(lambda: read_mesh(tmp_path / "mesh.ply", limits=LIMITS))
        assert (problem.code, problem.value) == (ProblemCode.MESH_SIZES, "4000000000 elements")
    (tmp_path / "mesh.stl").write_bytes(bytes(80) + (4_000_000_000).to_bytes(4, "little") + bytes(50))
    assert refusal(lambda: read_mesh(tmp_path / "mesh.stl", limits=LIMITS)).code is ProblemCode.FILE_NO_TRIANGLES


def test_a_file_and_all_that_it_refers_to_together_may_not_be_too_large(tmp_path: Path) -> None:
    limits = ReadLimits(size=1 << 20)
    large = tmp_path / "large.stl"
    large.write_bytes(bytes((1 << 20) + 1))
    assert refusal(lambda: read_mesh(large, limits=limits)).code is ProblemCode.READ_SIZE
    over = bombs.with_prims(tmp_path, 'def "a" (\n    references = @./other.usda@</p>\n)\n{\n}\n')
    (tmp_path / "other.usda").write_text(
        bombs.HEADER.format(layers="") + 'def "p"\n{\n}\n' + "\n" * (1 << 20), encoding="utf-8"
    )
    assert refusal(lambda: read_procedure(over, limits=limits)).code is ProblemCode.READ_SIZE


@POSIX
@pytest.mark.parametrize("name", ["pipe.usda", "pipe.obj", "pipe.gltf", "pipe.usdz"])
def test_a_pipe_a_device_and_a_socket_are_not_read(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / name

    def code() -> ProblemCode:
        read = read_procedure if file.suffix == ".usda" else read_mesh
        return refusal(lambda: read(file, limits=LIMITS)).code

    os.mkfifo(file)
    assert code() is ProblemCode.READ_NOT_REGULAR
    file.unlink()
    file.symlink_to("/dev/zero")
    assert code() is ProblemCode.READ_NOT_REGULAR
    file.unlink()
    with socket.socket(socket.AF_UNIX) as listening:
        monkeypatch.chdir(tmp_path)  # the name of a socket is short
        listening.bind(name)
        assert code() is ProblemCode.READ_NOT_REGULAR


@POSIX
@pytest.mark.parametrize("arc", ["references", "payload"])
def test_a_pipe_that_a_layer_refers_to_is_not_opened(tmp_path: Path, arc: str) -> None:
    os.mkfifo(tmp_path / "pipe.usda")
    over = bombs.with_prims(tmp_path, f'def "a" (\n    {arc} = @./pipe.usda@\n)\n{{\n}}\n')
    assert refusal(lambda: read_procedure(over, limits=LIMITS)).code is ProblemCode.READ_NOT_REGULAR


@POSIX
def test_a_pipe_that_a_template_of_clips_names_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "clip.7.usda")
    over = bombs.clips(tmp_path, "double templateStride = 1")
    assert refusal(lambda: read_procedure(over, limits=LIMITS)).code is ProblemCode.READ_NOT_REGULAR


@POSIX
def test_a_pipe_is_no_table_of_costs(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "economy.json")
    assert refusal(lambda: measured_costs(tmp_path / "economy.json")).code is ProblemCode.ECONOMY_FILE
    (tmp_path / "deep.json").write_text("[" * 100_000)
    assert refusal(lambda: measured_costs(tmp_path / "deep.json")).code is ProblemCode.ECONOMY_FILE


@POSIX
def test_a_pipe_in_place_of_a_buffer_is_not_opened(tmp_path: Path) -> None:
    file = bombs.gltf(tmp_path)
    (tmp_path / "points.bin").unlink()
    os.mkfifo(tmp_path / "points.bin")
    assert refusal(lambda: read_mesh(file, limits=LIMITS)).code is ProblemCode.READ_NOT_REGULAR
