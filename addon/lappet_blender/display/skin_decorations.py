"""What a shown skin wears: bed, wound edge, pen marks, stitches, hooks and landmarks, one mesh object each."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.background.manifest import Manifest
from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.epoch_searches import EpochSearches
from lappet.drawing.framing import SurgicalField, field_around
from lappet.drawing.hook_steel import HookSteel
from lappet.drawing.skin_fields import SKIN, WOUND_WALL
from lappet.drawing.skin_marks import SkinMarks
from lappet.drawing.skin_source import SkinEpoch
from lappet.drawing.suture_thread import SutureThread
from lappet.drawing.wound_edge import WoundEdge
from lappet.procedure import VESSEL_KINDS

from ..look.mesh_edges import MeshEdges, mesh_edges
from ..look.skin_import import fill_mesh, set_attribute
from ..look.tube import TOPOLOGY, draw_tubes
from ..look.vessel_tubes import VesselTubes
from ..model.made_soon import MadeSoon
from .display_collection import find_object, make_object, place, set_visible
from .epoch_mesh import is_large
from .look_materials import part_material
from .manifest_source import ManifestSource
from .sphere_shape import spheres
from .time_slice import TimeSlice

_log = logging.getLogger(__name__)
BEAD_RADIUS = 0.45
Tubes = tuple[list[NDArray[np.float64]], list]


@dataclass(frozen=True)
class Where:
    """Where a skin is drawn. prefix: of the roles of its objects. units: Blender units per mm. offset: in them."""

    collection: bpy.types.Collection
    prefix: str
    units: float
    offset: tuple[float, float, float]


class SkinDecorations:
    """The parts of one manifest; what is costly is found once an epoch."""

    def __init__(self, source: ManifestSource, before: SkinDecorations | None = None) -> None:
        """before: what was drawn until now; where its epochs are the same, what was found of them is kept."""
        self.source = source
        kept = before if before is not None and before.fits(source.manifest) else None
        self._searches: EpochSearches = kept._searches if kept else EpochSearches()
        self._preparing: dict[tuple[str, bool, bool], MadeSoon[None]] = kept._preparing if kept else {}
        self.field: SurgicalField = kept.field if kept else manifest_field(source)
        self._axes = np.stack([self.field.right, self.field.up, self.field.normal])
        self._scale = self.field.stitch_scale
        self._edge: WoundEdge = kept._edge if kept else WoundEdge(source, self._searches)
        self._bed: DeepBed | None = kept._bed if kept else None
        self._bed_edges: MeshEdges | None = kept._bed_edges if kept else None
        self._edge.source = source
        if self._bed is not None:
            self._bed.source = source
        self._marks: SkinMarks = SkinMarks(source, kept._marks if kept else None, self._searches)
        self._thread: SutureThread = self._new_thread(kept._thread if kept else None)
        self._hooks: HookSteel | None = None
        self._known: tuple[float | None, ...] = ()

    def fits(self, manifest: Manifest) -> bool:
        """Whether what was found of the epochs holds for those of a manifest as well."""
        return self.source.has_epochs_of(manifest)

    def events_changed(self, scene: bpy.types.Scene) -> None:
        """The scene's events are others now: the pen marks follow."""
        self.source.read_events(scene)
        self._marks = SkinMarks(self.source, self._marks, self._searches)

    def frames_changed(self) -> None:
        """Frames have come or gone: where stitches bite and hooks point is found anew if that tells something new."""
        self.source.frames_changed()
        known = tuple(self.source.last_known(epoch) for epoch in self.source.epochs)
        if known != self._known:
            self._known = known
            self._thread = self._new_thread(self._thread)
            self._hooks = None

    def draw(self, where: Where, time: float, look: bpy.types.PropertyGroup, time_slice: TimeSlice) -> None:
        """Draw a frame; a part that cannot be drawn is left out, and so is, for now, one that the turn puts off."""
        epoch = self.source.epoch_at(time)
        if time_slice.soon and is_large(self.source.shape(epoch)) and not time_slice.has(self._prepared(epoch)):
            return
        ready = time_slice.begins(not self._edge.knows(epoch))
        self._tubes(where, "edge", "Wound edge", 6, ready, lambda: self._edge.tubes(time))
        self._marks.until = time_slice.until
        self._thread.begin = MadeSoon if time_slice.soon and is_large(self.source.shape(epoch)) else None
        self._tubes(where, "ink", "Marks", 6, look.show_plan, lambda: self._marks.tubes(time))
        time_slice.unfinished |= look.show_plan and self._marks.unfinished
        self._tubes(where, "thread", "Sutures", 6, look.show_sutures, lambda: self._thread.tubes(time))
        if (found := self._thread.pending) is not None:
            time_slice.has(found)
        wanted = look.show_hooks and time_slice.begins(self._hooks is None or not self._hooks.knows(epoch))
        self._tubes(where, "steel", "Hooks", 12, wanted, lambda: self._steel().tubes(time))
        if time_slice.begins(self._bed is None and has_wound(epoch)):
            self._draw_bed(where, time)
        self._draw_landmarks(where, time, look.show_landmarks)
        self._draw_vessels(where, time, look.show_vessels)

    def prepare(self, epoch: SkinEpoch) -> None:
        """Find what drawing an epoch takes longest to find; touches nothing of Blender's."""
        rest = self.source.rest(epoch)
        self._searches.chains(epoch)
        self._searches.skin_and_rim(epoch, len(rest))
        if self.source.manifest.sutures:
            self._searches.near(epoch, rest)
        if self._marks.rides_on(epoch):
            self._searches.bites(epoch, rest)
        if has_wound(epoch):
            if self._bed is None:
                self._bed = DeepBed(self.source)
            self._bed.underside(epoch)
            if self._bed_edges is None:
                self._bed_edges = mesh_edges(self._bed.triangles, len(self._bed))

    def _prepared(self, epoch: SkinEpoch) -> MadeSoon[None]:
        """What is made ready for an epoch; anew where an edit asks for more."""
        wanted = (epoch.name, bool(self.source.manifest.sutures), self._marks.rides_on(epoch))
        if wanted not in self._preparing:
            self._preparing[wanted] = MadeSoon(partial(self.prepare, epoch))
        return self._preparing[wanted]

    def _draw_vessels(self, where: Where, time: float, wanted: bool) -> None:
        for kind in VESSEL_KINDS:
            tubes = VesselTubes(self.source, kind)
            self._tubes(where, kind, f"Vessels: {kind}", 12, wanted, partial(tubes.tubes, time))
        lumen = VesselTubes(self.source, "", lumen=True)
        self._tubes(where, "lumen", "Vessels: lumen", 12, wanted, partial(lumen.tubes, time))

    def _new_thread(self, before: SutureThread | None) -> SutureThread:
        return SutureThread(
            self.source, self._axes[0] + 0.6 * self._axes[1], self._scale, before=before, searches=self._searches
        )

    def _steel(self) -> HookSteel:
        if self._hooks is None:
            self._hooks = HookSteel(self.source, self._axes, self.field.center, self._scale, self._searches)
        return self._hooks

    def _tubes(self, where: Where, role: str, name: str, sides: int, wanted: bool, tubes: Callable[[], Tubes]) -> None:
        lines, radii = _tried(tubes, name) if wanted else ([], [])
        target = _part(where, role, name, bool(lines))
        if target is not None:
            draw_tubes(target, lines, radii, sides, where.units)

    def _draw_bed(self, where: Where, time: float) -> None:
        epoch = self.source.epoch_at(time)
        open_wound = has_wound(epoch)
        if open_wound and self._bed is None:
            self._bed = DeepBed(self.source)
        target = _part(where, "bed", "Bed", open_wound and self._bed is not None and len(self._bed) > 0)
        if target is None or self._bed is None:
            return
        bed = self._bed
        points = bed.positions(time) * np.float32(where.units)
        made_for = f"bed {self.source.manifest.epochs[0].key}"
        if _topology(target.data, made_for, points, bed.triangles, self._bed_edges):
            set_attribute(target.data, "rest", "FLOAT_VECTOR", "POINT", bed.rest.astype(np.float32))

    def _draw_landmarks(self, where: Where, time: float, wanted: bool) -> None:
        frame = self.source.frame(time)
        at = None if frame is None or not wanted else frame.landmarks
        at = np.zeros((0, 3)) if at is None else at[np.isfinite(at).all(axis=1)]
        target = _part(where, "landmark", "Landmarks", len(at) > 0)
        if target is not None:
            points, triangles = spheres(at, BEAD_RADIUS * self._scale)
            _topology(target.data, f"{len(at)} beads", (points * where.units).astype(np.float32), triangles)


def has_wound(epoch: SkinEpoch) -> bool:
    """Whether an epoch's tissue is cut."""
    return bool((epoch.origin == WOUND_WALL).any())


def manifest_field(source: ManifestSource) -> SurgicalField:
    """The field that wounds and hooks take up at rest, with its directions; all skin where there is none."""
    first = source.epochs[0]
    rest = source.rest(first).astype(np.float64)
    walls = [source.rest(e)[np.unique(e.triangles[e.origin == WOUND_WALL])] for e in source.epochs]
    return field_around(np.concatenate(walls).astype(np.float64), rest, first.triangles[first.origin == SKIN])


def _part(where: Where, role: str, name: str, wanted: bool) -> bpy.types.Object | None:
    """The object of a part, in its place; None, and hidden, where nothing is to be seen of it."""
    full = f"{where.prefix}{role}"
    found = find_object(where.collection, full)
    if not wanted:
        if found is not None:
            set_visible(found, False)
        return None
    target = make_object(where.collection, full, name)
    place(target, where.offset)
    set_visible(target, True)
    target.hide_select = True
    material = part_material(where.collection, role, where.units)
    if not target.data.materials:
        target.data.materials.append(material)
    elif target.data.materials[0] != material:
        target.data.materials[0] = material
    return target


def _topology(
    mesh: bpy.types.Mesh,
    made_for: str,
    points: NDArray[np.float32],
    triangles: NDArray[np.int32],
    edges: MeshEdges | None = None,
) -> bool:
    """Set positions, and the triangles too where the mesh is not the one of that name yet (True)."""
    if mesh.get(TOPOLOGY) == made_for and len(mesh.vertices) == len(points):
        mesh.attributes["position"].data.foreach_set("vector", points.ravel())
        mesh.update()
        return False
    mesh.clear_geometry()
    fill_mesh(mesh, points, triangles, edges)
    mesh[TOPOLOGY] = made_for
    return True


def _tried(tubes: Callable[[], Tubes], name: str) -> Tubes:
    try:
        return tubes()
    except Exception:  # a part of a damaged frame is left out; the skin is shown all the same
        _log.warning("The %s of this frame cannot be drawn.", name.lower(), exc_info=_log.isEnabledFor(logging.DEBUG))
        return [], []
