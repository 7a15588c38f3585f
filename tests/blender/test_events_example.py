"""The README's Z-plasty, built through operators, is the one that its script builds without Blender."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np

from lappet.procedure import Hook, Incision, Landmark, Suture, Undermine
from lappet_blender.model.scene_procedure import read_scene

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def module(path: Path) -> ModuleType:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def places(event: object) -> np.ndarray:
    """Every place of an event, (k, 3) mm."""
    match event:
        case Hook():
            return np.array([event.anchor, *(place for _, place in event.targets)])
        case Suture():
            return np.array(event.anchors)
        case Incision() | Undermine() | Landmark():
            return np.array(event.points)
    raise AssertionError(event)


def test_the_z_plasty_made_through_operators_is_that_of_the_example(scene: bpy.types.Scene) -> None:
    module(EXAMPLES / "z_plasty_blender.py").build()
    made = read_scene(bpy.context.scene)
    assert made.procedure is not None, made.problems
    wanted = module(EXAMPLES / "z_plasty" / "build.py").build()
    found = made.procedure
    assert (found.start_time, found.end_time, found.fps) == (wanted.start_time, wanted.end_time, wanted.fps)
    assert [(type(each), each.name) for each in found.events] == [(type(each), each.name) for each in wanted.events]
    for one, other in zip(found.events, wanted.events, strict=True):
        np.testing.assert_allclose(places(one), places(other), atol=1e-3, err_msg=one.name)
        match one, other:
            case Hook(), Hook():
                np.testing.assert_allclose([t for t, _ in one.targets], [t for t, _ in other.targets], atol=1e-4)
                assert replace(one, anchor=other.anchor, targets=other.targets) == other
            case Suture(), Suture():
                assert replace(one, anchors=other.anchors) == other
            case _:
                assert replace(one, points=other.points) == other
    assert found.materials == wanted.materials
    tissue, patch = found.tissue, wanted.tissue
    assert (tissue.material, tissue.spacing, tissue.gravity) == (patch.material, patch.spacing, patch.gravity)
    np.testing.assert_allclose(np.ptp(tissue.points, axis=0), np.ptp(patch.points, axis=0), atol=1e-5)
    for name in ("fixed", "bed"):
        assert area(tissue, name) == np.float64(area(patch, name)).round(6)


def area(tissue: object, name: str) -> float:
    """The area of a group of faces (quadrilaterals), mm²."""
    corners = tissue.points[tissue.face_vertex_indices.reshape(-1, 4)[tissue.subsets[name]]]
    diagonals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return float((0.5 * np.linalg.norm(diagonals, axis=1).sum()).round(6))


def test_the_script_runs_by_itself_and_saves_what_it_made(tmp_path: Path) -> None:
    blend, usd = tmp_path / "z.blend", tmp_path / "z.usda"
    command = [sys.executable, str(EXAMPLES / "z_plasty_blender.py"), "--spacing", "2"]
    paths = os.pathsep.join(each for each in sys.path if each.endswith(("shared", "addon")))
    run = subprocess.run(
        [*command, "--save", str(blend), "--export", str(usd)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr[-2000:]
    assert usd.read_text().count("LappetSutureAPI") == 102
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert len(bpy.context.scene.lappet.events) == 110
    assert bpy.context.scene.lappet.tissue.spacing == 2.0
