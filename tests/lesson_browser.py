"""Open a lesson in a real browser that has no network, and do things in it (`lesson_browser.mjs`)."""

from __future__ import annotations

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import viewer

SCRIPT = Path(__file__).with_suffix(".mjs")


@dataclass(frozen=True)
class Opened:
    """What came of it: the result of each action, what the console said, what the page asked for."""

    results: list[Any]
    console: list[str]
    requests: list[str]


def opened(lesson: Path, *actions: tuple[str, Any], device: str = "", **options: Any) -> Opened:
    """Open a lesson, or a folder as a site, and do the actions in turn.

    device: one that Playwright describes, such as "iPhone 13".
    """
    node, _ = viewer.node()
    with tempfile.TemporaryDirectory() as work:
        plan = Path(work) / "plan.json"
        if not device:
            options = {"viewport": {"width": 1000, "height": 560}, **options}
        plan.write_text(json.dumps({"actions": actions, "device": device, "options": options}), encoding="utf-8")
        done = subprocess.run(
            [node, SCRIPT, lesson.absolute(), plan], capture_output=True, text=True, check=False, timeout=280
        )
    assert done.returncode == 0, done.stderr
    return Opened(**json.loads(done.stdout))
