"""The process that reads USD files of others: `python -m lappet.usd.child`, see `lappet.foreign.reading_child`."""

from __future__ import annotations

import sys

from lappet.foreign.reading_child import serve
from lappet.usd.stage import read_here
from lappet.usd.stage_contents import contents_of, value_sizes

READERS = {
    "procedure": lambda file, limits, _: read_here(file, limits),
    "contents": lambda file, limits, _: contents_of(file, limits),
    "values": lambda file, limits, _: value_sizes(file, limits),
}

if __name__ == "__main__":
    serve(READERS, sys.argv[1:])
