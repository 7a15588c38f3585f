"""Read programs and libraries of macOS (Mach-O, 64 bits, one machine): what they load, from when on, their signature.

The structures are those of Apple's <mach-o/loader.h> and <kern/cs_blobs.h>.
"""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass, field

MAGIC = 0xFEEDFACF
LC_ID_DYLIB, LC_RPATH, LC_CODE_SIGNATURE = 0xD, 0x8000001C, 0x1D
LOADS = {0xC, 0x80000018, 0x8000001F}  # LC_LOAD_DYLIB, LC_LOAD_WEAK_DYLIB, LC_REEXPORT_DYLIB
LC_VERSION_MIN_MACOSX, LC_BUILD_VERSION = 0x24, 0x32
SUPER_BLOB, CODE_DIRECTORY = 0xFADE0CC0, 0xFADE0C02
HASHES = {1: "sha1", 2: "sha256"}


@dataclass
class MachO:
    """A file's load commands. Raises ValueError for what is no Mach-O of 64 bits."""

    data: bytes
    machine: int = 0
    name: str = ""
    libraries: list[str] = field(default_factory=list)
    run_paths: list[str] = field(default_factory=list)
    oldest_macos: tuple[int, int] = (0, 0)
    signature: tuple[int, int] | None = None  # place and size in the file

    def __post_init__(self) -> None:
        magic, self.machine, _, _, count, _, _, _ = struct.unpack_from("<8I", self.data)
        if magic != MAGIC:
            raise ValueError(f"a file that begins with {magic:#x} is no Mach-O of 64 bits")
        place = 32
        for _ in range(count):
            command, size = struct.unpack_from("<2I", self.data, place)
            self._read(command, self.data[place : place + size])
            place += size

    def _read(self, command: int, load: bytes) -> None:
        if command in LOADS:
            self.libraries.append(_text(load))
        elif command == LC_ID_DYLIB:
            self.name = _text(load)
        elif command == LC_RPATH:
            self.run_paths.append(_text(load))
        elif command == LC_VERSION_MIN_MACOSX:
            self.oldest_macos = _version(struct.unpack_from("<I", load, 8)[0])
        elif command == LC_BUILD_VERSION:
            self.oldest_macos = _version(struct.unpack_from("<I", load, 12)[0])
        elif command == LC_CODE_SIGNATURE:
            self.signature = struct.unpack_from("<2I", load, 8)


def page_hashes(program: MachO) -> tuple[list[bytes], list[bytes]]:
    """The hashes of its pages that the signature has, and those of the pages themselves; empty without a signature."""
    if program.signature is None:
        return [], []
    start, size = program.signature
    blob = program.data[start : start + size]
    magic, _, count = struct.unpack_from(">3I", blob)
    if magic != SUPER_BLOB:
        raise ValueError(f"a signature that begins with {magic:#x} is none")
    for index in range(count):
        _, place = struct.unpack_from(">2I", blob, 12 + 8 * index)
        if struct.unpack_from(">I", blob, place)[0] == CODE_DIRECTORY:
            return _of_directory(program.data, blob[place:])
    raise ValueError("the signature has no directory of the code")


def _of_directory(data: bytes, directory: bytes) -> tuple[list[bytes], list[bytes]]:
    hashes, _, _, slots, limit = struct.unpack_from(">5I", directory, 16)
    length, kind, _, log_page = struct.unpack_from(">4B", directory, 36)
    signed = [directory[hashes + length * index :][:length] for index in range(slots)]
    pages = (data[first : min(first + (1 << log_page), limit)] for first in range(0, limit, 1 << log_page))
    return signed, [hashlib.new(HASHES[kind], page).digest()[:length] for page in pages]


def _text(load: bytes) -> str:
    (place,) = struct.unpack_from("<I", load, 8)
    return load[place:].partition(b"\0")[0].decode()


def _version(number: int) -> tuple[int, int]:
    return number >> 16, number >> 8 & 0xFF
