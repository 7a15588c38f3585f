"""Compile a procedure and its epochs to the program that the daemon is told: per frame, the constraints."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.vessel_crossings import VesselCrossing, crossing_warnings, vessel_crossings
from lappet.anatomy.vessel_pieces import VesselCutter, VesselPieces, vessel_course
from lappet.core.problem import Place, Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.geometry.closest_point import ClosestPoint
from lappet.procedure import Event, Hook, Landmark, Material, Point, Procedure, Retractor, Section, Suture
from lappet.procedure.prim_paths import ROOT
from lappet.program.anchors import OFF_TISSUE, AnchorSearch, PlacedAnchors, TissueLoss
from lappet.program.bones import bone_motions, over_bone, united_bones
from lappet.program.boundary import with_boundaries
from lappet.program.crossed_sutures import crossed_sutures
from lappet.program.fixed_parts import FixedParts
from lappet.program.ground import on_ground
from lappet.program.materials import activation, materials_in_use, parameters, region_program, with_line_tension
from lappet.program.program import FrameConstraints, Landmarks, Program
from lappet.program.settings import SolverSettings, for_tissue
from lappet.program.strands import strand_program
from lappet.program.thinned_stitches import out_from
from lappet.program.timed_events import EventAnchors, TimedEvents, event_path
from lappet.suturing.single_sutures import with_single_sutures
from lappet.tissue.rest_space import RestSpace
from lappet.tissue.surface import tissue_surface

DEFAULT = SolverSettings()


def compile_program(
    procedure: Procedure,
    epochs: Sequence[Epoch] | None = None,
    settings: SolverSettings = DEFAULT,
    *,
    until: float | None = None,
) -> Program:
    """Compile a procedure: a frame for every integer time code from its start to its end.

    A frame belongs to the last epoch that starts at or before it. Hook targets are linear between samples and held at
    the ends. A hook or retractor acts from `start` until before `release`; a suture from `start` on, its closure
    growing linearly over `duration`; the stitches of suture runs are sutures.

    Parameters
    ----------
    procedure
        The procedure.
    epochs
        Its epochs in order, as `lappet.cutting.epochs` makes them; made here when None.
    settings
        How to solve; what they say of the tissue is replaced by the procedure's own.
    until
        Time code after which frames are left out.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    RefusedError
        If an anchor is off the tissue or its tissue is excised, two retractors grip one face, a motion is not rigid, a
        bone is not closed, the timeline has no frame, or a material or the faces of a region are not there; names the
        prim.
    """
    settings = for_tissue(settings, procedure.tissue)
    procedure = with_single_sutures(procedure, settings.spacing)
    if epochs is None:
        epochs = build_epochs(replace(procedure, tissue=replace(procedure.tissue, spacing=settings.spacing)))
    materials = with_line_tension(procedure, materials_in_use(procedure))
    epochs = _with_inside(epochs, procedure, materials)
    times = [time for time in frame_times(procedure) if until is None or time <= until]
    events = TimedEvents.of(procedure)
    moved_bones = dict(zip(times, bone_motions(procedure.bones, procedure.start_time, times), strict=True))
    own_times = {epoch.index: [time for time in times if _epoch_at(epochs, time) == epoch.index] for epoch in epochs}
    parts = FixedParts.of(procedure.tissue)
    epochs = with_boundaries(epochs, procedure.tissue, parts, events, own_times, bool(settings.self_contact))
    loss = _tissue_loss(procedure)
    off = loss.distance(events.anchors())
    out, come_out = out_from(epochs, events.sutures)
    vessels, crossings = _vessels(procedure, epochs, settings.spacing)
    frames: list[FrameConstraints] = []
    grips: list[NDArray[np.int32]] = []
    landmarks: list[Landmarks] = []
    moved: dict[Problem, None] = {}
    for epoch in epochs:
        own = own_times[epoch.index]
        grips.append(_grips(epoch, events.retractors, own))
        in_tissue = _AnchorsInTissue.of(epoch, events, loss, off, out)
        landmarks.append(in_tissue.landmarks(vessels[epoch.index]))
        anchors_of = in_tissue.event_anchors(own)
        moved.update((each, None) for each in in_tissue.moved(own))
        for time in own:
            acting = {**events.arrays(time, anchors_of), "activation": activation(materials, time)}
            acting["bone_motion"] = moved_bones[time]
            frames.append(FrameConstraints(float(time), epoch.index, **acting))
    crossed = crossed_sutures(epochs, frames, events.sutures, settings.spacing)
    return Program(
        epochs=tuple(epochs),
        frames=tuple(frames),
        settings=_with_tissue(settings, procedure, events, materials),
        fps=procedure.fps,
        hooks=tuple(hook.name for hook in events.hooks_by_start),
        stitches=events.sutures,
        retractors=tuple(retractor.name for retractor in events.retractors),
        landmarks=_labels(events.marks),
        fixed_parts=parts.names,
        rollers=tuple(roller.faces for roller in procedure.tissue.rollers),
        loads=events.loaded,
        sections=_section_labels(events.sections),
        grips=tuple(grips),
        landmarks_at=tuple(landmarks),
        vessels=procedure.vessels,
        vessels_at=tuple(vessels.values()),
        vessel_crossings=crossings,
        bones=united_bones(procedure.bones),
        notes=(*moved, *come_out, *crossed, *crossing_warnings(procedure, crossings)),
    )


def _with_inside(epochs: Sequence[Epoch], procedure: Procedure, materials: Sequence[Material]) -> list[Epoch]:
    """The epochs with the regions and strands of their materials, and with what they rest on."""
    regions, strands = region_program(procedure, materials), strand_program(procedure, materials)
    still = united_bones([bone for bone in procedure.bones if not bone.moves])
    inside = [
        replace(epoch, regions=regions, strands=strands, over_bone=over_bone(epoch.surface, still)) for epoch in epochs
    ]
    return on_ground(inside, procedure.tissue)


def _vessels(
    procedure: Procedure, epochs: Sequence[Epoch], spacing: float
) -> tuple[dict[int, VesselPieces], tuple[VesselCrossing, ...]]:
    """What each epoch's tissue holds of the vessels, by its index, and where incisions divide them."""
    if not procedure.vessels:
        return {epoch.index: VesselPieces() for epoch in epochs}, ()
    uncut = tissue_surface(procedure.tissue)
    tissue, surface = RestSpace(uncut.points, uncut.triangles), ClosestPoint(uncut.points, uncut.triangles)
    most = OFF_TISSUE * procedure.tissue.spacing
    courses = [vessel_course(vessel, tissue, surface, spacing, most) for vessel in procedure.vessels]
    pieces = {epoch.index: VesselCutter(epoch.surface, spacing).pieces(courses) for epoch in epochs}
    return pieces, tuple(vessel_crossings(procedure, uncut, epochs, list(pieces.values())))


def _with_tissue(
    settings: SolverSettings, procedure: Procedure, events: TimedEvents, materials: Sequence[Material]
) -> SolverSettings:
    """The settings with what the procedure says of the tissue, and with room for its events."""
    tissue = procedure.tissue
    x, y, z = np.asarray(tissue.points, np.float64).min(axis=0)
    return replace(
        settings,
        origin=(float(x), float(y), float(z)),
        bed_stiffness=tissue.bed_stiffness,
        bed_shear=tissue.bed_shear,
        gravity=tissue.gravity_vector,
        sutures=len(events.sutures),
        retractors=len(events.retractors),
        materials=tuple(parameters(material) for material in materials),
    )


def frame_times(procedure: Procedure) -> list[int]:
    """List the integer time codes from the procedure's start to its end.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[int]
        The time codes.

    Raises
    ------
    RefusedError
        If there is none.
    """
    first, last = math.ceil(procedure.start_time), math.floor(procedure.end_time)
    if first > last:
        start, end = procedure.start_time, procedure.end_time
        raise refused(ProblemCode.TIMELINE_NO_FRAME, ROOT, f"{start:g} to {end:g}", start=start, end=end)
    return list(range(first, last + 1))


def _epoch_at(epochs: Sequence[Epoch], time: float) -> int:
    """The index of the last epoch that starts at or before `time`; the first one before that."""
    past = [epoch.index for epoch in epochs if epoch.start_time <= time]
    return past[-1] if past else epochs[0].index


def _tissue_loss(procedure: Procedure) -> TissueLoss:
    """The test of what anchors lie on; one that is off the tissue before any cut is refused."""
    loss = TissueLoss(procedure)
    placed: list[tuple[Event, Sequence[Point]]] = []
    for event in procedure.events:
        if isinstance(event, Hook):
            placed.append((event, [event.anchor]))
        elif isinstance(event, Suture):
            placed.append((event, event.anchors))
        elif isinstance(event, Landmark):
            placed.append((event, event.points))
    if not placed:
        return loss
    every = loss.distance([point for _, points in placed for point in points])
    ends = np.cumsum([len(points) for _, points in placed])
    for (event, points), distances in zip(placed, np.split(every, ends[:-1]), strict=True):
        if loss.is_off(distances).any():
            worst = int(np.argmax(distances))
            at, code = points[worst], ProblemCode.PROGRAM_POINT_OFF_TISSUE
            off = float(distances[worst])
            raise refused(code, event_path(event), _mm(at), place=Place.at(at), off=off, most=loss.allowed)
    return loss


@dataclass(frozen=True)
class _AnchorsInTissue:
    """The anchors of all events in the tissue of one epoch, and which of them have lost theirs."""

    events: TimedEvents
    placed: PlacedAnchors
    lost: NDArray[np.bool_]
    shifted: NDArray[np.bool_]
    ends: NDArray[np.float64]

    @classmethod
    def of(
        cls, epoch: Epoch, events: TimedEvents, loss: TissueLoss, off: NDArray[np.float64], out: NDArray[np.float64]
    ) -> _AnchorsInTissue:
        """Place the anchors in the tissue.

        off: how far outside the uncut tissue each is, shape (q,). out: when each suture comes out, shape (n,).
        """
        placed = AnchorSearch(epoch.surface, loss.margin).locate(events.anchors())
        return cls(events, placed, loss.is_lost(off, placed), loss.is_moved(off, placed), out)

    def moved(self, own: Sequence[int]) -> list[Problem]:
        """Say which hooks and sutures that act in the epoch's own frames a cut moves, and how far."""
        acting: list[tuple[Hook | Suture, float, float, Sequence[Point]]] = [
            *((hook, hook.start, hook.release, [hook.anchor]) for hook in self.events.hooks),
            *(
                (suture, suture.start, end, suture.anchors)
                for suture, end in zip(self.events.sutures, self.ends.tolist(), strict=True)
            ),
        ]
        said, row = [], 0
        for event, start, release, points in acting:
            for k, at in enumerate(points, start=row):
                if self.shifted[k] and not self.lost[k] and any(start <= time < release for time in own):
                    by, code = float(self.placed.distance[k]), ProblemCode.PROGRAM_ANCHOR_MOVED
                    said.append(problem(code, event_path(event), _mm(at), place=Place.at(at), off=by))
            row += len(points)
        return said

    def landmarks(self, vessels: VesselPieces) -> Landmarks:
        """The landmarks that have their tissue, with the pieces of vessels."""
        placed, lost = self.placed[self.events.mark_rows], self.lost[self.events.mark_rows]
        kept = np.flatnonzero(~lost)
        own = kept.astype(np.int32), placed.point[kept], placed.triangle[kept]
        return Landmarks(*own, vessels.points, vessels.triangles)

    def event_anchors(self, own: Sequence[int]) -> EventAnchors:
        """The anchors of the hooks and sutures that act in the epoch's own frames."""
        hooks = [
            self._placed(hook, slice(row, row + 1), hook.start, hook.release, own)
            for row, hook in enumerate(self.events.hooks)
        ]
        sutures = [
            self._placed(suture, rows, suture.start, end, own)
            for rows, suture, end in zip(self.events.suture_rows, self.events.sutures, self.ends.tolist(), strict=True)
        ]
        return EventAnchors(hooks, sutures)

    def _placed(
        self, event: Hook | Suture, rows: slice, start: float, release: float, own: Sequence[int]
    ) -> PlacedAnchors | None:
        """The anchors of an event, in these rows, or None where the event does not act in the epoch's frames."""
        acts = [time for time in own if start <= time < release]
        if not acts:
            return None
        points = [event.anchor] if isinstance(event, Hook) else list(event.anchors)
        placed = self.placed[rows]
        lost = np.flatnonzero(self.lost[rows])
        if len(lost):
            at, hook = points[lost[0]], isinstance(event, Hook)
            code = ProblemCode.PROGRAM_HOOK_EXCISED if hook else ProblemCode.PROGRAM_ANCHOR_EXCISED
            raise refused(code, event_path(event), _mm(at), place=Place.at(at), time=acts[0])
        together = np.flatnonzero(np.linalg.norm(np.diff(placed.point, axis=0), axis=1) == 0.0)
        if len(together):
            at, code = placed.point[together[0]], ProblemCode.PROGRAM_ANCHORS_FALL_TOGETHER
            raise refused(code, event_path(event), _mm(at), place=Place.at(at))
        return placed


def _grips(epoch: Epoch, retractors: Sequence[Retractor], own: Sequence[int]) -> NDArray[np.int32]:
    """The retractor that grips each triangle of an epoch, or -1; only those that act in one of its frames."""
    surface = epoch.surface
    grip = np.full(len(surface.triangles), -1, np.int32)
    for i, retractor in enumerate(retractors):
        acts = [time for time in own if retractor.start <= time < retractor.release]
        if not acts:
            continue
        mask = surface.grips.get(retractor.grip)
        if mask is None:
            known = ", ".join(surface.grips) or "none"
            raise refused(ProblemCode.GRIP_UNKNOWN, event_path(retractor), retractor.grip, known=known)
        if not mask.any():
            raise refused(ProblemCode.GRIP_EXCISED, event_path(retractor), retractor.grip, time=acts[0])
        taken = np.unique(grip[mask & (grip >= 0)])
        if len(taken):
            other = event_path(retractors[int(taken[0])])
            raise refused(ProblemCode.GRIP_SHARED, event_path(retractor), retractor.grip, other=other)
        grip[mask] = i
    return grip


def _labels(marks: Sequence[tuple[Landmark, Point]]) -> tuple[str, ...]:
    """A label per landmark point: no two alike.

    A label that several prims share gets the prim's name, and the points of a prim with several are numbered from 1.
    """
    prims = {mark.name: mark for mark, _ in marks}
    shared = Counter(mark.label or mark.name for mark in prims.values())
    labels = []
    for mark in prims.values():
        label = mark.label or mark.name
        if shared[label] > 1:
            label = f"{label} ({mark.name})"
        labels += [label] if len(mark.points) == 1 else [f"{label} {i + 1}" for i in range(len(mark.points))]
    return tuple(labels)


def _section_labels(sections: Sequence[Section]) -> tuple[str, ...]:
    """A label per section: no two alike."""
    shared = Counter(section.label or section.name for section in sections)
    labels = [(section.label or section.name, section.name) for section in sections]
    return tuple(label if shared[label] == 1 else f"{label} ({name})" for label, name in labels)


def _mm(point: Sequence[float] | NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{float(value):.4g}" for value in point) + ") mm"
