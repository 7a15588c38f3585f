"""Draw a skin cache: start one process of a Python that has bpy, which runs the add-on's figure module.

lappet itself never imports bpy: Blender takes a second and 400 MB to load, and clashes with usd-core in one process.
"""

from __future__ import annotations

import importlib.util
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO

from lappet.core.problem import Problem, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.usd.procedure_file import CHILD
from lappet.usd.stage_contents import ValueSizes

PYTHON_VARIABLE = "LAPPET_BLENDER_PYTHON"
ANIMATIONS = ("none", "png", "mp4")
ENGINES = ("cycles", "workbench")
VIEWS = ("oblique", "top", "low")
SAMPLES, MOVIE_SAMPLES = 6, 4
COLORS = ("grid", "plain", "strain", "stress", "tension")
INSTALL = "pip install 'lappet[render]'"
SYSTEM_PACKAGES = "libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libgl1"

Progress = Callable[[str], None]


def blender_python() -> str:
    """Find the Python that has bpy: `LAPPET_BLENDER_PYTHON`, else the current one.

    Returns
    -------
    str
        The interpreter's program.
    """
    return os.environ.get(PYTHON_VARIABLE) or sys.executable


def addon_folder() -> Path:
    """Find the folder that holds the add-on's package: installed beside lappet, or `addon/` of a source tree.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    RefusedError
        If neither is there.
    """
    spec = importlib.util.find_spec("lappet_blender")
    if spec is not None and spec.origin is not None:
        return Path(spec.origin).parent.parent
    source = Path(__file__).resolve().parents[3] / "addon"
    if (source / "lappet_blender" / "figure" / "__main__.py").is_file():
        return source
    raise refused(ProblemCode.RENDER_NO_ADDON, "lappet_blender", install=INSTALL)


def render_command(
    cache: Path,
    out_dir: Path,
    frames: Sequence[float] | None,
    filmstrip: bool,
    animation: str,
    size: tuple[int, int],
    samples: int,
    panel: tuple[int, int] | None,
    engine: str,
    view: str,
    color: str,
    threads: int,
    movie: tuple[int, int] | None = None,
    movie_samples: int = MOVIE_SAMPLES,
    translucent: bool = False,
    section: Sequence[float] | None = None,
) -> list[str]:
    """Compose the command line of the figure process.

    Parameters
    ----------
    cache
        The skin cache.
    out_dir
        Folder for the pictures.
    frames
        Time codes of the stills; None for the last one.
    filmstrip
        Whether to write the filmstrip.
    animation
        "none", "png" or "mp4".
    size
        Width and height of stills in pixels.
    samples
        Cycles samples per pixel of stills and panels.
    panel
        Width and height of the filmstrip's panels in pixels, or None.
    engine
        One of `ENGINES`.
    view
        One of `VIEWS`.
    color
        One of `COLORS`.
    threads
        Number of threads; 0 for all.
    movie
        Width and height of an animation in pixels, or None.
    movie_samples
        Cycles samples per pixel of an animation.
    translucent
        Whether vessels show through the skin.
    section
        A point in mm and a normal: what lies beyond this plane is taken away. None for no section.

    Returns
    -------
    list[str]
        The program and its arguments.

    Raises
    ------
    RefusedError
        If a value makes no sense.
    """
    for name, value, known in (
        ("animation", animation, ANIMATIONS),
        ("engine", engine, ENGINES),
        ("view", view, VIEWS),
        ("color", color, COLORS),
    ):
        if value not in known:
            raise refused(ProblemCode.RENDER_CHOICE, name, value, name=name, known=", ".join(known))
    for name, count in (("samples", samples), ("movie_samples", movie_samples)):
        if not 1 <= count <= 65536:
            raise refused(ProblemCode.RENDER_RANGE, name, count, name=name, range="1 to 65536")
    for name, pixels in (("size", size), ("panel", panel), ("movie_size", movie)):
        if pixels is not None and not all(16 <= side <= 16384 for side in pixels):
            given, allowed = f"{pixels[0]}x{pixels[1]}", "16 to 16384 pixels for each side"
            raise refused(ProblemCode.RENDER_RANGE, name, given, name=name, range=allowed)
    if frames is not None and not frames:
        raise refused(ProblemCode.RENDER_NO_FRAMES)
    command = [blender_python(), "-m", "lappet_blender.figure", str(cache), "-o", str(out_dir)]
    if frames is not None:
        command.append("--frames=" + ",".join(f"{float(f):.17g}" for f in frames))
    command += ["--filmstrip" if filmstrip else "--no-filmstrip", "--animation", animation, "--engine", engine]
    command += ["--size", f"{size[0]}x{size[1]}", "--samples", str(samples), "--view", view, "--color", color]
    command += ["--movie-samples", str(movie_samples)]
    if translucent:
        command.append("--translucent")
    if section is not None:
        if len(section) != 6 or not all(map(math.isfinite, section)) or not any(section[3:]):
            given, allowed = ",".join(f"{value:g}" for value in section), "a point and a normal that is not zero"
            raise refused(ProblemCode.RENDER_RANGE, "section", given, name="section", range=allowed)
        command.append("--section=" + ",".join(f"{float(value):.17g}" for value in section))
    for option, pixels in (("--panel", panel), ("--movie", movie)):
        if pixels is not None:
            command += [option, f"{pixels[0]}x{pixels[1]}"]
    return [*command, "--threads", str(threads)] if threads > 0 else command


def render_cache(
    cache: Path,
    out_dir: Path,
    frames: Sequence[float] | None = None,
    filmstrip: bool = True,
    animation: str = "none",
    size: tuple[int, int] = (1280, 960),
    samples: int = SAMPLES,
    *,
    panel: tuple[int, int] | None = None,
    engine: str = "cycles",
    view: str = "oblique",
    color: str = "grid",
    threads: int = 0,
    movie_size: tuple[int, int] | None = None,
    movie_samples: int = MOVIE_SAMPLES,
    translucent: bool = False,
    section: Sequence[float] | None = None,
    progress: Progress | None = None,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> list[Path]:
    """Draw a skin cache as pictures in one Blender process.

    On KeyboardInterrupt the process is ended and the pictures that are done stay.

    Parameters
    ----------
    cache
        The `.usdc` that `lappet solve` wrote.
    out_dir
        Folder for the pictures.
    frames
        Time codes of the stills; None for the last one.
    filmstrip
        Whether to write `filmstrip.png`: the steps of the operation (or the chosen frames, where there are several),
        captioned on one sheet.
    animation
        "none", "png" (a numbered sequence) or "mp4".
    size
        Width and height of stills in pixels.
    samples
        Cycles samples per pixel of stills and panels, which are denoised.
    panel
        Width and height of the filmstrip's panels in pixels; None for 7/16 of `size`.
    engine
        One of `ENGINES`.
    view
        One of `VIEWS`.
    color
        One of `COLORS`.
    threads
        Number of threads; 0 for all.
    movie_size
        Width and height of an animation in pixels; None for half of `size`.
    movie_samples
        Cycles samples per pixel of an animation, which is denoised.
    translucent
        Whether vessels show through the skin.
    section
        A point in mm and a normal, of the solved tissue: what lies beyond this plane is taken away, and the cut face
        shows layers and vessels. None for no section.
    progress
        Called with a line of text for every file, and with how long an animation will take.
    limits
        What reading the cache may take: a child process reads all of it before Blender does.

    Returns
    -------
    list[Path]
        The files in the order in which they were written.

    Raises
    ------
    RefusedError
        If bpy is missing, the cache cannot be drawn or the process dies.
    """
    cache, out_dir = Path(cache).resolve(), Path(out_dir).resolve()
    if not cache.is_file():
        raise refused(ProblemCode.RENDER_NO_CACHE, cache, cache)
    command = render_command(
        cache,
        out_dir,
        frames,
        filmstrip,
        animation,
        size,
        samples,
        panel,
        engine,
        view,
        color,
        threads,
        movie_size,
        movie_samples,
        translucent,
        section,
    )
    with ReadingProcess(CHILD, "values", cache, limits) as look:
        look.result(ValueSizes)
    return run_figures(command, cache, progress or (lambda line: None))


def run_figures(command: list[str], cache: Path, say: Progress) -> list[Path]:
    """Run a process that draws to its end. On KeyboardInterrupt it is ended.

    Parameters
    ----------
    command
        The program and its arguments.
    cache
        What it draws, for messages.
    say
        Called with a line of text for every file.

    Returns
    -------
    list[Path]
        The files in the order in which it wrote them.

    Raises
    ------
    RefusedError
        If bpy is missing, the cache cannot be drawn or the process dies.
    """
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as chatter:
        process = _start(command, chatter)
        try:
            written, refusal, finished = _follow(process, say)
            status = process.wait()
        except BaseException:
            _end(process)
            raise
        if refusal:
            raise refused(ProblemCode.RENDER_REFUSED, cache, refusal)
        if status != 0 or not finished:
            chatter.seek(0)
            raise RefusedError([_failure(status, chatter.read(), command[0])])
    return written


def _start(command: list[str], chatter: IO[str]) -> subprocess.Popen[str]:
    """Start the figure process, which finds this lappet and the add-on and prints what is no message to `chatter`."""
    own = str(Path(__file__).resolve().parents[2])
    paths = [str(addon_folder()), own, *filter(None, [os.environ.get("PYTHONPATH")])]
    try:
        return subprocess.Popen(
            command,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=chatter,
            encoding="utf-8",
            errors="replace",
        )
    except OSError as error:
        raise refused(ProblemCode.RENDER_NO_PYTHON, command[0], command[0], reason=error.strerror) from error


def _follow(process: subprocess.Popen[str], say: Progress) -> tuple[list[Path], str, bool]:
    """Read the figure process's messages to the end: files written, its refusal, whether it said it was done."""
    written: list[Path] = []
    refusal, finished = "", False
    assert process.stdout is not None
    for line in process.stdout:
        try:
            message = json.loads(line)
        except json.JSONDecodeError:
            continue
        if not isinstance(message, dict):
            continue
        if "picture" in message:
            path = Path(message["picture"])
            written.append(path)
            say(f"picture {message['number']} of {message['of']}: {path.name}")
        if "note" in message:
            say(str(message["note"]))
        refusal = message.get("error", refusal)
        finished = finished or bool(message.get("done"))
    return written, refusal, finished


def _end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    try:
        process.wait(timeout=5)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _failure(status: int, chatter: str, python: str) -> Problem:
    """Return why the figure process failed, from its exit status and what Python and the linker printed."""
    if "No module named 'bpy'" in chatter:
        return problem(ProblemCode.RENDER_NO_BPY, python, python, install=INSTALL)
    lines = [line.strip() for line in chatter.splitlines() if line.strip()]
    last = lines[-1] if lines else "it said nothing"
    if "cannot open shared object file" in chatter:
        return problem(ProblemCode.RENDER_NO_LIBRARY, python, last, packages=SYSTEM_PACKAGES)
    how = f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"
    return problem(ProblemCode.RENDER_FAILED, python, last, how=how)
