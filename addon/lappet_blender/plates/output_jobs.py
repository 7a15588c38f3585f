"""The files that are being written in the background, one at a time, and what the panel says of the last one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from time import monotonic

import bpy

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..files.bundled_pxr import bundled_pxr
from ..files.export_usd import cache_request, write_request
from ..interface.problem_sentence import problem_sentence
from ..interface.redraw_windows import redraw_windows
from ..solving.chosen_daemon import ADDON
from .command_job import CommandJob, find_command

_EVERY = 0.3  # seconds
_ENDING = 2.0  # seconds that the end of the add-on waits for a command
_jobs: list[CommandJob] = []  # none or one: the one under way, or the last


def last_job() -> CommandJob | None:
    """The job under way, or else the last one; None where there was none."""
    return _jobs[0] if _jobs else None


def named_command() -> str:
    """The command that the preferences name, "" for the one on the search path."""
    entry = bpy.context.preferences.addons.get(ADDON)
    return "" if entry is None or entry.preferences is None else str(entry.preferences.command)


def begin_output(scene: bpy.types.Scene, target: Path, arguments: Callable[[Path], Sequence[str]]) -> CommandJob:
    """Write the scene's solved frames as a skin cache beside nothing, and a file from it, both in the background.

    arguments: of `lappet`, from the skin cache's file on. Raises RefusedError before anything has begun: where there is
    no command or another file is being written, and where the scene holds no procedure.
    """
    job = last_job()
    if job is not None and job.running:
        raise refused(ProblemCode.OUTPUT_BUSY, "", job.target.name)
    command = find_command(named_command())
    bundled_pxr()
    request = cache_request(scene)
    made = CommandJob(target, command, lambda cache: write_request(request, cache), arguments)
    _jobs[:] = [made]
    made.start()
    if not bpy.app.background and not bpy.app.timers.is_registered(_watch):
        bpy.app.timers.register(_watch, first_interval=_EVERY, persistent=True)
    return made


def cancel_output() -> bool:
    """End the job under way; whether there was one."""
    job = last_job()
    if job is None or not job.running:
        return False
    job.cancel()
    return True


def state_line() -> str:
    """What the panel says of the job, "" where there was none."""
    job = last_job()
    if job is None:
        return ""
    seconds = (monotonic() - job.started) if job.running else job.seconds
    match job.state:
        case "cache":
            return f"{job.target.name}: reading the solved frames, {seconds:.0f} s"
        case "drawing":
            said = f": {job.said[-1]}" if job.said else ""
            return f"{job.target.name}, {seconds:.0f} s{said}"
        case "done":
            return f"Wrote {job.target.name} in {seconds:.0f} s."
        case "cancelled":
            return f"{job.target.name} was cancelled."
    return "" if job.problem is None else problem_sentence(job.problem)


def _watch() -> float | None:
    """Have the panel say what is new, until the job has ended."""
    redraw_windows()
    job = last_job()
    return _EVERY if job is not None and job.running else None


def stop() -> None:
    """The add-on is taken away: the job ends."""
    if bpy.app.timers.is_registered(_watch):
        bpy.app.timers.unregister(_watch)
    job = last_job()
    if job is not None and job.running:
        job.cancel(_ENDING)
    _jobs.clear()
