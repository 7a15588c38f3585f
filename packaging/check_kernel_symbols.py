"""No kernel of one instruction set may stand in for a function that other code shares.

A translation unit that is compiled for AVX-512 and holds its own copy of, say, std::vector::resize gives the linker the
choice of that copy for the whole program, which then dies on older processors. So whatever a kernel unit offers to the
linker must be named after the instruction set: a template on its SIMD batch, or its one entry point.

    python packaging/check_kernel_symbols.py OBJECT...     objects named *_sse42.cpp.o, *_avx2.cpp.o, ...
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

# By the end of the unit's name: what a symbol of the set has in its name. Every ARM processor of 64 bits has NEON.
ARCHITECTURES = {
    "sse42": "xsimd::sse4_2",
    "avx2": "xsimd::fma3<xsimd::avx2>",
    "avx512": "xsimd::avx512bw",
}
# nm's letters of code that other units may resolve to: global and weak functions. Constants are the same in every unit.
OFFERED = re.compile(r"^[0-9a-f]* *([TWi]) (.+)$")


def instruction_set(unit: str) -> str | None:
    """The instruction set that an object file's name says it is compiled for; None for scalar code."""
    match = re.search(r"_(sse42|avx2|avx512)\.cpp\.(?:o|obj)$", unit)
    return match.group(1) if match else None


def shared_symbols(listing: str, name: str) -> list[str]:
    """The symbols of `nm --demangle --defined-only` that do not belong to the instruction set alone."""
    found = []
    for line in listing.splitlines():
        match = OFFERED.match(line)
        if match is None:
            continue
        letter, symbol = match.groups()
        own_entry = letter == "T" and re.match(rf"lappet::fill_\w+_{name}\(", symbol)
        if not own_entry and ARCHITECTURES[name] not in symbol:
            found.append(symbol)
    return found


def main(objects: list[str]) -> int:
    """Print every breach; 1 if there is one."""
    bad = checked = 0
    for unit in objects:
        name = instruction_set(Path(unit).name)
        if name is None:
            continue
        checked += 1
        listing = subprocess.run(
            ["nm", "--demangle", "--defined-only", unit], check=True, capture_output=True, text=True
        ).stdout
        for symbol in shared_symbols(listing, name):
            bad += 1
            print(f"{Path(unit).name}: {symbol} is compiled for {name} but may run on every processor")
    if checked == 0:
        print("no kernel unit is among the objects")
        return 1
    if bad == 0:
        print(f"{checked} kernel units offer nothing but their own instruction set's symbols")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
