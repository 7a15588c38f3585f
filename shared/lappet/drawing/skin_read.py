"""Read a skin cache (docs/skin_cache.md) into arrays."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_kind import KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.core.problem import RefusedError
from lappet.drawing.scenery_read import SceneryMesh, read_scenery
from lappet.drawing.second_stage import second_stage_from
from lappet.drawing.skin_source import ORIGINS, FigureError, SkinEpoch, SkinSource, StepEvent, Strands, VesselLine
from lappet.drawing.suture_bites import bites_at, carried
from lappet.geometry.curve import sample_curve
from lappet.geometry.labeled_surface import LINING
from lappet.geometry.skin_shape import depth_below_skin
from lappet.procedure.prim_paths import SKIN_LINES
from lappet.usd.stage import pxr


class SkinCache(SkinSource):
    """An open skin cache; positions are in mm whatever the stage's unit.

    `fps` is the number of time codes in a second; `scenery` is what is shown around the tissue, `bones` what
    lies below it.

    Parameters
    ----------
    path
        The file.
    stage
        The cache over its procedure, open; None opens the file.

    Raises
    ------
    FigureError
        If the file is missing, is not USD or holds no skin.
    UsdMissingError
        If this Python has no USD.
    """

    def __init__(self, path: Path, stage: Any = None) -> None:
        usd = pxr()
        self._stage = _opened(path) if stage is None else stage
        self.path = path
        self._mm = usd.UsdGeom.GetStageMetersPerUnit(self._stage) / 0.001
        self.fps = float(self._stage.GetTimeCodesPerSecond())
        skin = self._stage.GetPrimAtPath("/Procedure/Skin")
        meshes = [p for p in skin.GetChildren() if p.IsA(usd.UsdGeom.Mesh)] if skin else []
        if not meshes:
            raise FigureError(
                f"{path.name} holds no skin (/Procedure/Skin/epoch_00), so it is no cache of a solved procedure; solve "
                "it with lappet solve and give what that writes."
            )
        self._epochs = tuple(e for e in (self._read_epoch(prim) for prim in meshes) if e.frames)
        self._rest: dict[str, NDArray[np.float32]] = {}
        self._at_rest: set[str] = set()  # epochs whose rest the cache holds
        self._frames = tuple(sorted({t for epoch in self.epochs for t in epoch.frames}))
        if not self.frames:
            raise FigureError(f"{path.name} holds a skin without frames; solve the procedure again (lappet solve).")
        self._events = self._read_events()
        self.scenery: tuple[SceneryMesh, ...] = read_scenery(self._stage, self._mm)
        self.bones: tuple[SceneryMesh, ...] = read_scenery(self._stage, self._mm, "/Procedure/Bone")

    @property
    def stage(self) -> Any:
        """The open stage, with the procedure below the cache."""
        return self._stage

    @property
    def millimeters(self) -> float:
        """Length of the stage's unit in mm."""
        return float(self._mm)

    @property
    def epochs(self) -> tuple[SkinEpoch, ...]:
        return self._epochs

    @property
    def frames(self) -> tuple[float, ...]:
        return self._frames

    @property
    def events(self) -> tuple[StepEvent, ...]:
        return self._events

    def epoch_at(self, time: float) -> SkinEpoch:
        for epoch in self.epochs:
            if time in epoch.frames:
                return epoch
        raise FigureError(
            f"Frame {time:g} is not in {self.path.name}, which holds frames {self.frames[0]:g} to {self.frames[-1]:g}; "
            "choose one of those or solve more of the procedure."
        )

    def positions(self, epoch: SkinEpoch, time: float) -> NDArray[np.float32]:
        points = np.asarray(epoch.prim.GetAttribute("points").Get(time), np.float32).reshape(-1, 3) * self._mm
        if len(points) <= int(epoch.triangles.max(initial=-1)) or not np.isfinite(points).all():
            raise FigureError(
                f"{epoch.prim.GetPath()} has missing or non-finite points at frame {time:g}; solve the procedure again."
            )
        return points

    def scalar(self, epoch: SkinEpoch, name: str, time: float) -> NDArray[np.float32] | None:
        value = epoch.prim.GetAttribute(f"primvars:{name}").Get(time)
        return None if value is None else np.asarray(value, np.float32)

    def sutures(self, time: float) -> Strands:
        return self._strands("Sutures", time)

    def threads(self, time: float) -> dict[int, NDArray[np.float64]]:
        prims = [self._stage.GetPrimAtPath(f"/Procedure/Skin/{name}") for name in ("Sutures", "Threads")]
        if not all(prims):
            return {}
        sutures, threads = (list(prim.GetAttribute("primvars:label").Get() or ()) for prim in prims)
        points = np.asarray(prims[1].GetAttribute("points").Get(time), np.float64).reshape(-1, 3) * self._mm
        ends = np.cumsum(prims[1].GetAttribute("curveVertexCounts").Get())
        active = prims[1].GetAttribute("primvars:active").Get(time)
        bites = zip(threads, np.split(points, ends[:-1]), active, strict=True)
        return {sutures.index(name): each for name, each, acts in bites if acts}

    def rest(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        if epoch.name not in self._rest:
            points = np.asarray(epoch.prim.GetAttribute("points").Get() or (), np.float32).reshape(-1, 3) * self._mm
            whole = len(points) > int(epoch.triangles.max(initial=-1)) and bool(np.isfinite(points).all())
            if whole:
                self._at_rest.add(epoch.name)
            self._rest[epoch.name] = points if whole else self.positions(epoch, epoch.frames[0])
        return self._rest[epoch.name]

    def depth(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        primvar = epoch.prim.GetAttribute("primvars:depth").Get()
        if primvar is not None and len(primvar) == len(self.rest(epoch)):
            return np.asarray(primvar, np.float32) * np.float32(self._mm)
        return depth_below_skin(self.rest(epoch), epoch.triangles, epoch.origin)

    @property
    def layers(self) -> TissueLayers:
        prim = self._stage.GetPrimAtPath("/Procedure/Skin/Layers")
        names = ("column", "depthFrom", "kind", "material")
        found = [prim.GetAttribute(f"lappet:{name}").Get() or () if prim else () for name in names]
        if not len(found[0]) or any(len(each) != len(found[0]) for each in found):
            return TissueLayers()
        column, tops, kinds, materials = found
        known = [KINDS.index(str(kind)) if str(kind) in KINDS else KINDS.index("other") for kind in kinds]
        depths = np.asarray(tops, np.float64) * self._mm
        return TissueLayers(np.asarray(column, np.int32), depths, np.array(known, np.int32), tuple(materials))

    def column(self, epoch: SkinEpoch) -> NDArray[np.int32]:
        found = epoch.prim.GetAttribute("primvars:layerColumn").Get()
        fits = found is not None and len(found) == len(epoch.triangles)
        return np.asarray(found, np.int32) if fits else np.zeros(len(epoch.triangles), np.int32)

    def vessels(self, time: float) -> list[VesselLine]:
        prim = self._stage.GetPrimAtPath(f"/Procedure/Skin/Vessels/{self.epoch_at(time).name}")
        if not prim:
            return []
        points, counts = self.vessel_points(time), np.asarray(prim.GetAttribute("curveVertexCounts").Get(), np.int64)
        kinds, widths, begins, ends = (
            prim.GetAttribute(name).Get()
            for name in (_kinds(prim), "widths", "primvars:beginDivided", "primvars:endDivided")
        )
        lines = np.split(points, np.cumsum(counts)[:-1])
        return [
            VesselLine(str(kind), line, 0.5 * float(width) * self._mm, (bool(begin), bool(end)))
            for kind, line, width, begin, end in zip(kinds, lines, widths, begins, ends, strict=True)
        ]

    def vessel_points(self, time: float) -> NDArray[np.float64]:
        """Return the points of all pieces of vessels at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        NDArray[np.float64]
            Positions in mm, shape (v, 3).
        """
        prim = self._stage.GetPrimAtPath(f"/Procedure/Skin/Vessels/{self.epoch_at(time).name}")
        points = prim.GetAttribute("points").Get(time) if prim else None
        return np.asarray(points if points is not None else [], np.float64).reshape(-1, 3) * self._mm

    def suture_apart(self, epoch: SkinEpoch, index: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Find where a suture's lips are easy to tell apart.

        This is at rest, where the cache holds that or the epoch begins before anything is held: later, flaps that
        overlap come between. Otherwise it is the first frame at which the suture is active. Where that is in an earlier
        epoch, and this one has its skin at rest, the ends are carried to there: skin at rest is the same in all.

        Parameters
        ----------
        epoch
            The epoch.
        index
            The suture's index.

        Returns
        -------
        tuple[NDArray[np.float32], NDArray[np.float32]]
            The skin's vertices there in mm, shape (n, 3), and the suture's ends, shape (2, 3).
        """
        first = epoch.frames[0]
        skin = self._stage.GetPrimAtPath("/Procedure/Skin/Sutures")
        labels = skin.GetAttribute("primvars:label").Get() if skin else None
        held = min((e.start for e in self.events if e.kind in ("Hook", "Retractor", "Suture")), default=first)
        rest = self.rest(epoch)
        label = labels[index] if labels is not None and index < len(labels) else ""
        single = bool(label) and "/" not in label  # a stitch of a run has no prim of its own
        if single and (first <= held or epoch.name in self._at_rest):
            prim = self._stage.GetPrimAtPath(f"/Procedure/Timeline/{label}")
            anchors = prim.GetAttribute("lappet:anchors").Get() if prim else None
            if anchors is not None and len(anchors) == 2:
                return rest, np.asarray(anchors, np.float32) * np.float32(self._mm)
        active = next(t for t in self.frames if self.sutures(t).active[index])
        earlier = self.epoch_at(active)
        if earlier.name != epoch.name and {earlier.name, epoch.name} <= self._at_rest | {self.epochs[0].name}:
            bites = bites_at(self.positions(earlier, active), earlier.triangles, self.sutures(active).ends[index])
            return rest, carried(bites, self.rest(earlier)).astype(np.float32)
        active = next(t for t in epoch.frames if self.sutures(t).active[index])
        return self.positions(epoch, active), self.sutures(active).ends[index]

    def hooks(self, time: float) -> Strands:
        return self._strands("Hooks", time)

    def hook_courses(self) -> dict[int, NDArray[np.float64]]:
        courses: dict[int, list[NDArray[np.float64]]] = {}
        for time in self.frames:
            hooks = self.hooks(time)
            for index in np.flatnonzero(hooks.active):
                courses.setdefault(int(index), []).append(hooks.ends[index, 0].astype(np.float64))
        return {index: np.array(course) for index, course in courses.items()}

    def suture_closed(self, epoch: SkinEpoch, index: int) -> float:
        return next(t for t in reversed(epoch.frames) if self.sutures(t).active[index])

    def landmarks(self, time: float) -> NDArray[np.float32]:
        """Return the landmarks at a frame; those whose tissue is gone lie where they were last.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        NDArray[np.float32]
            Positions in mm, shape (k, 3).
        """
        prim = self._stage.GetPrimAtPath("/Procedure/Skin/Landmarks")
        points = prim.GetAttribute("points").Get(time) if prim else None
        return np.asarray(points if points is not None else [], np.float32).reshape(-1, 3) * np.float32(self._mm)

    def named_landmarks(self, time: float) -> dict[str, NDArray[np.float64]]:
        """Read the landmarks that are on the tissue at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        dict[str, NDArray[np.float64]]
            Their places in mm, shape (3,), by label; those whose tissue is gone are left out.
        """
        prim = self._stage.GetPrimAtPath("/Procedure/Skin/Landmarks")
        labels = list(prim.GetAttribute("primvars:label").Get() or ()) if prim else []
        points = self.landmarks(time).astype(np.float64)
        active = prim.GetAttribute("primvars:active").Get(time) if prim else None
        flags = [True] * len(labels) if active is None else [bool(each) for each in active]
        if not len(labels) == len(points) == len(flags):
            return {}
        return {label: place for label, place, on in zip(labels, points, flags, strict=True) if on}

    def planned_incisions(self, step: float) -> list[NDArray[np.float64]]:
        return self._curves("Incision", step)

    def thinned_areas(self, step: float) -> dict[str, NDArray[np.float64]]:
        """Sample the outlines of the areas that are thinned at rest.

        Parameters
        ----------
        step
            Distance between samples in mm.

        Returns
        -------
        dict[str, NDArray[np.float64]]
            By the name of the event a polyline in mm, shape (k, 3), which repeats its first point.
        """
        timeline = self._stage.GetPrimAtPath("/Procedure/Timeline")
        names = [each.name for each in self.events if each.kind == "Thin"]
        lines = {name: self._sampled(timeline.GetChild(name), step, True) for name in names}
        return {name: line for name, line in lines.items() if line is not None}

    def undermined_areas(self, step: float) -> list[NDArray[np.float64]]:
        return self._curves("Undermine", step)

    def skin_lines(self, step: float) -> list[NDArray[np.float64]]:
        """Sample the skin lines of the procedure at rest.

        Parameters
        ----------
        step
            Distance between samples in mm.

        Returns
        -------
        list[NDArray[np.float64]]
            Polylines in mm, shape (k, 3) each.
        """
        scope = self._stage.GetPrimAtPath(SKIN_LINES)
        prims = scope.GetChildren() if scope else []
        sampled = [self._sampled(prim, step, False) for prim in prims]
        return [line for line in sampled if line is not None]

    def _curves(self, kind: str, step: float) -> list[NDArray[np.float64]]:
        timeline, late = self._stage.GetPrimAtPath("/Procedure/Timeline"), second_stage_from(self.events)
        prims = [timeline.GetChild(each.name) for each in self.events if each.kind == kind and each.start < late]
        lines = [self._sampled(prim, step, kind == "Undermine") for prim in prims]
        return [line for line in lines if line is not None]

    def _sampled(self, prim: Any, step: float, closed: bool) -> NDArray[np.float64] | None:
        """The points of a curve; None where there are none, or a curve that check would refuse."""
        points = prim.GetAttribute("points").Get()
        if points is None:
            return None
        smooth = prim.GetAttribute("type").Get() == "cubic"
        basis: Any = (prim.GetAttribute("basis").Get() or "bezier") if smooth else "linear"
        closed = closed or prim.GetAttribute("wrap").Get() == "periodic"
        try:
            line = sample_curve(np.asarray(points, np.float64) * self._mm, basis, closed, step)
        except RefusedError:
            return None
        return np.vstack([line, line[:1]]) if closed else line

    def _strands(self, name: str, time: float) -> Strands:
        prim = self._stage.GetPrimAtPath(f"/Procedure/Skin/{name}")
        points = prim.GetAttribute("points").Get(time) if prim else None
        ends = np.asarray(points if points is not None else [], np.float32).reshape(-1, 2, 3) * self._mm
        active = prim.GetAttribute("primvars:active").Get(time) if prim else None
        flags = np.ones(len(ends), bool) if active is None else np.asarray(active, bool).reshape(-1)
        if len(flags) != len(ends):
            raise FigureError(
                f"{prim.GetPath()} has {len(ends)} curves and {len(flags)} values of active at frame {time:g}; "
                "write the cache again with lappet solve."
            )
        return Strands(ends, flags & np.isfinite(ends).all(axis=(1, 2)))

    def _read_epoch(self, prim: Any) -> SkinEpoch:
        usd_geom = pxr().UsdGeom
        mesh = usd_geom.Mesh(prim)
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get(), np.int64)
        corners = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(), np.int32)
        if not len(counts) or (counts != 3).any() or len(corners) != 3 * len(counts):
            raise FigureError(f"{prim.GetPath()} is not a mesh of triangles; write the cache again with lappet solve.")
        origin = np.zeros(len(counts), np.uint8)
        lining = np.zeros(len(counts), bool)
        for subset in usd_geom.Subset.GetAllGeomSubsets(mesh):
            faces = np.asarray(subset.GetIndicesAttr().Get() or [], np.int64)
            faces = faces[faces < len(origin)]
            if (label := subset.GetPrim().GetName()) in ORIGINS:
                origin[faces] = ORIGINS.index(label)
            elif label == LINING:
                lining[faces] = True
        primvar = usd_geom.PrimvarsAPI(mesh).GetPrimvar("st")
        times = mesh.GetPointsAttr().GetTimeSamples()
        st = primvar.ComputeFlattened(times[0] if times else 0.0) if primvar else None
        uv = None
        if st is not None and len(st) == len(corners):
            uv = np.asarray(st, np.float32).reshape(-1, 3, 2)
        visibility = mesh.GetVisibilityAttr()
        frames = tuple(float(t) for t in times if visibility.Get(t) != usd_geom.Tokens.invisible)
        return SkinEpoch(prim.GetName(), corners.reshape(-1, 3), origin, uv, frames, prim, lining)

    def _read_events(self) -> tuple[StepEvent, ...]:
        timeline = self._stage.GetPrimAtPath("/Procedure/Timeline")
        events = []
        sutures = self._stage.GetPrimAtPath("/Procedure/Skin/Sutures")
        labels = list(sutures.GetAttribute("primvars:label").Get() or ()) if sutures else []
        for prim in timeline.GetChildren() if timeline else []:
            schemas = prim.GetMetadata("apiSchemas")
            kinds = [
                m[1] for s in (schemas.GetAppliedItems() if schemas else []) if (m := re.match(r"Lappet(\w+)API$", s))
            ]
            if not kinds:
                continue
            value = {n: prim.GetAttribute(f"lappet:{n}").Get() for n in ("time", "start", "release", "duration")}
            start = value["time"] if value["time"] is not None else value["start"]
            if start is None:
                continue
            end = value["release"] if value["release"] is not None else start + (value["duration"] or 0.0)
            name, kind, stitches = prim.GetName(), kinds[0], 1
            if kind == "SutureRun":
                kind, stitches = "Suture", sum(label.startswith(f"{name}/") for label in labels)
            events.append(StepEvent(kind, name, float(start), float(end), stitches))
        return tuple(sorted(events, key=lambda e: e.start))


def _opened(path: Path) -> Any:
    usd = pxr()
    if not path.is_file():
        raise FigureError(f"There is no skin cache at {path}; solve the procedure first (lappet solve).")
    try:
        return usd.Usd.Stage.Open(str(path))
    except usd.Tf.ErrorException as error:
        raise FigureError(
            f"{path.name} is not a USD file that can be read; write it again with lappet solve."
        ) from error


def _kinds(vessels: Any) -> str:
    """The attribute with the kinds of vessels; in older caches it is a primvar."""
    return "lappet:kind" if vessels.HasAttribute("lappet:kind") else "primvars:kind"
