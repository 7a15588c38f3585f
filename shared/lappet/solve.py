"""Solves a procedure: looks up the frames that are known, has the daemon solve the rest, and writes the skin cache."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from lappet.compile import compile_program, frame_times
from lappet.frame_solver import (
    STATE_ARRAYS,
    Connect,
    FrameSolver,
    Iteration,
    SolverDiedError,
)
from lappet.keys import frame_keys
from lappet.procedure import Procedure
from lappet.program import FrameConstraints, Program
from lappet.refused import RefusedError
from lappet.store import FrameStore, StoredFrame

if TYPE_CHECKING:
    from lappet.error_estimate import ErrorEstimate

TRIES = 3


class Watcher:
    """Is told how a solve goes; this one keeps silent."""

    def begin(self, frames: int) -> None:
        """So many frames are to be had."""

    def iteration(self, iteration: Iteration) -> None:
        """A Newton iteration is done."""

    def frame(self, frame: FrameResult) -> None:
        """A frame is there."""

    def note(self, sentence: str) -> None:
        """Something that the user should know."""


@dataclass(frozen=True, eq=False)
class FrameResult:
    """A frame as it goes into the skin cache and the report.

    header, arrays: the fields and arrays of the message `frame` (PROTOCOL.md) without the state; header also holds
    `lattice`, the counts of the epoch. looked_up: it came from the store. wall_seconds: the time it took here.
    """

    constraints: FrameConstraints
    key: str
    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    looked_up: bool
    wall_seconds: float


@dataclass(frozen=True, eq=False)
class SolveResult:
    """What a solve gave. frames: those done, from the first one of the procedure on. reason: why it ended before its
    last frame, a sentence, or None. interrupted: the user stopped it. output: the skin cache, or None where no frame of
    the wanted range is done. failed: the unconverged frame that stopped it. notes: what the user was told meanwhile.
    errors: of `frames`, None where no estimate was wanted.
    """

    procedure: Procedure
    program: Program
    frames: tuple[FrameResult, ...]
    reason: str | None = None
    interrupted: bool = False
    failed: FrameResult | None = None
    output: Path | None = None
    wall_seconds: float = 0.0
    notes: tuple[str, ...] = ()
    errors: ErrorEstimate | None = None

    @property
    def complete(self) -> bool:
        """Whether every frame asked for is there."""
        return self.reason is None and not self.interrupted

    @property
    def looked_up(self) -> int:
        """How many frames came from the store."""
        return sum(frame.looked_up for frame in self.frames)

    @property
    def solved(self) -> int:
        """How many frames the daemon solved."""
        return len(self.frames) - self.looked_up


def solve_procedure(
    source: Path | str | Procedure,
    output: Path | str,
    *,
    spacing: float | None = None,
    tolerance: float = 1e-3,
    quadrature: int = 1,
    precision: Literal["float", "double"] = "float",
    frames: tuple[int | None, int | None] = (None, None),
    daemon: str | None = None,
    store: FrameStore | None = None,
    watcher: Watcher | None = None,
    connect: Connect | None = None,
    solver: str | None = None,
    error_estimate: bool = True,
    strain: bool = True,
    whole: bool = False,
) -> SolveResult:
    """Solves a procedure and writes its skin cache to `output` (.usdc, .usda or .usd).

    source: a USD file, or a Procedure, which is then written beside the cache as `<output>.procedure.usda`. spacing:
    mm (the tissue's when None). frames: first and last time code to write; everything up to the last one is solved.
    daemon: the address of a running daemon. store: where frames are kept. connect, solver: who solves, and what
    identifies it (the daemon that is installed when None). error_estimate: also solve on a coarser lattice, to say how
    large the error is (`lappet.error_estimate`). strain: the cache gets strain, stress and tension. whole: every
    frame is solved everywhere, also where its changes do not reach.

    A frame that does not converge, a daemon that cannot be kept alive and Ctrl-C end the solve early and keep what is
    done: see `SolveResult.reason`. Raises RefusedError or ProcedureError with a sentence for what cannot be solved at
    all.
    """
    started = time.perf_counter()
    watch = _Noting(watcher or Watcher())
    output = Path(output)
    _refuse_output(output)
    procedure, path = _read(source, output)
    _check(procedure, spacing)
    first, last = _range(procedure, frames)
    program = compile_program(
        procedure,
        spacing=spacing,
        tolerance=tolerance,
        quadrature=quadrature,
        precision=precision,
        until=last,
        correction=error_estimate,
        strain=strain,
        region="whole" if whole else "auto",
    )
    for sentence in program.notes:
        watch.note(sentence)
    if connect is None or solver is None:
        from lappet.daemon_solver import connect_to, solver_identity

        connect = connect or connect_to(daemon)
        solver = solver or solver_identity(daemon)
    store = store or FrameStore()
    result = solve_program(program, store, connect, solver, watch)
    wanted = [frame for frame in result.frames if frame.constraints.time >= first]
    written = None
    if wanted:
        from lappet.skin_cache import write_skin_cache

        write_skin_cache(output, path, procedure, program, wanted)
        written = output
    elif result.reason is not None and result.failed is None:
        raise RefusedError(result.reason)
    errors = None
    if error_estimate and result.frames and not result.interrupted:
        from lappet.error_estimate import estimate_errors

        errors = estimate_errors(program, result.frames, store, connect, solver)
    return SolveResult(
        procedure,
        program,
        result.frames,
        result.reason,
        result.interrupted,
        result.failed,
        written,
        time.perf_counter() - started,
        tuple(watch.sentences),
        errors,
    )


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames that `solve_program` got, and why it ended where it did not get all of them."""

    frames: tuple[FrameResult, ...]
    reason: str | None = None
    interrupted: bool = False
    failed: FrameResult | None = None


def solve_program(program: Program, store: FrameStore, connect: Connect, solver: str, watch: Watcher) -> Frames:
    """Gets every frame of a program, from the store where it is there, else from a solver that is started when needed.

    A solver that dies is started again, at most three times for one frame, from the last frame's state.
    """
    keys = frame_keys(program, solver)
    watch.begin(len(keys))
    done: list[FrameResult] = []
    with _Session(program, connect) as session:
        for index, constraints in enumerate(program.frames):
            try:
                result = _frame(session, index, keys[index], store, watch)
                if not result.header["converged"]:
                    why = str(result.header.get("reason") or "the solver gave no reason.")
                    return Frames(tuple(done), f"Frame {constraints.time:g} did not converge: {why}", failed=result)
                done.append(result)
                watch.frame(result)
            except KeyboardInterrupt:
                return Frames(tuple(done), f"Stopped: {len(done)} of {len(keys)} frames are done.", interrupted=True)
            except (RefusedError, SolverDiedError) as error:
                return Frames(tuple(done), f"Frame {constraints.time:g} was not solved: {error}")
    return Frames(tuple(done))


def _frame(session: _Session, index: int, key: str, store: FrameStore, watch: Watcher) -> FrameResult:
    """A frame from the store or the solver; what is newly solved is kept."""
    begun = time.perf_counter()
    stored = store.get(key)
    looked_up = stored is not None
    if stored is None:
        stored = session.solve(index, watch)
    if stored.header["converged"]:
        session.remember(index, stored)
        well = store.trouble is None
        if not looked_up and not store.put(key, stored) and well:
            watch.note(str(store.trouble))
    return FrameResult(
        session.program.frames[index],
        key,
        stored.header,
        {name: array for name, array in stored.arrays.items() if name not in STATE_ARRAYS},
        looked_up,
        time.perf_counter() - begun,
    )


class _Session:
    """A solver that is started when first needed and brought to the frame before the one that is wanted."""

    def __init__(self, program: Program, connect: Connect) -> None:
        self.program = program
        self._connect = connect
        self._solver: FrameSolver | None = None
        self._at: int | None = None  # the frame whose state the solver holds
        self._epoch: int | None = None  # the epoch that the solver holds
        self._lattice: dict[str, Any] = {}
        self._last: tuple[int, StoredFrame] | None = None

    def __enter__(self) -> _Session:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def remember(self, index: int, frame: StoredFrame) -> None:
        """Keeps the last frame: the state to go on from."""
        self._last = (index, frame)

    def solve(self, index: int, watch: Watcher) -> StoredFrame:
        """Solves a frame whose predecessor has been remembered."""
        frame = self.program.frames[index]
        for attempt in range(1, TRIES + 1):
            try:
                solver = self._prepare(index)
                solved = solver.solve(frame, watch.iteration)
            except SolverDiedError as error:
                self._abandon()
                if attempt == TRIES:
                    raise SolverDiedError(f"{error} That was try {TRIES} of {TRIES}.") from error
                watch.note(f"{error} It was solving frame {frame.time:g} and is started again.")
            except BaseException:
                self._abandon()
                raise
            else:
                if solved.converged:
                    self._at = index
                return StoredFrame({**solved.header, "lattice": self._lattice}, solved.arrays)
        raise AssertionError("unreachable")

    def _prepare(self, index: int) -> FrameSolver:
        """A solver that holds the state of the frame before `index` in the epoch of `index`."""
        if self._solver is None:
            self._solver = self._connect(self.program.settings, self.program.bones)
        previous = index - 1 if index > 0 else None
        if previous is not None and self._at != previous:
            if self._last is None or self._last[0] != previous:
                raise AssertionError(f"frame {index} is wanted before frame {previous}")
            self._set_epoch(self._solver, self.program.frames[previous].epoch)
            state = fitted_state(self._last[1].arrays, self.program.settings.sutures)
            self._solver.set_state(str(self._last[1].header["precision"]), state)
        self._set_epoch(self._solver, self.program.frames[index].epoch)
        return self._solver

    def _set_epoch(self, solver: FrameSolver, epoch: int) -> None:
        if self._epoch == epoch:
            return
        position = next(i for i, each in enumerate(self.program.epochs) if each.index == epoch)
        program = self.program
        counts = solver.set_epoch(program.epochs[position], program.grips[position], program.landmarks_at[position])
        self._lattice = dict(counts)
        self._epoch = epoch

    def _abandon(self) -> None:
        self._close()
        self._at = self._epoch = None

    def _close(self) -> None:
        solver, self._solver = self._solver, None
        if solver is not None:
            solver.close()


def fitted_state(arrays: dict[str, NDArray[Any]], sutures: int) -> dict[str, NDArray[Any]]:
    """The state arrays of a frame for a procedure with so many sutures.

    Sutures are numbered in order of their start, so those that an edit added or removed after the frame are rows at the
    end that the frame had not placed yet: a gap of NaN, a multiplier of 0.
    """
    state = {name: arrays[name] for name in STATE_ARRAYS}
    for name, fill in (("state_suture_gaps", np.nan), ("suture_multipliers", 0.0)):
        fitted = np.full((sutures, 3), fill)
        kept = min(sutures, len(state[name]))
        fitted[:kept] = state[name][:kept]
        state[name] = fitted
    return state


def _refuse_output(output: Path) -> None:
    """Refuses, before anything is solved, a file that the skin cache could not be written to."""
    from lappet.usd_stage import SUFFIXES

    if output.suffix not in SUFFIXES:
        raise RefusedError(f"{output} does not end in a USD suffix; name the skin cache .usdc, .usda or .usd.")
    if output.is_dir():
        raise RefusedError(f"{output} is a folder; name a file for the skin cache.")
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=output.parent):
            pass
    except OSError as error:
        why = error.strerror or str(error)
        raise RefusedError(
            f"The skin cache {output} cannot be written ({why}); name a file in a folder that you may write to."
        ) from error


def _read(source: Path | str | Procedure, output: Path) -> tuple[Procedure, Path]:
    """The procedure and the file that the skin cache goes over."""
    if isinstance(source, Procedure):
        from lappet.usd_stage import write_procedure

        path = output.with_suffix(".procedure.usda")
        write_procedure(source, path)
        return source, path
    from lappet.usd_stage import read_procedure

    path = Path(source)
    if path.resolve() == output.resolve():
        raise RefusedError(f"{output} is the procedure itself; name another file for the skin cache.")
    return read_procedure(path), path


def _check(procedure: Procedure, spacing: float | None) -> None:
    from lappet.problem import ProcedureError
    from lappet.validation import check

    errors = [problem for problem in check(procedure, spacing=spacing) if problem.severity == "error"]
    if errors:
        raise ProcedureError(errors)


def _range(procedure: Procedure, frames: tuple[int | None, int | None]) -> tuple[int, int]:
    times = frame_times(procedure)
    first = times[0] if frames[0] is None else frames[0]
    last = times[-1] if frames[1] is None else frames[1]
    if not times[0] <= first <= last <= times[-1]:
        raise RefusedError(
            f"The frames {first}:{last} are not in the timeline, which runs from {times[0]} to {times[-1]}; "
            "give a first and a last frame inside it."
        )
    return first, last


class _Noting(Watcher):
    """Passes everything on and keeps the notes."""

    def __init__(self, watcher: Watcher) -> None:
        self._watcher = watcher
        self.sentences: list[str] = []

    def begin(self, frames: int) -> None:
        self._watcher.begin(frames)

    def iteration(self, iteration: Iteration) -> None:
        self._watcher.iteration(iteration)

    def frame(self, frame: FrameResult) -> None:
        self._watcher.frame(frame)

    def note(self, sentence: str) -> None:
        self.sentences.append(sentence)
        self._watcher.note(sentence)
