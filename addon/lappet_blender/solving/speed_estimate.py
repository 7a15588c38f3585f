"""How long a frame takes on this machine: seconds per lattice cell as measured by earlier solves, kept in a file."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

from lappet.solve.store import default_folder

_FILE = "speed_estimate.json"
_WEIGHT = 0.2  # of the newest frame in the running mean


class SpeedEstimate:
    """Seconds per cell and frame.

    folder: where the estimate is kept between sessions; a file there that cannot be used is ignored.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / _FILE
        self._rate: float | None = None
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            rate = float(json.loads(self._file.read_text(encoding="utf-8"))["seconds_per_cell"])
            self._rate = rate if rate > 0.0 else None

    def measured(self, cells: float, seconds: float) -> None:
        """A frame of so many cells took so many seconds."""
        if cells > 0.0 and seconds > 0.0:
            rate = seconds / cells
            self._rate = rate if self._rate is None else (1.0 - _WEIGHT) * self._rate + _WEIGHT * rate

    @property
    def known(self) -> bool:
        """Whether anything was measured yet."""
        return self._rate is not None

    def seconds(self, cells: float) -> float | None:
        """What a frame of so many cells will take, or None where nothing was measured yet."""
        return None if self._rate is None or cells <= 0.0 else self._rate * cells

    def keep(self) -> None:
        """Write the measure down."""
        if self._rate is not None:
            with contextlib.suppress(OSError):
                self._file.parent.mkdir(parents=True, exist_ok=True)
                self._file.write_text(json.dumps({"seconds_per_cell": self._rate}), encoding="utf-8")


_speed_estimate: SpeedEstimate | None = None


def speed_estimate() -> SpeedEstimate:
    """The measure of this machine, beside the user's store."""
    global _speed_estimate
    if _speed_estimate is None:
        _speed_estimate = SpeedEstimate(default_folder())
    return _speed_estimate
