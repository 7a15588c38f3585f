"""Write a plan to begin with: commented, with a chapter for each cache and the places that it has."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_source import FigureError
from lappet.export.exported_cache import exported_cache
from lappet.export.lesson_procedure import LessonScene
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.lessons.lesson_places import KINDS, LessonPlaces
from lappet.plates.plate_words import plate_words

_WIDTH = 116


def plan_template(caches: Sequence[Path], target: Path, limits: ReadLimits = DEFAULT_LIMITS) -> str:
    """Make a plan that is a lesson as it stands.

    Parameters
    ----------
    caches
        Solved procedures, a chapter each.
    target
        The file that the plan is for; paths count from its folder.
    limits
        What reading may take.

    Returns
    -------
    str
        The plan, in TOML.

    Raises
    ------
    RefusedError
        If a cache cannot be read or shown.
    """
    lines = [
        "# A lesson of several procedures. Make it with",
        f"#     lappet lesson {target.name} -o {target.stem}.html",
        "# or as a package for a learning platform with -o lesson.zip (SCORM 1.2) or -o lesson.h5p (H5P).",
        "",
        'title = "My lesson"',
        'language = "en"          # that it opens in: en, de, fr, es or zh',
        "# pass = 60              # percent of the questions to be right at the first try; without it nobody fails",
    ]
    titles: dict[str, int] = {}
    for cache in caches:
        title = cache.name.split(".")[0].replace("_", " ").capitalize()
        titles[title] = titles.get(title, 0) + 1
        if titles[title] > 1:
            title = f"{title} {titles[title]}"
        try:
            source = exported_cache(cache, limits)
            shown = LessonScene.of(source, source.frames)
        except FigureError as error:
            raise refused(ProblemCode.EXPORT_CACHE, cache, reason=str(error)) from error
        lines += _chapter(title, _path(cache, target), shown)
    return "\n".join(lines) + "\n"


def _path(cache: Path, target: Path) -> str:
    try:
        return Path(os.path.relpath(cache.absolute(), target.absolute().parent)).as_posix()
    except ValueError:  # on another drive
        return cache.absolute().as_posix()


def _chapter(title: str, path: str, shown: LessonScene) -> list[str]:
    captions = plate_words("en").texts
    steps = [captions[each.key].format(time=f"{each.time:g}") for each in shown.steps]
    places = LessonPlaces(shown)
    by_kind = {kind: [str(each) for each in places if each.kind == kind] for kind in KINDS}
    first = next((names[0] for names in by_kind.values() if names), None)
    lines = [
        "",
        "[[chapter]]",
        f"title = {_quoted(title)}",
        f'cache = {_quoted(path)}        # from this file\'s folder; or procedure = "NAME.usda", to be solved',
        'text = """',
        "What the class should see here. An empty line parts paragraphs.",
        '"""',
        'look = "painted"         # painted, grid, tension, strain or stress',
        'view = "oblique"         # oblique, top, low or behind',
        "step = 1                 # the step that is shown at first:",
        *(f"#   {k}  {step}" for k, step in enumerate(steps, 1)),
        "# frames = [1, 7, 20]    # only these frames",
        "# Places of this procedure:",
        *(line for names in by_kind.values() for line in _wrapped(_in_short(names))),
    ]
    return [*lines, *_questions(first, len(steps))]


def _questions(place: str | None, steps: int) -> list[str]:
    lines = [
        "",
        "  # A question with choices. answer is the number of the right one, or a list of all right ones.",
        "  [[chapter.question]]",
        '  ask = "Which step comes last?"',
        '  choices = ["The incision", "The suture"]',
        "  answer = 2",
        '  right = "Yes: the wound is closed at the end."',
        '  wrong = "No: look at the last step."',
        f"  step = {max(1, steps)}               # the step that is shown with it",
    ]
    if place is None:
        return lines
    return [
        "",
        "  # A numbered mark on the tissue, with a text.",
        "  [[chapter.hotspot]]",
        f"  place = {_quoted(place)}",
        '  title = "Look here"',
        '  text = "What there is to see."',
        *lines,
        "",
        "  # A question that is answered on the tissue: right is whatever lies within so many mm of the place.",
        "  [[chapter.question]]",
        f'  ask = "Where is {place}?"',
        f"  place = {_quoted(place)}",
        "  within = 6.0",
        '  right = "Yes, there it is."',
        '  wrong = "No, it is elsewhere."',
        '  # candidates = ["corner a", "corner b"]   # offered to those who answer from a list; else all of the kind',
    ]


def _in_short(names: Sequence[str]) -> list[str]:
    """Names, those that are numbered as one range each: "suture skin_1 to skin_17"."""
    groups: dict[str, list[int]] = {}
    for name in names:
        stem = name.rstrip("0123456789")
        groups.setdefault(stem, []).extend([int(name[len(stem) :])] if stem != name else [])
    short = []
    for stem, numbers in groups.items():
        last = f" to {stem.partition(' ')[2]}{max(numbers)}" if len(numbers) > 1 else ""
        short.append(f"{stem}{min(numbers) if numbers else ''}{last}")
    return short


def _wrapped(names: Sequence[str]) -> list[str]:
    lines, line = [], "#  "
    for name in names:
        if len(line) + len(name) > _WIDTH:
            lines.append(line.rstrip())
            line = "#  "
        line += f" {name},"
    return [*lines, line.rstrip(",")] if names else []


def _quoted(text: str) -> str:
    """A text as TOML writes it; its escapes are those of JSON."""
    return json.dumps(text, ensure_ascii=False)
