"""How a scene's solving stands, in numbers and in a line of plain words."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Literal

from ..interface.duration_text import duration_text
from ..interface.said import said
from ..model.tissue_size import cell_count
from .controller import Controller, Job
from .frame_states import count_states
from .speed_estimate import speed_estimate


@dataclass(frozen=True)
class Progress:
    """How it stands.

    running: a solve is under way. live: a hook is dragged. done, total: frames of the job, or of the procedure where
    there is none. time, newton, residual: where the job is, NaN and 0 where there is none. seconds: those still
    expected, NaN where nothing tells. line: for people. job_kind: "" where nothing is under way.
    """

    running: bool
    live: bool
    done: int
    total: int
    time: float
    newton: int
    residual: float
    seconds: float
    line: str
    job_kind: Literal["", "manifest", "solve", "live"]


def progress(controller: Controller) -> Progress:
    """How the solving of a scene stands."""
    job = controller.job
    if job is not None and job.kind == "solve":
        return _solving(controller, job)
    counts = count_states(controller)
    total = sum(counts.values())
    unsolved = total - counts["solved"]
    seconds = _expected(controller, unsolved)
    live = controller.live is not None
    kind: Literal["", "manifest", "live"] = "live" if live else "manifest" if controller.listing is not None else ""
    line = _live_line(controller) if live else _idle_line(controller, counts, seconds)
    return Progress(False, live, counts["solved"], total, math.nan, 0, math.nan, seconds, line, kind)


def _solving(controller: Controller, job: Job) -> Progress:
    left = max(job.total - job.done, 0)
    seconds = math.nan
    if job.frame_seconds:
        each = sum(job.frame_seconds) / len(job.frame_seconds)
        seconds = max(each * left - (time.monotonic() - job.frame_started), 0.0)
    elif job.manifest is not None:
        seconds = _expected(controller, left)
    if job.cancelled:
        line = said("Stopping after this iteration; what is solved is kept")
    elif job.manifest is None:
        line = said("Preparing the cuts and the lattice")
    elif job.settings.correction and 0 < job.total <= job.done:
        line = said("{total} frames; estimating the error", total=job.total)
    else:
        line = said("{done} of {total} frames", done=job.done, total=job.total)
        if not math.isnan(job.time):
            line += "; " + said("frame {frame}, iteration {iteration}", frame=f"{job.time:g}", iteration=job.newton)
        if not math.isnan(seconds) and left:
            line += "; " + said("{duration} left", duration=duration_text(seconds))
    return Progress(True, False, job.done, job.total, job.time, job.newton, job.residual, seconds, line, "solve")


_OTHERS = {"stale": "{count} stale", "failed": "{count} failed"}


def _expected(controller: Controller, frames: int) -> float:
    if frames == 0 or controller.procedure is None or not speed_estimate().known:
        return math.nan
    each = speed_estimate().seconds(controller.cells or cell_count(controller.procedure.tissue))
    return math.nan if each is None else each * frames


def _idle_line(controller: Controller, counts: dict, seconds: float) -> str:
    if controller.newest() is None:
        return said("Preparing the cuts" if controller.listing is not None else "Nothing is solved yet")
    total = sum(counts.values())
    words = [said("{solved} of {total} frames solved", solved=counts["solved"], total=total)]
    words += [said(_OTHERS[state], count=counts[state]) for state in _OTHERS if counts[state]]
    line = ", ".join(words)
    if controller.listing is not None:
        return f"{line}; " + said("preparing the cuts anew")
    if not math.isnan(seconds):
        line += f"; {duration_text(seconds)}"
    return line


def _live_line(controller: Controller) -> str:
    live = controller.live
    assert live is not None
    if live.frame is None:
        return said("Live: move the target of {hook}", hook=live.held)
    rate = f"{1.0 / live.seconds:.1f}" if live.seconds > 0.0 else "∞"
    settling = "" if live.converged else ", " + said("still settling")
    return said("Live: {hook}, {rate} frames a second", hook=live.held, rate=rate) + settling
