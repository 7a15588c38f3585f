"""`lappet export CACHE.usdc -o X.abc` (`.fbx`): formats that Blender writes, from the .glb, in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

from lappet.core.durable import check_space, draft_folder, replace_durably
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import chosen_frames, exported_cache
from lappet.export.glb_file import write_glb
from lappet.output.render import addon_folder, blender_python

_SECONDS = 1800.0


def write_by_blender(request: ExportRequest) -> list[Path]:
    """Write a solved procedure as Alembic or FBX, in metres; its first frame is frame 0 of the file.

    Parameters
    ----------
    request
        The cache, the file and the options `frames` and `simplify`.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If bpy is missing, the cache cannot be read or shown, has no such frame, or Blender fails.
    OSError
        If the file cannot be written.
    """
    _check_blender(request.target)
    cache = exported_cache(request.caches[0], request.limits)
    frames = chosen_frames(cache, request.options.get("frames"))
    target = request.target.resolve()
    with draft_folder(target) as folder:
        source, draft = folder / "skin.glb", folder / target.name
        write_glb(replace(request, target=source))
        last = round(frames[-1] - frames[0])
        arguments = [str(source), str(draft), f"{cache.fps:.17g}", str(last)]
        command = [blender_python(), "-m", "lappet_blender.figure.convert_glb", *arguments]
        answer = _answer(_run(command, request.target))
        if not answer.get("done"):
            check_space(folder, target)
            raise refused(ProblemCode.EXPORT_BLENDER, request.target, answer.get("error", "it gives no reason"))
        replace_durably(draft, target)
    return [request.target]


def _check_blender(target: Path) -> None:
    """Refuse before anything is read where Blender is not there."""
    found = _run([blender_python(), "-c", "import importlib.util as u; print(u.find_spec('bpy') is not None)"], target)
    if found.stdout.strip() != "True":
        raise refused(ProblemCode.EXPORT_NO_BPY, target, blender_python())


def _run(command: list[str], target: Path) -> subprocess.CompletedProcess[str]:
    own = str(Path(__file__).resolve().parents[2])
    paths = [str(addon_folder()), own, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    try:
        return subprocess.run(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=_SECONDS,
            check=False,
        )
    except OSError as error:
        raise refused(ProblemCode.EXPORT_NO_BPY, target, command[0]) from error
    except subprocess.TimeoutExpired as error:
        raise refused(ProblemCode.EXPORT_BLENDER, target, f"it was not done after {_SECONDS:g} s") from error


def _answer(done: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    """The process's line of JSON, or the last line of what it said where it failed."""
    for line in reversed(done.stdout.splitlines()):
        if line.startswith("{"):
            found: dict[str, Any] = json.loads(line)
            return found
    said = [line for line in done.stderr.splitlines() if line.strip()]
    return {"error": said[-1] if said else f"its process ended with {done.returncode}"}
