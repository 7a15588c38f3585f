"""Read a lesson's file as the viewer does: its JSON, its block, the numbers and positions of an entry."""

from __future__ import annotations

import base64
import json
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def numbers(block: bytes, entry: dict[str, int]) -> NDArray[np.unsignedinteger]:
    """The numbers of an entry of a block."""
    count, width, back = entry["count"], entry["width"], entry["back"]
    planes = np.frombuffer(block, np.uint8, count * width, entry["at"]).reshape(width, count)
    folded = sum(planes[k].astype(np.int64) << (8 * k) for k in range(width))
    difference = (folded >> 1) ^ -(folded & 1)
    made = np.zeros(count, np.int64)
    made[:back] = np.cumsum(difference[:back])
    for begin in range(back, count, back):
        end = min(begin + back, count)
        made[begin:end] = made[begin - back : end - back] + difference[begin:end]
    return (made % (1 << (8 * width))).astype(f"u{width}")


def positions(block: bytes, entry: dict[str, Any]) -> NDArray[np.float64]:
    """The places of an entry in mm, shape (states, places, 3)."""
    whole = numbers(block, entry["array"]).reshape(entry["states"], 3, entry["places"]).transpose(0, 2, 1)
    return np.asarray(entry["low"]) + entry["step"] * whole


@dataclass(frozen=True)
class ReadLesson:
    """A lesson's file."""

    content: dict[str, Any]
    block: bytes

    @staticmethod
    def of(path: Path) -> ReadLesson:
        page = path.read_text(encoding="utf-8")
        data = re.search(r'<script type="application/json" id="lesson">(.*?)</script>', page, re.DOTALL)
        arrays = re.search(r'<script type="text/plain" id="arrays">(.*?)</script>', page, re.DOTALL)
        assert data is not None
        assert arrays is not None
        return ReadLesson(json.loads(data[1]), zlib.decompress(base64.b64decode(arrays[1])))

    def frame(self, frame: int, procedure: int = 0) -> NDArray[np.float64]:
        """Positions of the vertices at a frame, by its index, in mm, shape (n, 3)."""
        for epoch in self.content["procedures"][procedure]["epochs"]:
            if frame in epoch["frames"]:
                return positions(self.block, epoch["positions"])[1 + epoch["frames"].index(frame)]
        raise LookupError(frame)
