"""What large.py does, with a tissue of 100 000 vertices: `run.py very_large.py --limit 900`."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import run
from large import scenario

if __name__ == "__main__":
    run(partial(scenario, across=371, along=271, patience=5.0), limit=880.0)
