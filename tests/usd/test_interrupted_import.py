"""Ctrl-C while USD is loaded ends what runs, whichever of its modules is being imported."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

INTERRUPTED = """
import os, signal, sys

class Finder:
    count = 0
    def find_spec(self, name, path=None, target=None):
        if name.startswith("pxr."):
            Finder.count += 1
            if Finder.count == {nth}:
                os.kill(os.getpid(), signal.SIGINT)
                for _ in range(10000):
                    pass

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Finder())
from lappet.usd.stage import pxr
try:
    pxr()
except KeyboardInterrupt:
    stage = pxr().Usd.Stage.CreateInMemory()
    print("interrupted, and", type(stage).__name__, "is there afterwards")
"""


@pytest.mark.skipif(os.name != "posix", reason="Ctrl-C is no signal here")
@pytest.mark.parametrize("nth", [1, 8, 12, 20])
def test_ctrl_c_is_not_swallowed_by_the_import(nth: int) -> None:
    """At the 12th module it was lost, at the 20th a module stayed half loaded."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED.format(nth=nth)], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.stdout == "interrupted, and Stage is there afterwards\n", done.stdout + done.stderr
