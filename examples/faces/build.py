"""Builds a flap on a face: a model of the body (`lappet models`) and a design of the flap library (`lappet flap`).

Where each lies, and with which measures, stands in `lappet.models.regional_flaps`. The meshes are those of a package
that `lappet models fetch` fetches; so the procedures are not kept here but written.

Usage: python build.py cheek_limberg [cheek_limberg.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model
from lappet.usd.stage import write_procedure

if __name__ == "__main__":
    chosen = sys.argv[1] if len(sys.argv) > 1 else "cheek_limberg"
    if chosen not in REGIONAL_FLAPS:
        sys.exit(f"There is no {chosen!r}; there are {', '.join(REGIONAL_FLAPS)}.")
    path = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(f"{chosen}.usda")
    write_procedure(flap_on_model(chosen), path)
    print(f"wrote {path}")
