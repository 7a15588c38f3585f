"""The process that reads mesh files: `python -m lappet.tissue.mesh_child`, see `lappet.foreign.reading_child`."""

from __future__ import annotations

import sys

from lappet.foreign.reading_child import serve
from lappet.tissue.mesh_file import read_mesh_here

READERS = {"mesh": lambda file, limits, units: read_mesh_here(file, limits, units or None)}

if __name__ == "__main__":
    serve(READERS, sys.argv[1:])
