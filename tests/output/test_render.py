"""Pictures end to end: the figure process, what it draws, and every sentence it can refuse with."""

from __future__ import annotations

import math
import os
import re
import shlex
import stat
import struct
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom

import synthetic_skin_cache as synthetic
from lappet.core.problem_code import ProblemCode
from lappet.output.render import PYTHON_VARIABLE, render_cache
from refusals import refuses

SIZE = (112, 84)


def read_png(path: Path) -> NDArray[np.uint8]:
    """Pixels (height, width, 3) of an 8-bit RGB or RGBA PNG, decoded here so that nothing of ours checks itself."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, header = 8, b"", b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        header = body if kind == b"IHDR" else header
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height, depth, color = struct.unpack(">IIBB", header[:10])
    assert depth == 8
    channels = {2: 3, 6: 4}[color]
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * channels)
    rows = np.zeros((height + 1, (width + 1) * channels), np.int64)
    for y in range(height):
        line, kind = raw[y, 1:].astype(np.int64), int(raw[y, 0])
        above, here = rows[y], rows[y + 1]
        for x in range(width * channels):
            left, up, corner = here[x], above[x + channels], above[x]
            guess = left + up - corner
            paeth = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            here[x + channels] = (line[x] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
    return rows[1:, channels:].reshape(height, width, channels)[..., :3].astype(np.uint8)


def flesh(picture: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Pixels that are red flesh: neither skin (much green) nor paper nor steel."""
    red, green = picture[..., 0].astype(float), picture[..., 1].astype(float)
    return (red > 60) & (red > 2.0 * green)


def script(path: Path, text: str) -> Path:
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=2.0)


@pytest.fixture(scope="module")
def drawn(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Path], list[str]]:
    out = tmp_path_factory.mktemp("figures") / "new folder"
    lines: list[str] = []
    files = render_cache(
        cache,
        out,
        frames=[12],
        animation="mp4",
        size=SIZE,
        panel=(56, 42),
        movie_size=SIZE,
        samples=2,
        movie_samples=2,
        threads=2,
        progress=lines.append,
    )
    return out, files, lines


@pytest.mark.slow
def test_stills_a_filmstrip_and_a_movie_are_written_and_reported(drawn: tuple[Path, list[Path], list[str]]) -> None:
    out, files, lines = drawn
    names = [str(f.relative_to(out)) for f in files]
    frames = [f"frames/{k:04d}.png" for k in range(1, len(synthetic.FRAMES) + 1)]
    steps = [f"step_{k}.png" for k in range(1, 7)]
    assert names == ["frame_0012.png", *steps, "filmstrip.png", *frames, "animation.mp4"]
    assert all(f.stat().st_size > 100 for f in files)
    assert lines[0] == f"picture 1 of {len(files)}: frame_0012.png"
    (note,) = (line for line in lines if not line.startswith("picture "))
    assert re.fullmatch(r"animation of 12 frames, 112x84: [\d.]+ s a frame, about \d+ s to go", note)
    assert lines.index(note) == names.index("frames/0002.png") + 1
    assert len(lines) == len(files) + 1
    assert not list(out.rglob(".*"))  # no drafts stay behind
    movie = (out / "animation.mp4").read_bytes()
    assert movie[4:8] == b"ftyp"
    assert b"avc1" in movie


@pytest.mark.slow
def test_a_still_has_its_size_and_the_open_wound_is_flesh_where_skin_was(
    drawn: tuple[Path, list[Path], list[str]],
) -> None:
    out, _, _ = drawn
    whole, lifted, closed = (read_png(out / "frames" / f"{k:04d}.png") for k in (1, 7, 12))
    assert whole.shape == (SIZE[1], SIZE[0], 3)
    assert read_png(out / "frame_0012.png").std() > 8
    assert flesh(whole).mean() < 0.002
    assert flesh(lifted).mean() > 0.03
    assert flesh(closed).mean() < 0.25 * flesh(lifted).mean()
    rows, columns = np.nonzero(flesh(lifted))
    assert 0.25 < columns.mean() / SIZE[0] < 0.75
    assert 0.2 < rows.mean() / SIZE[1] < 0.8
    skin = whole[SIZE[1] // 2 :].reshape(-1, 3).astype(float).mean(axis=0)
    assert skin[0] > skin[1] > skin[2]  # warm
    assert 1.1 < skin[0] / skin[1] < 1.6  # and not orange plastic


@pytest.mark.slow
def test_the_filmstrip_shows_six_captioned_panels(drawn: tuple[Path, list[Path], list[str]]) -> None:
    from lappet_blender.figure.sheet_layout import sheet_layout

    out, _, _ = drawn
    sheet = read_png(out / "filmstrip.png")
    (width, height), corners, caption = sheet_layout(6, (56, 42))
    assert sheet.shape == (height, width, 3)
    for k, (x, y) in enumerate(corners, start=1):
        panel = sheet[y : y + 42, x : x + 56]
        np.testing.assert_allclose(panel.astype(int), read_png(out / f"step_{k}.png").astype(int), atol=1)
        below = sheet[y + 42 + 2 : y + 42 + caption, x : x + 56]
        assert below.min() < 180 < below.max()  # ink on paper


@pytest.mark.slow
def test_the_last_panel_is_the_still_made_smaller_and_not_drawn_again(
    drawn: tuple[Path, list[Path], list[str]],
) -> None:
    out, _, _ = drawn
    still = read_png(out / "frame_0012.png").astype(float)
    halves = still.reshape(42, 2, 56, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(read_png(out / "step_6.png"), halves, atol=1.01)


@pytest.mark.slow
def test_a_frame_that_the_cache_lacks_is_refused_before_anything_is_drawn(cache: Path, tmp_path: Path) -> None:
    with refuses(ProblemCode.RENDER_REFUSED, str(cache)):
        render_cache(cache, tmp_path / "out", frames=[1, 99], filmstrip=False)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_draft_shows_the_printed_grid(cache: Path, tmp_path: Path) -> None:
    """From above the ink of flat skin lies in lines at even distances, in both directions."""
    drawn = {}
    for color in ("plain", "grid"):
        (file,) = render_cache(
            cache,
            tmp_path / color,
            frames=[1],
            filmstrip=False,
            size=(224, 168),
            view="top",
            color=color,
            engine="workbench",
        )
        drawn[color] = read_png(file).astype(float).sum(axis=2)
    ink = drawn["plain"] - drawn["grid"] > 20.0
    assert 0.05 < ink.mean() < 0.5
    for axis in (0, 1):
        line = np.flatnonzero(ink.mean(axis=axis) > 0.7)
        middles = [part.mean() for part in np.split(line, np.flatnonzero(np.diff(line) > 1) + 1)]
        assert len(middles) >= 4
        squares = np.diff(middles) / np.median(np.diff(middles))  # the planned cut hides the line below it
        assert np.abs(squares - squares.round()).max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["cycles", "workbench"])
def test_strain_is_drawn_with_a_key_from_above(cache: Path, tmp_path: Path, engine: str) -> None:
    looks = {"view": "top", "color": "strain", "engine": engine}
    (file,) = render_cache(cache, tmp_path, frames=[7], filmstrip=False, size=SIZE, samples=2, threads=2, **looks)
    picture = read_png(file).astype(float)
    bar = picture[round(SIZE[1] * 0.93) + 1, round(SIZE[0] * 0.035) : round(SIZE[0] * 0.275)]
    assert bar[2, 2] > bar[2, 0] + 40  # blue where strain is low
    assert bar[-3, 0] > bar[-3, 2] + 60  # red where it is high
    unstrained = picture[:12, :12].reshape(-1, 3).mean(axis=0)
    assert unstrained[2] > unstrained[0]


@pytest.mark.slow
def test_a_file_that_is_no_cache_is_refused_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "noise.usdc").write_bytes(b"nothing of use")
    with refuses(ProblemCode.USD_UNREADABLE, str(tmp_path / "noise.usdc")):
        render_cache(tmp_path / "noise.usdc", tmp_path / "out")


def test_a_missing_cache_is_refused_and_the_refusal_is_one_of_lappets(tmp_path: Path) -> None:
    with refuses(ProblemCode.RENDER_NO_CACHE, str(tmp_path / "gone.usdc")):
        render_cache(tmp_path / "gone.usdc", tmp_path)


@pytest.mark.parametrize(
    ("wrong", "code"),
    [
        ({"animation": "gif"}, ProblemCode.RENDER_CHOICE),
        ({"engine": "eevee"}, ProblemCode.RENDER_CHOICE),
        ({"view": "below"}, ProblemCode.RENDER_CHOICE),
        ({"color": "red"}, ProblemCode.RENDER_CHOICE),
        ({"samples": 0}, ProblemCode.RENDER_RANGE),
        ({"size": (0, 480)}, ProblemCode.RENDER_RANGE),
        ({"panel": (99999, 480)}, ProblemCode.RENDER_RANGE),
        ({"movie_size": (8, 480)}, ProblemCode.RENDER_RANGE),
        ({"movie_samples": 0}, ProblemCode.RENDER_RANGE),
        ({"frames": []}, ProblemCode.RENDER_NO_FRAMES),
    ],
)
def test_a_value_that_makes_no_sense_is_named(cache: Path, tmp_path: Path, wrong: dict, code: ProblemCode) -> None:
    with refuses(code, None if code is ProblemCode.RENDER_NO_FRAMES else next(iter(wrong))):
        render_cache(cache, tmp_path, **wrong)


def test_a_python_without_bpy_is_told_how_to_get_it(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bare = script(tmp_path / "python", f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -S "$@"\n')
    monkeypatch.setenv(PYTHON_VARIABLE, str(bare))
    with refuses(ProblemCode.RENDER_NO_BPY, str(bare)):
        render_cache(cache, tmp_path / "out")


def test_a_python_that_cannot_be_started_is_named(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PYTHON_VARIABLE, str(tmp_path / "no-such-python"))
    with refuses(ProblemCode.RENDER_NO_PYTHON, str(tmp_path / "no-such-python")):
        render_cache(cache, tmp_path / "out")


def test_a_figure_process_that_dies_is_reported_with_its_last_words(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dying = script(tmp_path / "python", "#!/bin/sh\necho 'Blender ran out of memory' >&2\nkill -9 $$\n")
    monkeypatch.setenv(PYTHON_VARIABLE, str(dying))
    with refuses(ProblemCode.RENDER_FAILED, str(dying)) as problems:
        render_cache(cache, tmp_path / "out")
    assert problems[0].value == "Blender ran out of memory"


def test_a_missing_system_library_is_answered_with_the_packages(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = "ImportError: libSM.so.6: cannot open shared object file: No such file or directory"
    monkeypatch.setenv(PYTHON_VARIABLE, str(script(tmp_path / "python", f"#!/bin/sh\necho '{words}' >&2\nexit 1\n")))
    with refuses(ProblemCode.RENDER_NO_LIBRARY) as problems:
        render_cache(cache, tmp_path / "out")
    assert problems[0].value == words


def test_an_interrupt_ends_the_figure_process_and_keeps_what_is_done(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = tmp_path / "frame_0001.png"
    slow = script(
        tmp_path / "python",
        "#!/bin/sh\n"
        f"echo $$ > {tmp_path}/pid\necho picture > {done}\n"
        f'echo \'{{"picture": "{done}", "number": 1, "of": 2}}\'\n'
        "exec sleep 60\n",
    )
    monkeypatch.setenv(PYTHON_VARIABLE, str(slow))

    def interrupt(line: str) -> None:
        assert line == "picture 1 of 2: frame_0001.png"
        raise KeyboardInterrupt

    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        render_cache(cache, tmp_path / "out", progress=interrupt)
    assert time.monotonic() - begun < 20
    assert done.exists()
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


@pytest.mark.slow
def test_what_surrounds_tissue_is_left_out_of_a_section_and_hides_or_shows_nothing(tmp_path: Path) -> None:
    cache = synthetic.write_cache(tmp_path, step=4.0)
    stage = Usd.Stage.Open(str(cache))
    sheet = UsdGeom.Mesh.Define(stage, "/Procedure/Scenery/sheet")  # black, over the half that the section leaves
    sheet.CreatePointsAttr([(-40, -35, 6), (-2, -35, 6), (-2, 35, 6), (-40, 35, 6)])
    sheet.CreateFaceVertexCountsAttr([4])
    sheet.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    sheet.GetPrim().CreateAttribute("lappet:kind", Sdf.ValueTypeNames.Token).Set("pupil")
    stage.Save()
    black = {}
    for section in (None, (10.0, 0.0, 0.0, 1.0, 0.0, 0.0)):
        (picture,) = render_cache(
            cache, tmp_path / "out", frames=[1], filmstrip=False, size=SIZE, samples=2, threads=2, section=section
        )
        black[section is not None] = (read_png(picture).max(axis=2) < 40).mean()
    assert black[False] > 0.1
    assert black[True] < 0.01


def test_a_section_needs_a_normal(tmp_path: Path) -> None:
    cache = tmp_path / "c.usdc"
    cache.write_bytes(b"")
    for section in ((0.0,) * 6, (0.0, 0.0, 0.0, math.inf, 0.0, 1.0), (0.0, 0.0, 1.0)):
        with refuses(ProblemCode.RENDER_RANGE, "section"):
            render_cache(cache, tmp_path / "out", section=section)
