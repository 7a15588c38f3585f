"""Pictures with their durations as a film: MP4, WebM, GIF, WebP, or numbered PNG files. FFmpeg writes it."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from lappet.core.durable import write_whole
from lappet.core.output_place import check_place
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

SUFFIXES = (".mp4", ".webm", ".gif", ".webp", ".png")
RATE = 24  # pictures per second of the file
_ALPHA = (".webm", ".webp", ".png")
# Colors as all that plays films takes them for granted in a picture of this size, and said besides.
_MATRIX = ":out_color_matrix=bt709:out_range=tv"
_PARAMETERS = "setparams=color_primaries=bt709:color_trc=bt709"
_TOLD = ("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv")
_CODECS = {
    ".mp4": (
        *("-c:v", "libx264", "-preset", "medium", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart"),
        *_TOLD,
    ),
    ".webm": ("-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-pix_fmt", "yuv420p", "-row-mt", "1", *_TOLD),
    ".gif": ("-loop", "0"),
    ".webp": ("-c:v", "libwebp", "-loop", "0", "-quality", "85"),
}
_LOOP_WIDTH = 960  # pixels: loops for pages are made no wider


def check_film(path: Path, size: tuple[int, int], transparent: bool = False) -> str:
    """Refuse a film that cannot be written, before it is drawn.

    Parameters
    ----------
    path
        The file.
    size
        Its width and height in pixels.
    transparent
        Whether the ground is left out.

    Returns
    -------
    str
        Its suffix, in lower case.

    Raises
    ------
    RefusedError
        If its suffix is none of `SUFFIXES` or has no transparency, its folder is missing, or its size is odd or too
        small.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise refused(ProblemCode.FILM_SUFFIX, path, path.suffix, known=", ".join(SUFFIXES))
    if not path.parent.is_dir():
        raise refused(ProblemCode.PLATE_FOLDER, path, path.parent)
    check_place(path)
    if transparent and suffix not in _ALPHA:
        raise refused(ProblemCode.FILM_ALPHA, path, path.suffix, known=", ".join(_ALPHA))
    if min(size) < 240 or size[0] % 2 or size[1] % 2 or size[0] < size[1]:
        raise refused(ProblemCode.FILM_SIZE, path, f"{size[0]}x{size[1]}")
    return suffix


def write_film(
    pictures: Sequence[tuple[Path, float]],
    chapters: Sequence[tuple[float, float, str]],
    title: str,
    path: Path,
    size: tuple[int, int],
    transparent: bool = False,
) -> None:
    """Write a film.

    Parameters
    ----------
    pictures
        The pictures and how many seconds each is shown.
    chapters
        Begin and end in seconds and title of each chapter; GIF, WebP and PNG have none.
    title
        The film's title.
    path
        The file; of PNG files the pattern of their names, to which their numbers are added.
    size
        Its width and height in pixels.
    transparent
        Whether the pictures have an alpha channel that the film keeps.

    Raises
    ------
    RefusedError
        If FFmpeg fails; nothing is written then.
    OSError
        If a file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix == ".png":
        for number, (picture, _) in enumerate(pictures, 1):
            write_whole(path.with_name(f"{path.stem}_{number:04d}.png"), picture.read_bytes())
        return
    from imageio_ffmpeg import get_ffmpeg_exe

    with tempfile.TemporaryDirectory(prefix="lappet_film_") as folder:
        work = Path(folder)
        (work / "list.txt").write_text(_listed(pictures), encoding="utf-8")
        (work / "chapters.txt").write_text(_metadata(chapters, title), encoding="utf-8")
        scale = f"scale={size[0]}:{size[1]}:flags=lanczos{_MATRIX},{_PARAMETERS},fps={RATE}"
        if suffix in (".gif", ".webp"):
            scale = f"fps=12,scale='min({_LOOP_WIDTH},{size[0]})':-2:flags=lanczos"
        if suffix == ".gif":
            scale += ",split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=bayer:bayer_scale=4"
        made = work / f"film{suffix}"
        seconds = sum(each for _, each in pictures)
        done = subprocess.run(
            [
                *(get_ffmpeg_exe(), "-v", "error", "-y", "-f", "concat", "-safe", "0", "-i", str(work / "list.txt")),
                *(
                    "-i",
                    str(work / "chapters.txt"),
                    "-map_metadata",
                    "1",
                    "-map_chapters",
                    "1",
                    "-map",
                    "0:v",
                    "-bitexact",
                ),
                *("-vf", scale, "-t", f"{seconds:.6f}", *_codec(suffix, transparent), str(made)),
            ],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            said = done.stderr.strip().splitlines()
            raise refused(ProblemCode.FILM_FAILED, path, reason=said[-1] if said else "it says nothing")
        write_whole(path, made.read_bytes())


def _codec(suffix: str, transparent: bool) -> tuple[str, ...]:
    """FFmpeg's options of a format."""
    if not transparent:
        return _CODECS[suffix]
    return (*(each for each in _CODECS[suffix] if each not in ("-pix_fmt", "yuv420p")), "-pix_fmt", "yuva420p")


def _listed(pictures: Sequence[tuple[Path, float]]) -> str:
    """FFmpeg's list of pictures; the last one stands twice, since its duration is not honored otherwise."""
    lines = [f"file '{picture}'\nduration {seconds:.6f}" for picture, seconds in pictures]
    return "\n".join([*lines, f"file '{pictures[-1][0]}'"]) + "\n"


def _metadata(chapters: Sequence[tuple[float, float, str]], title: str) -> str:
    lines = [";FFMETADATA1", f"title={_escaped(title)}"]
    for begin, end, text in chapters:
        lines += ["[CHAPTER]", "TIMEBASE=1/1000", f"START={round(1000 * begin)}", f"END={round(1000 * end)}"]
        lines.append(f"title={_escaped(text)}")
    return "\n".join(lines) + "\n"


def _escaped(text: str) -> str:
    for each in "\\=;#\n":
        text = text.replace(each, f"\\{each}")
    return text
