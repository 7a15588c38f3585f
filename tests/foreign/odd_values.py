"""What `odd_child` gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Numbers:
    """Some numbers."""

    values: NDArray[Any]
