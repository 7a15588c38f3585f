"""The plan as lines of the world: what the overlay draws of each event at a frame. No drawing happens here."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from weakref import WeakKeyDictionary

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.dashed_line import dashes
from lappet.procedure.vessel import VESSEL_COLORS

from ..events.run_preview import stitches_of
from ..model.event_properties import LappetEvent
from ..model.mesh_values import GROUP
from ..model.suture_run_values import run_corners, run_insides
from ..model.vessel_values import KIND_OF
from .drawing import DrawnLine
from .handles import LINE_KINDS, event_points, is_closed
from .rest_line import beside, rest_samples, world_runs
from .shown_surface import Located, RestShape, ShownSurface

Color = tuple[float, float, float, float]
VIOLET: Color = (0.45, 0.18, 0.85, 1.0)
TEAL: Color = (0.05, 0.55, 0.55, 1.0)
THREAD: Color = (0.10, 0.22, 0.60, 1.0)
STEEL: Color = (0.25, 0.28, 0.33, 1.0)
WARM: Color = (0.90, 0.30, 0.15, 1.0)
GREEN: Color = (0.10, 0.50, 0.20, 1.0)
OCHRE: Color = (0.72, 0.50, 0.10, 0.7)
HALO: Color = (1.0, 0.72, 0.20, 0.9)
EVENT_COLORS = {
    "INCISION": VIOLET,
    "EXCISION": WARM,
    "UNDERMINE": TEAL,
    "THIN": OCHRE,
    "HOOK": STEEL,
    "RETRACTOR": STEEL,
    "SUTURE": THREAD,
    "SUTURE_RUN": THREAD,
    "LANDMARK": GREEN,
}
_LIP = 0.12  # mm from the middle of a cut to the line on either lip, beyond half the kerf
_WIDTH = 2.5
_MOST_LABELED = 4  # points of a landmark that have a label each


@dataclass
class LineSet:
    """Segments (2k, 3) of the world by (color, width in pixels), and labels (place, text, color)."""

    segments: dict[tuple[Color, float], list[NDArray[np.float64]]] = field(default_factory=dict)
    labels: list[tuple[NDArray[np.float64], str, Color]] = field(default_factory=list)

    def line(self, points: NDArray[np.float64], color: Color, width: float = _WIDTH) -> None:
        """Add a polyline (k, 3)."""
        if len(points) > 1:
            pairs = np.repeat(points, 2, axis=0)[1:-1]
            self.segments.setdefault((color, width), []).append(pairs)


_located: WeakKeyDictionary[RestShape, dict[Any, tuple[NDArray[np.float64], Located]]] = WeakKeyDictionary()


def event_color(event: LappetEvent) -> Color:
    """The line_set of an event; pale where it is switched off."""
    red, green, blue, alpha = EVENT_COLORS[event.kind]
    return (red, green, blue, alpha if event.enabled else 0.3)


def add_event_lines(line_set: LineSet, surface: ShownSurface, event: LappetEvent, time: float, active: bool) -> None:
    """Add what is drawn of an event at a frame: dashed while it is still to come, on both lips once it is cut."""
    color, future = event_color(event), time < event.start
    lines: list[NDArray[np.float64]] = []
    if event.kind in LINE_KINDS:
        offsets: tuple[float, ...] = (0.0,)
        if event.kind == "INCISION" and not future and surface.solved:
            offsets = (0.5 * event.kerf + _LIP, -0.5 * event.kerf - _LIP)
        for offset in offsets:
            lines += _runs(surface, event_points(event), event.basis, is_closed(event), offset)
    elif event.kind == "SUTURE":
        bites = event_points(event)
        for k in range(len(bites) - 1):
            lines += thread_lines(surface, bites[k : k + 2])
    elif event.kind == "SUTURE_RUN":
        lines += _stitch_lines(surface, event)
        edges = np.split(event_points(event), [event.second_from])
        for run in (run for edge in edges for run in _runs(surface, edge, "LINEAR", False)):
            line_set.line(run, (*color[:3], 0.5 * color[3]), 0.5 * _WIDTH)
    elif event.kind == "HOOK" and len(event.points) and event.target is not None:
        anchor = surface.carry(surface.rest.locate(event_points(event)[:1], skin_only=False))[0]
        lines += arrow(anchor, np.array(event.target.matrix_world.translation, np.float64))
    elif event.kind == "RETRACTOR":
        lines += _grip_lines(surface, event)
    elif event.kind in ("EXCISION", "LANDMARK"):
        lines += _marks(line_set, surface, event, color, active)
    over = event.kind in ("HOOK", "RETRACTOR") and time > event.end
    dashed = (future or event.kind in ("UNDERMINE", "THIN")) and event.kind not in ("LANDMARK", "EXCISION")
    for line in lines:
        if active:
            line_set.line(line, HALO, _WIDTH + 3.5)
        for part in dashes(line * surface.mm) if dashed and len(line) > 1 else [line * surface.mm]:
            line_set.line(part / surface.mm, (*color[:3], 0.25 * color[3]) if over else color)


def add_skin_lines(line_set: LineSet, surface: ShownSurface, scene: bpy.types.Scene) -> None:
    """Add the lines of the skin, thin: they are there at every time."""
    for line in scene.lappet.skin_lines:
        for run in _runs(surface, event_points(line), line.basis, False):
            line_set.line(run, OCHRE, 0.6 * _WIDTH)


def add_vessels(line_set: LineSet, surface: ShownSurface, scene: bpy.types.Scene) -> None:
    """Add where vessels run below the skin, in the colors of their kinds."""
    for vessel in scene.lappet.vessels:
        color = (*VESSEL_COLORS[KIND_OF[vessel.kind]], 1.0)
        for run in _runs(surface, event_points(vessel), vessel.basis, False):
            line_set.line(run, color, _WIDTH)


def add_preview_lines(line_set: LineSet, surface: ShownSurface, line: DrawnLine, color: Color = VIOLET) -> None:
    """Add a line that is being drawn."""
    for run in _runs(surface, np.array(line.points), line.basis, line.closed, keep=False):
        line_set.line(run, color, _WIDTH + 0.5)


def thread_lines(surface: ShownSurface, ends: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The line between the ends (2, 3) of a suture: along the skin, or straight where a wound gapes between them."""
    runs = _runs(surface, ends, "LINEAR", False)
    if len(runs) == 1 and len(runs[0]) == len(rest_samples(ends)):
        return runs
    located = surface.rest.locate(ends, skin_only=False)
    return [surface.carry(located) + surface.normals(located.triangle) * (0.3 / surface.mm)]


def _stitch_lines(surface: ShownSurface, event: LappetEvent) -> list[NDArray[np.float64]]:
    """The thread of each stitch of a run, straight from bite to bite, a little above the skin."""
    stitches = stitches_of(event.id_data, event)
    if not stitches:
        return []
    bites = np.array([anchor for suture in stitches for anchor in suture.anchors])
    lines = _located.setdefault(surface.rest, {})
    key = (bites.tobytes(), "SUTURE_RUN", False, 0.0)
    if key not in lines:
        lines[key] = (bites, surface.rest.locate(bites, skin_only=False))
    located = lines[key][1]
    world = surface.carry(located) + surface.normals(located.triangle) * (0.3 / surface.mm)
    return np.split(world, np.cumsum([len(suture.anchors) for suture in stitches])[:-1])


def arrow(start: NDArray[np.float64], end: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """An arrow as polylines: the shaft, and a head of four strokes."""
    way = end - start
    length = float(np.linalg.norm(way))
    lines = [np.stack([start, end])]
    if length > 0.0:
        along = way / length
        side = np.cross(along, [0.0, 0.0, 1.0] if abs(along[2]) < 0.9 else [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        for across in (side, -side, np.cross(along, side), -np.cross(along, side)):
            lines.append(np.stack([end, end - 0.18 * length * (along - 0.4 * across)]))
    return lines


def _runs(
    surface: ShownSurface,
    points: NDArray[np.float64],
    basis: str,
    closed: bool,
    offset: float = 0.0,
    keep: bool = True,
) -> list[NDArray[np.float64]]:
    if len(points) < 2:
        return []
    lines = _located.setdefault(surface.rest, {})
    key = (points.tobytes(), basis, closed, offset)
    if key not in lines or not keep:
        samples = beside(surface.rest, points, basis, closed, offset) if offset else rest_samples(points, basis, closed)
        found = (samples, surface.rest.locate(samples))
        if not keep:
            return world_runs(surface, *found)
        if len(lines) > 500:
            lines.clear()
        lines[key] = found
    return world_runs(surface, *lines[key])


def _marks(
    line_set: LineSet, surface: ShownSurface, event: LappetEvent, color: Color, active: bool
) -> list[NDArray[np.float64]]:
    """A cross on the skin at each point, with the landmark's label.

    A landmark of many points follows an edge: its crosses are small, and its label stands once, while it is active.
    """
    rest = event_points(event)
    located = surface.rest.locate(rest, skin_only=False)
    there = np.linalg.norm(surface.rest.at(located) - rest, axis=1) <= 1.0
    world, normals = surface.carry(located), surface.normals(located.triangle)
    row = event.kind == "LANDMARK" and len(rest) > _MOST_LABELED
    labeled = int(np.count_nonzero(there)) // 2 if row and active else -1
    lines = []
    for k, (place, normal) in enumerate(zip(world[there], normals[there], strict=True)):
        u = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < 0.9 else [0.0, 1.0, 0.0])
        u /= np.linalg.norm(u)
        size = (0.3 if row else 1.2) / surface.mm
        for across in (u, np.cross(normal, u)):
            lifted = place + normal * (0.2 / surface.mm)
            lines.append(np.stack([lifted - size * across, lifted + size * across]))
        if event.kind == "LANDMARK" and (not row or k == labeled):
            line_set.labels.append((place, event.label or event.name, color))
    return lines


def _grip_lines(surface: ShownSurface, event: LappetEvent) -> list[NDArray[np.float64]]:
    """The border of the faces that a retractor grips, and an arrow from their middle to its target."""
    tissue = event.id_data.lappet.tissue.object
    attribute = tissue.data.attributes.get(GROUP + event.grip) if tissue is not None else None
    if attribute is None or attribute.data_type != "BOOLEAN" or attribute.domain != "FACE":
        return []
    inside = np.zeros(len(attribute.data), bool)
    attribute.data.foreach_get("value", inside)
    face = surface.rest.face
    held = np.flatnonzero((face >= 0) & (face < len(inside)) & inside[np.clip(face, 0, len(inside) - 1)])
    if len(held) == 0:
        return []
    triangles = surface.rest.triangles[held]
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    border, uses = np.unique(edges, axis=0, return_counts=True)
    lines = [surface.positions[edge] for edge in border[uses == 1]]
    if event.target is not None:
        middle = surface.positions[np.unique(triangles)].mean(axis=0)
        lines += arrow(middle, np.array(event.target.matrix_world.translation, np.float64))
    return lines


def plan_key(scene: bpy.types.Scene) -> tuple[Any, ...]:
    """Change whenever what is drawn of a scene's events may change, apart from the surface and the frame."""
    rows: list[tuple[Any, ...]] = []
    for e in scene.lappet.events:
        target = tuple(e.target.matrix_world.translation) if e.target is not None else ()
        points = event_points(e).tobytes()
        rows.append((e.uid, e.enabled, e.start, e.end, e.basis, e.closed, e.kerf, e.grip, e.label, points, target))
        if e.kind == "SUTURE_RUN":
            layers = tuple((each.name, each.depth, each.between) for each in e.layers)
            corners = (run_corners(e), run_insides(e))
            rows.append((e.second_from, e.spacing, e.margin, e.bite, e.pattern, e.pass_depth, layers, corners))
    lines = tuple((line.basis, event_points(line).tobytes()) for line in scene.lappet.skin_lines)
    vessels = tuple((each.kind, each.basis, event_points(each).tobytes()) for each in scene.lappet.vessels)
    return (scene.lappet.active_event, tuple(rows), lines, vessels)
