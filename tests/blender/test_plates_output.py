"""Plates, films and exports are written by an installed command, in the background."""

from __future__ import annotations

import stat
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
import pytest

import lappet_blender
from event_patch import co, patch_scene
from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import DaemonMissing
from lappet.daemon.process import find_daemon
from lappet.export.simplify_target import SimplifyTarget
from lappet_blender.plates import output_jobs
from lappet_blender.plates.command_job import CommandJob, find_command
from lappet_blender.plates.windows_job import WindowsJob
from lappet_blender.translation.dictionary import LANGUAGES, messages
from refusals import refusal

TOP = 2.0
ops = bpy.ops.lappet
DRAWS = """#!{python}
import pathlib, sys
cache = pathlib.Path(sys.argv[2])
print("painting panel A", file=sys.stderr)
said = " ".join([sys.argv[1], str(cache.is_file()), *sys.argv[3:]])
pathlib.Path(sys.argv[sys.argv.index("-o") + 1]).write_text(said)
"""
STUCK = """#!{python}
import time
print("drawing", flush=True)
time.sleep(600)
"""
# As `lappet film` starts Blender and FFmpeg; the child does not end when it is asked to.
BUSY = """#!{python}
import subprocess, sys, time
child = "import signal, sys, time; signal.signal(signal.SIGTERM, signal.SIG_IGN)\\n"
child += "while True: open(sys.argv[1], 'a').write('.'); time.sleep(0.05)"
subprocess.Popen([sys.executable, "-c", child, sys.argv[4]])
print("drawing", flush=True)
time.sleep(600)
"""
# What it writes for itself is left behind when it is ended.
LITTERS = """#!{python}
import pathlib, sys, tempfile, time
pathlib.Path(sys.argv[4]).write_text(tempfile.mkdtemp())
print("drawing", flush=True)
time.sleep(600)
"""
FAILS = """#!{python}
import sys
print("error: The language 'xx' is not known.", file=sys.stderr)
sys.exit(2)
"""


def program(folder: Path, text: str) -> Path:
    """A program called lappet in a folder."""
    folder.mkdir(exist_ok=True)
    path = folder / "lappet"
    path.write_text(text.format(python=sys.executable))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def job(folder: Path, text: str, cache: object = lambda path: path.write_text("")) -> CommandJob:
    """A job of a program of our own, started."""
    made = CommandJob(
        folder / "plate.svg",
        [str(program(folder / "bin", text))],
        cache,  # type: ignore[arg-type]
        lambda path: ["plate", str(path), "-o", str(folder / "plate.svg"), "--plate", "mine"],
    )
    made.start()
    return made


@pytest.fixture
def slit(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A slit patch with a plate; nothing is solved."""
    patch_scene(scene, (24.0, 16.0, TOP), 3, resolution=2.0)
    scene.lappet.tissue.spacing = 2.0
    ops.incision_add(points=co([(-5.7, 0, TOP), (5.7, 0.3, TOP)]), time=2, kerf=0.1)
    ops.plate_add(template="steps")
    yield scene
    output_jobs.stop()


def test_a_job_writes_the_cache_and_runs_the_command_on_it(tmp_path: Path) -> None:
    made = job(tmp_path, DRAWS)
    made.join(20.0)
    assert made.state == "done"
    said = (tmp_path / "plate.svg").read_text()
    assert said == f"plate True -o {tmp_path / 'plate.svg'} --plate mine"
    assert list(made.said) == ["painting panel A"]


def test_what_the_command_says_when_it_fails_is_the_problem(tmp_path: Path) -> None:
    made = job(tmp_path, FAILS)
    made.join(20.0)
    assert made.state == "failed"
    assert made.problem is not None
    assert made.problem.code is ProblemCode.LAPPET_COMMAND_FAILED
    assert "'xx'" in str(made.problem.value)


def test_a_cache_that_cannot_be_written_is_the_problem_and_no_command_runs(tmp_path: Path) -> None:
    def cache(_path: Path) -> None:
        raise refused(ProblemCode.FRAMES_NOT_SOLVED, "", 2, count=3)

    made = job(tmp_path, DRAWS, cache)
    made.join(20.0)
    assert made.problem is not None
    assert made.problem.code is ProblemCode.FRAMES_NOT_SOLVED
    assert not (tmp_path / "plate.svg").exists()


def test_a_cancelled_command_ends_at_once(tmp_path: Path) -> None:
    made = job(tmp_path, STUCK)
    end = time.monotonic() + 20.0
    while not made.said and time.monotonic() < end:
        time.sleep(0.02)
    assert made.running
    began = time.monotonic()
    made.cancel(10.0)
    assert time.monotonic() - began < 5.0
    assert (made.state, made.problem) == ("cancelled", None)
    assert made._tree is not None
    assert made._tree.process.poll() is not None


def test_what_a_cancelled_command_has_started_ends_too(tmp_path: Path) -> None:
    made = job(tmp_path, BUSY)
    beat = tmp_path / "plate.svg"  # where its child writes, on and on
    end = time.monotonic() + 20.0
    while not (made.said and beat.exists() and beat.stat().st_size > 3) and time.monotonic() < end:
        time.sleep(0.02)
    made.cancel(20.0)
    assert made.state == "cancelled"
    before = beat.stat().st_size
    time.sleep(0.5)
    assert beat.stat().st_size == before > 3


def test_a_cancelled_command_leaves_no_temporary_files(tmp_path: Path) -> None:
    made = job(tmp_path, LITTERS)
    end = time.monotonic() + 20.0
    while not made.said and time.monotonic() < end:
        time.sleep(0.02)
    litter = Path((tmp_path / "plate.svg").read_text())
    assert litter.is_dir()
    made.cancel(10.0)
    assert not litter.exists()


class Recorded:
    """Windows' functions, of which some fail; what is called is written down."""

    def __init__(self, *failing: str) -> None:
        self.calls: list[str] = []
        self.failing = failing

    def __getattr__(self, name: str) -> Callable[..., int]:
        def call(*_values: object) -> int:
            self.calls.append(name)
            return 0 if name in self.failing else 7

        return call


class Suspended:
    """A process as Windows starts it; `flags` are those that it was started with."""

    def __init__(self, _command: Sequence[str], creationflags: int) -> None:
        self._handle, self.flags, self.ended = 11, creationflags, False

    def kill(self) -> None:
        self.ended = True

    def wait(self) -> int:
        return 1


def test_on_windows_a_command_goes_on_only_once_it_is_in_its_job(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subprocess, "Popen", Suspended)
    system = Recorded()
    made = WindowsJob(system)
    process = made.start(["lappet"], creationflags=0x08000000)
    assert process.flags == 0x08000004  # type: ignore[attr-defined]  # without a window, suspended
    made.end()
    made.close()
    made.close()
    assert system.calls == [
        *("CreateJobObjectW", "SetInformationJobObject", "AssignProcessToJobObject", "NtResumeProcess"),
        *("TerminateJobObject", "CloseHandle"),
    ]


def test_on_windows_a_command_that_comes_into_no_job_does_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[Suspended] = []

    def popen(command: Sequence[str], **options: int) -> Suspended:
        started.append(Suspended(command, **options))
        return started[0]

    monkeypatch.setattr(subprocess, "Popen", popen)
    system = Recorded("AssignProcessToJobObject")
    with pytest.raises(OSError, match="into its job"):
        WindowsJob(system).start(["lappet"])
    assert started[0].ended
    assert "NtResumeProcess" not in system.calls


def test_without_a_command_a_sentence_says_so(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RefusedError) as caught:
        find_command("")
    assert caught.value.problems[0].code is ProblemCode.LAPPET_COMMAND_NONE
    found = refusal(lambda: ops.plate_write(filepath=str(tmp_path / "plate.pdf")))
    assert found.code is ProblemCode.LAPPET_COMMAND_NONE
    named = program(tmp_path / "elsewhere", DRAWS)
    assert find_command(str(named)) == [str(named)]


def test_what_cannot_be_written_is_refused_before_anything_begins(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slit.lappet.tissue.spacing = 1.9  # as nobody has solved it
    monkeypatch.setenv("PATH", str(program(tmp_path / "bin", DRAWS).parent))
    for act in (ops.plate_write, ops.film_write):
        assert refusal(lambda a=act: a(filepath=str(tmp_path / "x.doc"))).code is ProblemCode.OUTPUT_SUFFIX
    assert refusal(lambda: ops.export_result(filepath=str(tmp_path / "x.doc"))).code is ProblemCode.EXPORT_SUFFIX
    slit.lappet.pages.clear()
    found = refusal(lambda: ops.plate_write(filepath=str(tmp_path / "x.pdf")))
    assert found.code is ProblemCode.PLATE_NONE_CHOSEN
    assert output_jobs.last_job() is None
    unsolved = refusal(lambda: ops.film_write(filepath=str(tmp_path / "x.mp4"), wait=True))
    assert unsolved.code is ProblemCode.FRAMES_NOT_SOLVED


def test_solved_frames_become_what_the_operators_say(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))
    ops.solve(wait=True)
    monkeypatch.setenv("PATH", str(program(tmp_path / "bin", DRAWS).parent))
    plate, film, lesson = (tmp_path / name for name in ("a.svg", "b.mp4", "c.html"))
    assert ops.plate_write(filepath=str(plate), style="ink", transparent=True, wait=True) == {"FINISHED"}
    assert plate.read_text() == f"plate True -o {plate} --plate steps --dpi 300 --style ink --transparent"
    ops.film_write(filepath=str(film), style="wash", fps=4.0, wait=True)
    assert film.read_text() == f"film True -o {film} --style wash --size 1920x1080 --fps 4 --pause 2"
    ops.export_result(filepath=str(lesson), wait=True)
    assert lesson.read_text() == f"export True -o {lesson}"


def test_a_skin_is_simplified_on_the_way_out_as_the_command_line_does_it(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is asked for goes to the command as it was written; the frames are not looked for here."""
    monkeypatch.setattr(output_jobs, "write_request", lambda _request, cache: cache.write_text(""))
    monkeypatch.setenv("PATH", str(program(tmp_path / "bin", DRAWS).parent))
    target = tmp_path / "c.glb"
    for wanted in ("20000", "0.2mm"):
        assert ops.export_result(filepath=str(target), simplify=f" {wanted} ", wait=True) == {"FINISHED"}
        assert target.read_text() == f"export True -o {target} --simplify {wanted}"
        assert SimplifyTarget.of(wanted) in (SimplifyTarget(triangles=20000), SimplifyTarget(error_mm=0.2))
    ops.export_result(filepath=str(target), simplify="  ", wait=True)
    assert target.read_text() == f"export True -o {target}"


def test_what_the_command_line_would_not_simplify_is_refused_before_anything_begins(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(program(tmp_path / "bin", DRAWS).parent))
    for wanted in ("much", "12", "0.2", "200mm"):
        found = refusal(lambda w=wanted: ops.export_result(filepath=str(tmp_path / "x.glb"), simplify=w))
        assert (found.code, found.value) == (ProblemCode.EXPORT_SIMPLIFY_TARGET, wanted)
    found = refusal(lambda: ops.export_result(filepath=str(tmp_path / "x.csv"), simplify="20000"))
    assert found.code is ProblemCode.EXPORT_OPTION
    assert output_jobs.last_job() is None


def test_the_options_of_an_export_are_shown_in_the_language_of_the_interface(addon: None) -> None:
    shown = ops.export_result.get_rna_type().properties
    for name in ("every_frame", "simplify"):
        for text in (shown[name].name, shown[name].description):
            assert len(messages()[text]) == len(LANGUAGES)


def test_the_command_line_of_this_version_draws_a_plate_that_blender_made(
    slit: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))
    pytest.importorskip("drawsvg")
    text = "#!{python}\nfrom lappet.commands.cli import main\nmain()\n"
    monkeypatch.setenv("PATH", str(program(tmp_path / "bin", text).parent))
    ops.annotation_put(kind="label", text="loose skin", points=co([(2, 3, TOP)]))
    ops.annotation_place(annotation="loose_skin", offset=(6, -5))
    ops.solve(wait=True)
    assert ops.plate_write(filepath=str(tmp_path / "plate.svg"), wait=True) == {"FINISHED"}
    drawn = (tmp_path / "plate.svg").read_text()
    assert "loose skin" in drawn
    assert drawn.rstrip().endswith("</svg>")


def test_the_add_on_goes_while_a_file_is_being_written(slit: bpy.types.Scene, tmp_path: Path) -> None:
    made = job(tmp_path, STUCK)
    output_jobs._jobs[:] = [made]
    lappet_blender.unregister()
    try:
        made.join(10.0)
        assert made.state == "cancelled"
        assert not hasattr(bpy.types, "LAPPET_PT_plate")
        assert not hasattr(bpy.types.Scene, "lappet")
    finally:
        lappet_blender.register()
    assert hasattr(bpy.types, "LAPPET_PT_plate")
