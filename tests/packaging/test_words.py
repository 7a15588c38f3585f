"""One word per thing: the words that others replaced (GLOSSARY.md) occur in no file of the repository."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TEXT = {".py", ".h", ".cpp", ".md", ".toml", ".txt", ".sh", ".cmake", ".cff", ".usda", ".expected", ""}
# Recorded geometry and the words themselves.
SKIPPED = re.compile(
    r"^(tests/usd/kept/|tests/packaging/test_words\.py$|"
    r"addon/lappet_blender/translation/labels\.toml$|LICENSE$|examples/.*\.usda$|.*\.dat$)"
)


@dataclass(frozen=True)
class Word:
    """A word that is not used, where it is looked for, and what stands in its place.

    `pattern` matches whole words; `under` is a regular expression of the paths that are searched, for words that have
    an ordinary meaning elsewhere.
    """

    pattern: str
    say: str
    under: str = ""


CPP = r"^solverd/"
SOLVER = r"^solverd/(src|tests|benchmarks)/(force|solve|session)/"
ADDON = r"^(addon/|tests/blender/)"
WORDS = (
    Word(r"mend(s|ed|ing)?", "remedy; corrects"),
    Word(r"k(Most|Least)[A-Z0-9]\w*", "kMax…, kMin…"),
    Word(r"(?<!std::)[Tt]ies?", "PointConstraint", SOLVER),
    Word(r"(?i:face_?form)s?", "FaceConstraint"),
    Word(r"Push", "ContactPenalty", CPP),
    Word(r"[Bb]ites?", "AnchorStencil", CPP),
    Word(r"Part(?! of\b)|[Ss]ystem_?[Pp]art", "Subdomain", SOLVER),
    Word(r"part_of", "restrict_to"),
    Word(r"Frame(Level|Matrix|Product|Cholesky|Block|Blocks)\w*", "CoarseLevel, CoarseMatrix, …"),
    Word(r"frame_(level|matrix|product|cholesky|blocks?)\w*", "coarse_level, coarse_matrix, …"),
    Word(r"[Rr]igid[ _][Ff]rames?|RigidFrames?", "RigidMode"),
    Word(r"Definiteness", "PsdProjection"),
    Word(r"Multiplier_?Loop|multiplier_loop", "AugmentedLagrangian"),
    Word(r"judged?", "next", CPP),
    Word(r"Attempts|hopeless", "RetrySchedule"),
    Word(r"fit_to_start", "is_valid_start"),
    Word(r"beyond_reach", "check_targets_reachable"),
    Word(r"(far_)?companions?", "coarse_program"),
    Word(r"FrameError", "FrameErrorEstimate"),
    Word(r"Watcher", "SolveObserver"),
    Word(r"[Hh]appenings|Happening", "WorkerEvent, worker_events"),
    Word(r"contradictions", "event_conflicts"),
    Word(r"pump(s|ed|ing)?|Pump", "solve_timer", ADDON),
    Word(r"shelf|Shelf", "frame_cache", ADDON),
    Word(r"boards?|Board", "display_collection", ADDON),
    Word(r"paces?|Pace", "speed_estimate", ADDON),
    Word(r"single_click|SingleClick", "click_tool"),
    Word(r"vitals", "polled_state"),
    Word(r"(?<=def )(touch|bump)(?=\(self\))|(?<=controller\.)(touch|bump)|(?<=self\.)bump", "mark_dirty", ADDON),
    Word(r"look_around", "drop_idle_clients"),
    # A frame is a time sample of a procedure and nothing else.
    Word(r"[Hh]eader[ _]frames?|(skin|design)_frame", "header part; axes"),
    # One spelling: American.
    Word(
        r"\w*([Ff]ibre|[Cc]olour|[Cc]entre|[Nn]eighbour|[Ll]abelled|[Bb]ehaviour)\w*",
        "fiber, color, center, neighbor, labeled, behavior",
    ),
)
# Files are called after what they do now.
STEMS = {
    "act": "operator_base",
    "attempts": "retry_schedule",
    "bite": "anchor_stencil",
    "board": "display_collection",
    "contradictions": "event_conflicts",
    "dressing": "skin_decorations",
    "exported": "export_usd",
    "fit_to_start": "is_valid_start",
    "frame_stream": "multiprocessing.connection",
    "happenings": "worker_events",
    "imported": "import_usd",
    "multiplier_loop": "augmented_lagrangian",
    "pace": "speed_estimate",
    "part": "subdomain",
    "pull": "hook_tool",
    "pump": "solve_timer",
    "push": "contact_penalty",
    "rigid_frames": "rigid_modes",
    "sew": "suture_tool",
    "shelf": "frame_cache",
    "single_click": "click_tool",
    "ties": "point_constraint",
    "turn": "time_slice",
}


def tracked_files() -> list[str]:
    """Paths of all files that git tracks and that are there, relative to the repository."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [path for path in listed.split("\0") if path and (ROOT / path).is_file()]


FILES = tracked_files()


def uses(word: Word, path: str, text: str) -> list[str]:
    """Every line of a file that uses a word, as `path:line: text`."""
    found = re.compile(rf"(?<![A-Za-z0-9_])(?:{word.pattern})(?![A-Za-z0-9_])")
    lines = enumerate(text.splitlines(), start=1)
    return [f"{path}:{number}: {line.strip()[:120]}" for number, line in lines if found.search(line)]


@pytest.fixture(scope="module")
def texts() -> dict[str, str]:
    """The text files of the repository by their path."""
    readable = [path for path in FILES if Path(path).suffix in TEXT and not SKIPPED.match(path)]
    return {path: (ROOT / path).read_text(encoding="utf-8", errors="replace") for path in readable}


@pytest.mark.parametrize("word", WORDS, ids=lambda word: word.say)
def test_a_replaced_word_is_used_nowhere(word: Word, texts: dict[str, str]) -> None:
    searched = {path: text for path, text in texts.items() if re.match(word.under or "", path)}
    assert searched, f"nothing lies under {word.under}"
    found = [line for path, text in searched.items() for line in uses(word, path, text)]
    assert not found, f"say {word.say}:\n" + "\n".join(found)


def test_no_file_has_a_replaced_name() -> None:
    found = [f"{path}: {STEMS[Path(path).stem]}" for path in FILES if Path(path).stem in STEMS]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("pattern", "text", "expected"),
    [
        (r"mend(s|ed|ing)?", "a remedy, a recommendation", 0),
        (r"mend(s|ed|ing)?", "what mends it", 1),
        (r"FrameError", "class FrameErrorEstimate:", 0),
        (r"(?<!std::)[Tt]ies?", "std::tie(a, b)\nTie tie;", 1),
    ],
)
def test_only_whole_words_count(pattern: str, text: str, expected: int) -> None:
    assert len(uses(Word(pattern, ""), "a.cpp", text)) == expected
