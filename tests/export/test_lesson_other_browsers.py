"""A lesson in Firefox and in WebKitGTK, Safari's engine: every frame stands where the cache has it, and is drawn.

Where a browser is not installed its test is skipped, and says what to install.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest

import other_browsers
from lappet.drawing.skin_read import SkinCache
from lappet.export.glb_file import MOST_DRIFT
from other_browsers import Browser, firefox, webkit

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
_WEBKIT = other_browsers.WEBKIT and other_browsers.XVFB

BROWSERS = [
    pytest.param(
        firefox,
        id="firefox",
        marks=pytest.mark.skipif(not other_browsers.FIREFOX, reason="NOT TRIED: apt-get install firefox-esr"),
    ),
    pytest.param(
        webkit,
        id="webkit",
        marks=pytest.mark.skipif(not _WEBKIT, reason="NOT TRIED: apt-get install webkit2gtk-driver xvfb"),
    ),
]
# How many colors there are in a small copy of the picture, which is one where nothing was drawn.
COLORS = """
const copy = document.createElement("canvas");
copy.width = 80; copy.height = 60;
const pen = copy.getContext("2d");
pen.drawImage(document.querySelector("canvas"), 0, 0, 80, 60);
return new Set(new Uint32Array(pen.getImageData(0, 0, 80, 60).data.buffer)).size;
"""


@pytest.mark.parametrize("browser", BROWSERS)
def test_every_frame_stands_where_the_cache_has_it_and_steps_differ(
    browser: Callable[[], AbstractContextManager[Browser]], lesson_file: Path, skin_cache: Path
) -> None:
    cache = SkinCache(skin_cache)
    with browser() as page:
        page.open(lesson_file)
        page.until("return Boolean(window.lappetLesson)")
        assert page.run("return document.querySelectorAll('#steps li').length") == 4
        assert page.run("return window.lappetLesson.frames().length") == len(cache.frames)
        for k, time in enumerate(cache.frames):
            found = page.run(f"window.lappetLesson.seek({k}); return window.lappetLesson.positions({k})")
            off = np.reshape(found, (-1, 3)) - cache.positions(cache.epoch_at(time), time)
            assert np.linalg.norm(off, axis=1).max() < MOST_DRIFT
        assert page.run(f"window.lappetLesson.seek(6); {COLORS}") > 200
        page.run("document.querySelector('input[value=tension]').click()")
        page.until("return !document.querySelector('#legend').hidden")
        page.run("document.querySelector('#play').click()")
        page.until("return document.querySelector('#play').ariaLabel === 'Pause'")
