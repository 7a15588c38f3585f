"""Open a lesson in a real browser that has no network, and do things in it (`lesson_browser.mjs`)."""

from __future__ import annotations

import atexit
import json
import subprocess
import tempfile
import threading
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import viewer

SCRIPT = Path(__file__).with_suffix(".mjs")
_PATIENCE = 280.0  # seconds for all actions in a lesson


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
    if not device:
        options = {"viewport": {"width": 1000, "height": 560}, **options}
    asked = {"lesson": str(lesson.absolute()), "actions": actions, "device": device, "options": options}
    told = _browser().answer(json.dumps(asked))
    assert "error" not in told, told["error"]
    return Opened(**told)


@cache
def _browser() -> _Browser:
    """The browser of this process: its start takes longer than most of what is done in a lesson."""
    return _Browser()


class _Browser:
    """Chromium, until the tests end; what was opened before is not seen by what is opened next."""

    def __init__(self) -> None:
        node, _ = viewer.node()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115
        self._process = subprocess.Popen(
            [node, SCRIPT], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, text=True
        )
        atexit.register(self._end)

    def answer(self, line: str) -> dict[str, Any]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        late = threading.Timer(_PATIENCE, self._process.kill)
        late.start()
        try:
            self._process.stdin.write(f"{line}\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        finally:
            late.cancel()
        if not answer:  # it was ended; the next lesson gets another
            _browser.cache_clear()
            self._said.seek(0)
            return {"error": f"the browser ended: {self._said.read().decode(errors='replace')}"}
        found: dict[str, Any] = json.loads(answer)
        return found

    def _end(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()  # with its input the script ends, and with it Chromium
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
