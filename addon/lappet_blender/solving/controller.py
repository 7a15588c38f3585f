"""What is known about the solving of each scene: the manifest in force, earlier ones, the job under way, what failed.

A controller holds no Blender data, only values and the scene's identifier: undo may replace every Blender object.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from time import monotonic
from typing import TYPE_CHECKING, Literal

import bpy

from lappet.background.manifest import ListedFrame, Manifest
from lappet.core.problem import Problem
from lappet.daemon.running_daemon import RunningDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Pose, Procedure
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore

from . import workers
from .chosen_daemon import chosen_daemon
from .frame_cache import FrameCache
from .frame_copy import FrameCopy
from .manifest_memory import ManifestMemory
from .solve_settings import frame_store, solve_settings

if TYPE_CHECKING:
    from lappet.background.solver import BackgroundSolver

JobKind = Literal["manifest", "solve", "live"]
PAST_MANIFESTS = 8  # earlier manifests whose frames are shown as stale
NOTES = 4


@dataclass(eq=False)
class Job:
    """A job of the worker. time: of the frame it is at. frame_seconds: of those it solved itself, not looked up."""

    number: int
    kind: JobKind
    key: str
    procedure: Procedure
    settings: SolverSettings
    manifest: Manifest | None = None
    started: float = field(default_factory=monotonic)
    until: int | None = None
    done: int = 0
    total: int = 0
    solved: int = 0
    time: float = math.nan
    newton: int = 0
    residual: float = math.nan
    frame_seconds: deque[float] = field(default_factory=lambda: deque(maxlen=8))
    frame_started: float = field(default_factory=monotonic)
    cancelled: bool = False


@dataclass(eq=False)
class Live:
    """A hook or retractor is dragged: target as last sent, moved: since live mode began; frame: the latest one.

    held: its name. stirred_at: monotonic seconds of the last target sent or frame received. placing: a tool still
    places it; no event of the scene holds it, and the frame is kept without it.
    """

    held: str
    event_uid: str
    time: int
    job: int
    target: Pose | None = None
    moved: bool = False
    stirred_at: float = field(default_factory=monotonic)
    frame: SolvedFrame | None = None
    seconds: float = 0.0
    converged: bool = True
    needs_check: bool = False  # a property has changed: it may be one that the procedure is made of
    placing: bool = False


@dataclass(frozen=True)
class Failure:
    """Why the last job stopped; time: at which frame, None where it was none."""

    time: int | None
    problem: Problem


@dataclass(eq=False)
class Controller:
    """One scene's solving.

    uid: the scene's. daemon: the one that solves, where it runs already. procedure, settings, key: as last read;
    None and "" where it cannot be solved. manifest: that of `key`, None until it is known. past: earlier manifests,
    newest first; past_procedure: what past[0] was made of. changed_from: while `manifest` is None, the time before
    which past[0] still holds. dirty_since, changed_at, read_at: monotonic seconds of the first change not yet read,
    the last one, and the last reading.
    """

    uid: int
    store: FrameStore
    daemon: RunningDaemon | None = None
    client: BackgroundSolver | None = None
    procedure: Procedure | None = None
    settings: SolverSettings = field(default_factory=SolverSettings)
    key: str = ""
    manifest: Manifest | None = None
    past: list[Manifest] = field(default_factory=list)
    past_of: tuple[Procedure, SolverSettings] | None = None
    changed_from: float = -math.inf
    problems: tuple[Problem, ...] = ()
    refused: tuple[Problem, ...] = ()
    job: Job | None = None
    listing: Job | None = None
    live: Live | None = None
    copying: FrameCopy | None = None
    failure: Failure | None = None
    notes: deque[Problem] = field(default_factory=lambda: deque(maxlen=NOTES))
    cells: float = 0.0  # of the lattice as solved; 0 = none was yet
    dirty_since: float | None = 0.0
    changed_at: float = 0.0
    read_at: float = -math.inf
    read_seconds: float = 0.0
    polled_state: tuple[object, ...] = ()
    revision: int = 0  # counts up whenever a state or what is shown may have changed
    notified: int = 0  # the revision that listeners were notified of
    known: set[str] = field(default_factory=set)  # keys of frames that the store or the memory holds
    states: tuple[int, dict[int, str]] = (-1, {})

    def mark_dirty(self) -> None:
        """The scene may have changed: it is to be read again."""
        now = monotonic()
        self.changed_at = now
        if self.dirty_since is None:
            self.dirty_since = now

    def notify(self) -> None:
        """What is shown, or a state, may have changed."""
        self.revision += 1

    def solver(self) -> BackgroundSolver:
        """The worker of this scene, started when it is first needed."""
        if self.client is None:
            self.client = workers.borrow(self.store.folder, self.daemon)
        return self.client

    def holds(self, key: str) -> bool:
        """Whether a frame is there, in memory or in the store (asked once; see `recheck_frames`)."""
        return key in self.known

    def recheck_frames(self, *manifests: Manifest) -> None:
        """Ask the store anew which frames of these manifests it holds."""
        for manifest in manifests:
            for frame in manifest.frames:
                if frame.key in frame_cache or frame.key in self.store:
                    self.known.add(frame.key)
                else:
                    self.known.discard(frame.key)
        self.notify()

    def note(self, note: Problem) -> None:
        """A note or warning for the panel; the same one twice is shown once."""
        if note in self.notes:
            self.notes.remove(note)
        self.notes.append(note)
        self.notify()

    def newest(self) -> Manifest | None:
        """The manifest in force, or while it is not known the one before."""
        return self.manifest or (self.past[0] if self.past else None)

    def jobs(self) -> Iterator[Job]:
        """The jobs under way."""
        if self.job is not None:
            yield self.job
        if self.listing is not None:
            yield self.listing

    def release(self) -> None:
        """Cancel everything and give the worker back."""
        if self.client is not None:
            for job in self.jobs():
                self.client.cancel(job.number)
            workers.give_back(self.client)
        self.client = self.job = self.listing = self.live = None


frame_cache = FrameCache()
manifests = ManifestMemory()
_controllers: dict[int, Controller] = {}


def controller_of(scene: bpy.types.Scene) -> Controller:
    """The controller of a scene, made where there is none yet."""
    found = _controllers.get(scene.session_uid)
    if found is None:
        found = Controller(scene.session_uid, frame_store(scene), chosen_daemon(), settings=solve_settings(scene))
        _controllers[found.uid] = found
    return found


def find_controller(scene: bpy.types.Scene) -> Controller | None:
    """The controller of a scene, or None."""
    return _controllers.get(scene.session_uid)


def scene_of(controller: Controller) -> bpy.types.Scene | None:
    """The scene of a controller, or None where it is gone."""
    return next((scene for scene in bpy.data.scenes if scene.session_uid == controller.uid), None)


def controllers() -> list[Controller]:
    """All controllers."""
    return list(_controllers.values())


def drop(controller: Controller) -> None:
    """Cancel the jobs of a scene and drop its controller; frames and manifests stay."""
    controller.release()
    _controllers.pop(controller.uid, None)


def drop_all() -> None:
    """Cancel the jobs of every scene and drop their controllers."""
    for controller in controllers():
        drop(controller)


def frame_at(manifest: Manifest, time: float) -> ListedFrame | None:
    """The frame of a manifest at a time code; a manifest's frames follow one another by one."""
    if not manifest.frames:
        return None
    index = math.floor(time + 1e-6) - manifest.frames[0].time
    return manifest.frames[index] if 0 <= index < len(manifest.frames) else None
