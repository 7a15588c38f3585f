"""A manifest and its frames as what the drawing of threads, hooks and marks asks for (`lappet.drawing.skin_source`)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import TissueLayers
from lappet.background.manifest import EpochShape, Manifest
from lappet.core.problem import RefusedError
from lappet.daemon.solved_frame import SolvedFrame
from lappet.drawing.second_stage import second_stage_from
from lappet.drawing.skin_source import FigureError, SkinEpoch, StepEvent, Strands, VesselLine
from lappet.geometry.curve import sample_curve
from lappet.procedure.cuts import Basis
from lappet.solve.bite_forces import bite_points

from ..events.run_preview import stitches_of
from ..model.event_kinds import BASIS_OF, HOLD_KINDS, SEWN_KINDS

Lookup = Callable[[int], SolvedFrame | None]
_COURSE = 5  # frames that tell where a hook goes


def _epoch_name(number: int, shape: EpochShape) -> str:
    return f"{number} {shape.key}"


def _no_strands(count: int) -> Strands:
    return Strands(np.zeros((count, 2, 3), np.float32), np.zeros(count, bool))


class ManifestSource:
    """The frames of a manifest, known or not, with what the scene says of its events.

    A frame that is not known shows its epoch at rest, without sutures and hooks.
    """

    def __init__(self, manifest: Manifest, scene: bpy.types.Scene, lookup: Lookup) -> None:
        """lookup: the solved frame of a time code, or None."""
        self.manifest = manifest
        self._lookup = lookup
        times: dict[int, list[float]] = {}
        for frame in manifest.frames:
            times.setdefault(frame.epoch, []).append(float(frame.time))
        self._shapes = manifest.epochs
        self._epochs = tuple(
            SkinEpoch(
                _epoch_name(k, s),
                s.triangles,
                s.origin,
                s.grid,
                tuple(times.get(k, ())),
                lining=s.lining.astype(bool) if len(s.lining) else None,
            )
            for k, s in enumerate(manifest.epochs)
        )
        self._shape_of = {e.name: s for e, s in zip(self._epochs, manifest.epochs, strict=True)}
        self._listed = {float(frame.time): frame for frame in manifest.frames}
        self._now: tuple[float, SkinEpoch, SolvedFrame | None] | None = None
        self._last: dict[str, float | None] = {}
        self.read_events(scene)

    def has_epochs_of(self, manifest: Manifest) -> bool:
        """Whether a manifest's epochs are these."""
        return [e.name for e in self._epochs] == [_epoch_name(k, s) for k, s in enumerate(manifest.epochs)]

    def read_events(self, scene: bpy.types.Scene) -> None:
        """Take over what the scene says of its events now."""
        self._anchors = {
            e.name: np.array([p.co for p in e.points], np.float32).reshape(-1, 3)
            for e in scene.lappet.events
            if e.kind == "SUTURE"
        }
        for e in scene.lappet.events:
            if e.kind == "SUTURE_RUN":
                self._anchors |= {s.name: np.array(s.anchors, np.float32) for s in stitches_of(scene, e)}
        stitches = Counter(name.partition("/")[0] for name in self.manifest.sutures)
        steps = (_step(e, stitches[e.name]) for e in scene.lappet.events if e.enabled)
        self._events = tuple(sorted(steps, key=lambda e: e.start))
        late = second_stage_from(self._events)
        cuts = [e for e in scene.lappet.events if e.enabled and e.kind in ("INCISION", "UNDERMINE")]
        self._curves = [_curve(e) for e in cuts if e.start < late]

    def at(self, time: float, shape: EpochShape, frame: SolvedFrame | None) -> None:
        """From now on a time shows this epoch and frame, whatever the store holds (live frames, stand-ins)."""
        index = next((k for k, s in enumerate(self._shapes) if s is shape or s.key == shape.key), None)
        if index is None:
            raise FigureError(f"The manifest has no epoch {shape.key[:12]}; solve the procedure again.")
        listed = self._listed.get(time)
        if listed is not None and self._shapes[listed.epoch].key == shape.key:
            index = listed.epoch
        self._now = (time, self._epochs[index], fitting(frame, shape))

    @property
    def epochs(self) -> tuple[SkinEpoch, ...]:
        """The epochs of the manifest."""
        return self._epochs

    @property
    def frames(self) -> tuple[float, ...]:
        """The time codes of all frames."""
        return tuple(self._listed)

    @property
    def events(self) -> tuple[StepEvent, ...]:
        """The scene's events."""
        return self._events

    def shape(self, epoch: SkinEpoch) -> EpochShape:
        """The surface of an epoch."""
        return self._shape_of[epoch.name]

    def frame(self, time: float) -> SolvedFrame | None:
        """The solved frame of a time, or None."""
        if self._now is not None and self._now[0] == time:
            return self._now[2]
        listed = self._listed.get(time)
        if listed is None:
            return None
        return fitting(self._lookup(listed.time), self._shapes[listed.epoch])

    def epoch_at(self, time: float) -> SkinEpoch:
        """The epoch that is shown at a frame; FigureError where the manifest has no such frame."""
        if self._now is not None and self._now[0] == time:
            return self._now[1]
        if time not in self._listed:
            raise FigureError(f"Frame {time:g} is not in the manifest; solve the procedure again.")
        return self._epochs[self._listed[time].epoch]

    def positions(self, epoch: SkinEpoch, time: float) -> NDArray[np.float32]:
        """Vertex positions (n, 3), mm."""
        frame = self.frame(time)
        return self.rest(epoch) if frame is None else frame.points

    def scalar(self, epoch: SkinEpoch, name: str, time: float) -> NDArray[np.float32] | None:
        """A vertex quantity (n,), or None where the frame is not known."""
        frame = self.frame(time)
        return None if frame is None else frame.scalar(name)

    def sutures(self, time: float) -> Strands:
        """The sutures of the manifest at a frame."""
        frame, count = self.frame(time), len(self.manifest.sutures)
        return _no_strands(count) if frame is None else _strands(frame.suture_points, frame.suture_index, count)

    def threads(self, time: float) -> dict[int, NDArray[np.float64]]:
        """The bites (k, 3), mm, of the sutures of a known frame that have more than two, by their index."""
        frame = self.frame(time)
        if frame is None or not len(frame.suture_inner_bites):
            return {}
        bites = zip(frame.suture_index, bite_points(frame), strict=True)
        return {int(index): each for index, each in bites if len(each) > 2}

    def hooks(self, time: float) -> Strands:
        """The hooks of the manifest at a frame; both ends are on the tissue."""
        frame, count = self.frame(time), len(self.manifest.hooks)
        return _no_strands(count) if frame is None else _strands(frame.hook_points[:, None], frame.hook_index, count)

    def hook_courses(self) -> dict[int, NDArray[np.float64]]:
        """Where the hooks' ends go, (k, 3) mm by the hook's index, as far as a few known frames tell."""
        courses: dict[int, NDArray[np.float64]] = {}
        for index in range(len(self.manifest.hooks)):
            times = [t for t, frame in self._listed.items() if index in frame.hooks]
            if self._now is not None and self._now[0] in times:
                times = [self._now[0], *times]
            ends = [
                hooks.ends[index, 0].astype(np.float64)
                for t in {times[round(k)] for k in np.linspace(0, len(times) - 1, _COURSE)}
                if times
                if (hooks := self.hooks(t)).active[index]
            ]
            if ends:
                courses[index] = np.array(ends)
        return courses

    def rest(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        """Vertex positions (n, 3) at rest, mm."""
        return self._shape_of[epoch.name].rest

    def depth(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        """How deep below the skin before any cut vertices (n,) lie, mm."""
        return self._shape_of[epoch.name].depth

    @property
    def layers(self) -> TissueLayers:
        """The layers of the tissue."""
        return self.manifest.layers

    def column(self, epoch: SkinEpoch) -> NDArray[np.int32]:
        """The column of layers that triangles (m,) lie in."""
        found = self._shape_of[epoch.name].column
        return found if len(found) else np.zeros(len(epoch.triangles), np.int32)

    def vessels(self, time: float) -> list[VesselLine]:
        """The pieces of vessels at a frame; at rest where it is not known."""
        manifest, epoch = self.manifest, self.epoch_at(time)
        if not manifest.vessels_at:
            return []
        pieces, frame = manifest.vessels_at[self._epochs.index(epoch)], self.frame(time)
        fits = frame is not None and frame.vessel_points.shape == pieces.points.shape
        lines = pieces.split(frame.vessel_points if frame is not None and fits else pieces.points)
        return [
            VesselLine(manifest.vessels[k].kind, line, manifest.vessels[k].radius, (bool(begin), bool(end)))
            for k, line, (begin, end) in zip(pieces.vessel, lines, pieces.divided, strict=True)
        ]

    def suture_apart(self, epoch: SkinEpoch, index: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Positions (n, 3) at which a suture's lips are easy to tell apart, and its ends (2, 3) there.

        At rest where the scene still has the event.
        """
        anchors = self._anchors.get(self.manifest.sutures[index])
        if anchors is not None and len(anchors) == 2:
            return self.rest(epoch), anchors
        time = next(t for t in (*self._near(), *epoch.frames) if t in epoch.frames and self.sutures(t).active[index])
        return self.positions(epoch, time), self.sutures(time).ends[index]

    def suture_closed(self, epoch: SkinEpoch, index: int) -> float:
        """The last known frame of an epoch at which a suture is active."""
        if epoch.name not in self._last:
            self._last[epoch.name] = self.last_known(epoch)
        last = self._last[epoch.name]
        if last is not None and self.sutures(last).active[index]:
            return last
        return next(t for t in (*self._near(), *epoch.frames) if t in epoch.frames and self.sutures(t).active[index])

    def frames_changed(self) -> None:
        """Frames have come or gone."""
        self._last.clear()

    def last_known(self, epoch: SkinEpoch) -> float | None:
        """The last frame of an epoch that is known."""
        return next((t for t in reversed(epoch.frames) if self.frame(t) is not None), None)

    def planned_incisions(self, step: float) -> list[NDArray[np.float64]]:
        """The scene's incisions but those of a second stage, sampled every `step` mm."""
        return self._lines("INCISION", step)

    def undermined_areas(self, step: float) -> list[NDArray[np.float64]]:
        """The outlines of the scene's undermined areas, sampled and closed."""
        return self._lines("UNDERMINE", step)

    def _near(self) -> tuple[float, ...]:
        return () if self._now is None else (self._now[0],)

    def _lines(self, wanted: str, step: float) -> list[NDArray[np.float64]]:
        lines = []
        for kind, points, basis, closed in self._curves:
            if kind != wanted:
                continue
            try:
                line = sample_curve(points, basis, closed, step)
            except RefusedError:
                continue  # the panel says what is wrong with it
            lines.append(np.vstack([line, line[:1]]) if closed else line)
        return lines


def _strands(ends: NDArray[np.float64], index: NDArray[np.int32], count: int) -> Strands:
    """The ends (k, 2 or 1, 3) of the strands of these numbers, of `count` in all."""
    strands = _no_strands(count)
    if len(index) and index.max() < count:
        strands.ends[index] = ends
        strands.active[index] = np.isfinite(strands.ends[index]).all(axis=(1, 2))
    return strands


def fitting(frame: SolvedFrame | None, shape: EpochShape) -> SolvedFrame | None:
    """The frame, or None where it is not of this surface or not finite (a damaged store, a lost frame)."""
    if frame is None or frame.points.shape != shape.rest.shape or not np.isfinite(frame.points).all():
        return None
    return frame


def _curve(event: bpy.types.PropertyGroup) -> tuple[str, NDArray[np.float64], Basis, bool]:
    points = np.array([p.co for p in event.points], np.float64).reshape(-1, 3)
    return event.kind, points, BASIS_OF[event.basis], event.closed or event.kind == "UNDERMINE"


def _step(event: bpy.types.PropertyGroup, stitches: int) -> StepEvent:
    sewn = event.kind in SEWN_KINDS
    end = (
        event.end
        if event.kind in HOLD_KINDS
        else event.start + (event.duration if sewn or event.kind == "THIN" else 0.0)
    )
    kind = "Suture" if sewn else event.kind.capitalize()
    return StepEvent(kind, event.name, event.start, end, stitches if event.kind == "SUTURE_RUN" else 1)
