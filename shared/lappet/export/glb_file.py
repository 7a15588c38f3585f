"""`lappet export CACHE.usdc -o X.glb`: glTF, with a mesh for each epoch that morphs from frame to frame.

Morph targets are the frames. Scale switches between meshes (of what is scaled to nothing glTF says that it need not be
drawn), and so does visibility, for programs that know KHR_node_visibility and KHR_animation_pointer. Each step of the
operation is an animation besides the one of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lappet.core.durable import draft_folder, replace_durably
from lappet.core.problem import problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.core.version import version
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.drawing.surface_look import SKIN_LOOK, SurfaceLook
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache, exported_frames
from lappet.export.glb_container import VERTICES, GlbContainer
from lappet.export.glb_meshopt import MESHOPT
from lappet.export.glb_quantized import EXTENSION, QuantizedShape, glb_error
from lappet.export.grid_tile import grid_tile
from lappet.export.meshopt_package import meshopt
from lappet.export.moving_shape import MovingShape
from lappet.export.moving_skin import bed_shape, scenery_shapes, skin_shapes
from lappet.export.moving_tubes import instrument_shapes, vessel_shapes
from lappet.export.simplified_cache import simplified
from lappet.export.size_limit import check_size
from lappet.output.named_steps import operation_steps

VISIBILITY, POINTER = "KHR_node_visibility", "KHR_animation_pointer"
STILL_MM = 0.002  # a vertex that a frame moves by less does not move
STILL_NORMAL = 0.004
MOST_DRIFT = 0.05  # mm: how far whole numbers may move a vertex
WHOLE = "Operation"
_HALF = 0.5**0.5


def write_glb(request: ExportRequest) -> list[Path]:
    """Write a solved procedure as binary glTF 2.0.

    Parameters
    ----------
    request
        The cache, the file and the options `frames`, `simplify`, `quantized`, `meshopt`, which is quantized
        too, and `max_size`.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If the cache cannot be read or shown, has no such frame, or is too large to be quantized.
    OSError
        If the file cannot be written.
    """
    packed = bool(request.options.get("meshopt"))
    if packed:
        meshopt()
    cache = exported_cache(request.caches[0], request.limits)
    frames = exported_frames(cache, request)
    cache = simplified(cache, frames, request)
    try:
        shapes = skin_shapes(cache, frames)
        bed = bed_shape(cache, frames)
        shapes += [bed] if bed else []
        shapes += instrument_shapes(cache, frames) + vessel_shapes(cache, frames)
        shapes += scenery_shapes(cache, frames)
        spans = named_spans(cache, frames)
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    quantized = packed or bool(request.options.get("quantized"))
    document = _GlbDocument(frames, cache.fps, cache.path.stem, quantized, packed)
    target, drift = request.target.resolve(), 0.0
    with draft_folder(target) as folder:
        draft = folder / target.name
        document.write(shapes, spans, draft)
        check_size(request, draft.stat().st_size)
        if quantized:
            drift = glb_error(draft, shapes)
        if drift > MOST_DRIFT:
            raise refused(ProblemCode.EXPORT_DRIFT, request.target, f"{drift:.3f}", most=MOST_DRIFT)
        replace_durably(draft, target)
    if quantized:
        request.note(problem(ProblemCode.EXPORT_DRIFT_FOUND, request.target, f"{drift:.4f}"))
    return [request.target]


def named_spans(cache: SkinCache, frames: Sequence[float]) -> list[tuple[str, tuple[float, ...]]]:
    """Divide frames into the steps of the operation, each from the end of the one before it on.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes, ascending.

    Returns
    -------
    list[tuple[str, tuple[float, ...]]]
        The name of each step that has frames, numbered, and its frames; before them all frames as `WHOLE`.
    """
    spans = [(WHOLE, tuple(frames))]
    begin = cache.frames[0]
    for number, step in enumerate(operation_steps(cache), start=1):
        own = tuple(time for time in frames if begin <= time <= step.frame)
        if own:
            spans.append((f"{number} {step.caption}", own))
        begin = step.frame
    return spans


class _GlbDocument:
    """A file that is being made. Every mesh is, as long as no animation plays, as in its last frame."""

    def __init__(self, frames: tuple[float, ...], fps: float, title: str, quantized: bool, packed: bool) -> None:
        self._frames, self._fps, self._title, self._quantized = frames, fps, title, quantized
        self._container = GlbContainer(packed)
        self._materials: dict[str, int] = {}
        self._looks: list[dict[str, Any]] = []
        self._images: list[dict[str, Any]] = []

    def write(self, shapes: Sequence[MovingShape], spans: Sequence[tuple[str, tuple[float, ...]]], path: Path) -> None:
        meshes = [self._mesh(shape) for shape in shapes]
        nodes: list[dict[str, Any]] = [
            {
                "name": self._title,
                "rotation": [-_HALF, 0.0, 0.0, _HALF],  # Z up to Y up
                "scale": [0.001] * 3,  # millimetres to metres
                "children": list(range(1, len(shapes) + 1)),
            }
        ]
        for number, shape in enumerate(shapes):
            node: dict[str, Any] = {"name": shape.name, "mesh": number}
            if self._quantized:
                # What switches the shape scales the node above that which says what its numbers are.
                node = {"name": f"{shape.name} shown", "children": [self._mesh_node(number, len(shapes))]}
            shown = self._frames[-1] in shape.frames
            if len(shape.frames) < len(self._frames):
                node["extensions"] = {VISIBILITY: {"visible": shown}}
            nodes.append(node if shown else {**node, "scale": [0.0] * 3})
        if self._quantized:
            own = [QuantizedShape.of(shape).node for shape in shapes]
            nodes += [{"name": shapes[k].name, "mesh": k, **each} for k, each in enumerate(own)]
        animations = [self._animation(name, own, shapes) for name, own in spans]
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"Lappet {version()}"},
            "scene": 0,
            "scenes": [{"name": self._title, "nodes": [0]}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": self._looks,
            "animations": [each for each in animations if each["channels"]],
        }
        if not document["animations"]:
            del document["animations"]
        if self._images:
            document["images"], document["textures"] = self._images, [{"source": 0, "sampler": 0}]
            document["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}]
        required = [EXTENSION] if self._quantized else []
        required += [MESHOPT] if self._container.compressed else []
        if required:
            document["extensionsRequired"] = required
        switched = any("extensions" in node for node in nodes)
        if required or switched:
            document["extensionsUsed"] = required + ([VISIBILITY, POINTER] if switched else [])
        self._container.write(document, path)

    def _mesh_node(self, number: int, count: int) -> int:
        """The node that has a shape's mesh."""
        return 1 + number + (count if self._quantized else 0)

    def _mesh(self, shape: MovingShape) -> dict[str, Any]:
        put = self._container
        if self._quantized:
            numbers = QuantizedShape.of(shape)
            attributes = numbers.attributes(put, shape)
            still = (STILL_MM, STILL_NORMAL)
            moving = range(len(shape.frames) - 1) if self._moves(shape) else ()
            targets = [numbers.target(put, shape, frame, still) for frame in moving]
        else:
            attributes, targets = self._as_floats(shape)
        printed = {**attributes, "TEXCOORD_0": put.floats(shape.grid, VERTICES)} if shape.grid is not None else None
        primitives = []
        for look, triangles in shape.parts:
            if len(triangles):
                with_grid = look is SKIN_LOOK and printed is not None
                primitive: dict[str, Any] = {
                    "attributes": printed if with_grid else attributes,
                    "indices": put.indices(triangles, shape.positions.shape[1]),
                    "material": self._material(look, with_grid),
                }
                primitives.append({**primitive, "targets": targets} if targets else primitive)
        mesh: dict[str, Any] = {"name": shape.name, "primitives": primitives}
        if targets:
            mesh["weights"] = [0.0] * len(targets)
            mesh["extras"] = {"targetNames": [f"frame {time:g}" for time in shape.frames[:-1]]}
        return mesh

    def _as_floats(self, shape: MovingShape) -> tuple[dict[str, int], list[dict[str, int]]]:
        put = self._container
        base, normals = shape.positions[-1], shape.normals[-1]
        attributes = {"POSITION": put.floats(base, VERTICES, True), "NORMAL": put.floats(normals, VERTICES)}
        targets = [
            {
                "POSITION": put.displacements(points - base, STILL_MM, True),
                "NORMAL": put.displacements(shading - normals, STILL_NORMAL, False),
            }
            for points, shading in zip(shape.positions[:-1], shape.normals[:-1], strict=True)
            if self._moves(shape)
        ]
        return attributes, targets

    @staticmethod
    def _moves(shape: MovingShape) -> bool:
        return bool((shape.positions != shape.positions[-1]).any())

    def _material(self, look: SurfaceLook, printed: bool) -> int:
        name = f"{look.title} with grid" if printed else look.title
        if name not in self._materials:
            surface: dict[str, Any] = {
                "baseColorFactor": [*(round(each, 5) for each in look.color), 1.0],
                "metallicFactor": look.metallic,
                "roughnessFactor": look.roughness,
            }
            if printed:
                self._images.append({"bufferView": self._container.view(grid_tile()), "mimeType": "image/png"})
                surface["baseColorTexture"] = {"index": 0}
            self._materials[name] = len(self._looks)
            self._looks.append({"name": name, "pbrMetallicRoughness": surface})
        return self._materials[name]

    def _animation(self, name: str, frames: tuple[float, ...], shapes: Sequence[MovingShape]) -> dict[str, Any]:
        samplers: list[dict[str, Any]] = []
        channels: list[dict[str, Any]] = []
        inputs: dict[tuple[float, ...], int] = {}

        def add(target: dict[str, Any], times: tuple[float, ...], output: int, interpolation: str) -> None:
            if times not in inputs:
                seconds = (np.array(times) - frames[0]) / self._fps
                inputs[times] = self._container.floats(seconds, box=True)
            samplers.append({"input": inputs[times], "output": output, "interpolation": interpolation})
            channels.append({"sampler": len(samplers) - 1, "target": target})

        for number, shape in enumerate(shapes, start=1):
            own = tuple(time for time in frames if time in shape.frames)
            if own and len(shape.frames) > 1 and self._moves(shape):
                rows = [shape.frames.index(time) for time in own]
                weights = np.eye(len(shape.frames))[rows, :-1]
                target = {"node": self._mesh_node(number - 1, len(shapes)), "path": "weights"}
                add(target, own, self._container.floats(weights.ravel()), "LINEAR")
            if len(shape.frames) < len(self._frames):
                shown = np.array([time in shape.frames for time in frames], np.float32)
                changes = [0, *(k for k in range(1, len(frames)) if shown[k] != shown[k - 1])]
                times = tuple(frames[k] for k in changes)
                scale = self._container.floats(np.repeat(shown[changes, None], 3, axis=1))
                add({"node": number, "path": "scale"}, times, scale, "STEP")
                pointer = {"pointer": f"/nodes/{number}/extensions/{VISIBILITY}/visible"}
                target = {"path": "pointer", "extensions": {POINTER: pointer}}
                add(target, times, self._container.switches(shown[changes] > 0), "STEP")
        return {"name": name, "samplers": samplers, "channels": channels}
