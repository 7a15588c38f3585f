"""A manifest whose frames are formulas: the slit patch of `synthetic_skin_cache`, shown without a solver.

Frames 1 to 12: whole (1-2), incised and lifted (3-7), sutured (8-12).
"""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1]))

import synthetic_skin_cache as slit
from lappet.background.manifest import EpochShape, ListedFrame, Manifest
from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.skin_shape import depth_below_skin
from lappet_blender.display import skin_display
from lappet_blender.solving import frames
from lappet_blender.solving.shown_frame import Shown
from lappet_blender.solving.solve_progress import Progress

SUTURES = 4
STEP = 2.5  # mm between vertices of the patch that is shown


def epoch_shape(step: float, cut: bool) -> EpochShape:
    """The surface of one of the two epochs. step: mm between vertices."""
    rest, triangles, origin = slit.patch(step, cut)
    points = rest.astype(np.float32)
    return EpochShape(
        key=hashlib.sha256(points.tobytes() + triangles.tobytes()).hexdigest(),
        start_time=float(slit.INCISED if cut else 1),
        rest=points,
        triangles=triangles,
        origin=origin,
        grid=points[triangles][:, :, :2].copy(),
        depth=depth_below_skin(points, triangles, origin),
        face=np.where(origin == 1, -1, np.arange(len(triangles))).astype(np.int32),
    )


def frame_at(shape: EpochShape, time: int, sutures: int, hooks: bool) -> SolvedFrame:
    """A frame by formula; strain is the displacement over 20 mm."""
    cut = time >= slit.INCISED
    rest = shape.rest.astype(np.float64)
    points = slit.deform(rest, time, cut)
    strain = (np.linalg.norm(points - rest, axis=1) / 20.0).astype(np.float32)
    places = np.linspace(-15.0, 15.0, sutures)
    ends = np.array([[(x, -0.1, 0.0), (x, 0.1, 0.0)] for x in places]).reshape(-1, 3)
    lips = np.array([(0.0, -0.1, 0.0), (0.0, 0.1, 0.0)]) if hooks else np.zeros((0, 3))
    marks = np.array([(-slit.HALF_SLIT, 0.0, 0.0), (slit.HALF_SLIT, 0.0, 0.0)])
    return SolvedFrame(
        float(time),
        points,
        strain=strain,
        stress=50.0 * strain,
        tension=40.0 * strain,
        landmark_index=np.arange(len(marks), dtype=np.int32),
        landmarks=slit.deform(marks, time, cut).astype(np.float64),
        hook_index=np.arange(len(lips), dtype=np.int32),
        hook_points=slit.deform(lips, time, cut).astype(np.float64),
        suture_index=np.arange(sutures, dtype=np.int32),
        suture_points=slit.deform(ends, time, cut).reshape(-1, 2, 3).astype(np.float64),
    )


def slit_manifest(step: float, name: str = "slit", sutures: int = SUTURES) -> tuple[Manifest, dict[int, SolvedFrame]]:
    """A manifest and its frames by time; name: makes its keys."""
    shapes = (epoch_shape(step, False), epoch_shape(step, True))
    listed, solved = [], {}
    for time in slit.FRAMES:
        epoch = int(time >= slit.INCISED)
        count = sutures if time > slit.LIFTED else 0
        hooks = slit.INCISED < time < slit.SUTURED
        key = hashlib.sha256(f"{name} {time}".encode()).hexdigest()
        listed.append(ListedFrame(time, epoch, key, (0, 1) if hooks else (), tuple(range(count))))
        solved[time] = frame_at(shapes[epoch], time, count, hooks)
    manifest = Manifest(
        key=hashlib.sha256(name.encode()).hexdigest(),
        epochs=shapes,
        frames=tuple(listed),
        hooks=("lower", "upper"),
        sutures=tuple(f"suture_{k + 1}" for k in range(sutures)),
        landmarks=("left apex", "right apex"),
        landmarks_at=((0, 1), (0, 1)),
    )
    return manifest, solved


@dataclass
class Solved:
    """Stands in for the solving side: what it knows of each scene, by the scene's name."""

    manifests: dict[str, tuple[Manifest, dict[int, SolvedFrame]]] = field(default_factory=dict)
    listeners: list[Callable[[bpy.types.Scene], None]] = field(default_factory=list)

    def shown_at(self, scene: bpy.types.Scene, time: float) -> Shown | None:
        if scene.name not in self.manifests:
            return None
        manifest, solved = self.manifests[scene.name]
        at = min(max(math.floor(time), manifest.frames[0].time), manifest.frames[-1].time)
        own = next(f for f in manifest.frames if f.time == at)
        return Shown(manifest, manifest.epochs[own.epoch], at, solved.get(at), stale=False)

    def manifest_of(self, scene: bpy.types.Scene) -> Manifest | None:
        return self.manifests[scene.name][0] if scene.name in self.manifests else None

    def frame_state(self, scene: bpy.types.Scene, time: float) -> str:
        return "solved" if scene.name in self.manifests and time in self.manifests[scene.name][1] else "missing"

    def progress_of(self, scene: bpy.types.Scene) -> Progress:
        return Progress(False, False, 0, 0, math.nan, 0, math.nan, math.nan, "", "")


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> Solved:
    """The stand-in, in place of `solving.frames`."""
    made = Solved()
    for name in ("shown_at", "manifest_of", "frame_state", "progress_of"):
        monkeypatch.setattr(frames, name, getattr(made, name))
    return made


def add_tissue(scene: bpy.types.Scene) -> bpy.types.Object:
    """The patch as the scene's tissue; the scene's unit is a centimetre, so that nothing hides behind 1 mm or 1 m."""
    scene.unit_settings.scale_length = 0.01
    rest, triangles, _ = slit.patch(10.0, False)
    mesh = bpy.data.meshes.new("patch")
    mesh.from_pydata((0.1 * rest).tolist(), [], triangles.tolist())
    tissue = bpy.data.objects.new("patch", mesh)
    scene.collection.objects.link(tissue)
    scene.lappet.tissue.object = tissue
    scene.frame_start, scene.frame_end = 1, 12
    return tissue


def show_slit(scene: bpy.types.Scene, solved: Solved, step: float) -> bpy.types.Scene:
    """The scene with the slit patch solved, of vertices so far apart (mm), at frame 1."""
    add_tissue(scene)
    solved.manifests[scene.name] = slit_manifest(step)
    skin_display.refresh(scene)
    return scene


@pytest.fixture
def shown(scene: bpy.types.Scene, solved: Solved) -> bpy.types.Scene:
    return show_slit(scene, solved, STEP)


def vertices(each: bpy.types.Object) -> NDArray[np.float32]:
    flat = np.empty(3 * len(each.data.vertices), np.float32)
    each.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)
